"""A report counts as done where the same was asked of the same files, and with its exit code."""

import json
import shutil

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import HERE, balls, poses  # noqa: F401

from drake_geom_ros.command_line import report
from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import states
from drake_geom_ros.recordings.run import Run


@pytest.fixture
def runs(tmp_path):
    """Return a folder of two runs in which a ball stands above the box."""
    for k, height in enumerate((0.4, 0.5)):
        rows = [[(0.01 * j, 0, height, 0, 0, 0, 1), HERE] for j in range(5)]
        recorder.record(tmp_path / 'runs' / f'run_{k}', poses(0.1 * np.arange(5), 'ab', rows))
    return tmp_path / 'runs'


@pytest.fixture
def asked(tmp_path, runs, balls, capsys):  # noqa: F811
    """Return a function that makes reports, and returns the exit code and which runs were left."""

    def ask(*more, scene=balls):
        arguments = ['report', runs, '--scene', scene, '--between', 'a:b', '--pictures', 0]
        code = main([*map(str, arguments), '--out', str(tmp_path / 'out'), *map(str, more)])
        said = capsys.readouterr().out
        return code, [name for name in ('run_0', 'run_1') if f'{name}: there is a report' in said]

    return ask


def test_what_is_the_same_is_left_out_and_its_exit_code_counts(asked, runs, tmp_path):
    far = tmp_path / 'far'
    rows = [[(0.01 * j, 0, 0.9, 0, 0, 0, 1), HERE] for j in range(5)]
    recorder.record(far, poses(0.1 * np.arange(5), 'ab', rows))
    assert asked('--compare', far) == (4, [])
    assert asked('--compare', far, '--resume') == (4, ['run_0', 'run_1'])
    assert asked('--compare', far, '--tolerance', 1, '--resume') == (0, [])
    shutil.rmtree(far)
    recorder.record(far, poses(0.1 * np.arange(4), 'ab', rows[:4]))
    assert asked('--compare', far, '--tolerance', 1, '--resume') == (0, [])


def test_another_scene_option_file_or_version_is_another_report(asked, runs, balls, monkeypatch):  # noqa: F811
    both = ['run_0', 'run_1']
    assert asked() == (0, [])
    assert asked('--resume') == (0, both)
    assert asked('--resume', '--max-distance', 0.2) == (0, [])
    assert asked('--resume', '--max-distance', 0.2) == (0, both)
    balls.write_text(balls.read_text().replace('radius: 0.1', 'radius: 0.11'))
    assert asked('--resume', '--max-distance', 0.2) == (0, [])
    rows = [[(0.01 * j, 0, 0.6, 0, 0, 0, 1), HERE] for j in range(5)]
    shutil.rmtree(runs / 'run_1')
    recorder.record(runs / 'run_1', poses(0.1 * np.arange(5), 'ab', rows))
    assert asked('--resume', '--max-distance', 0.2) == (0, ['run_0'])


def test_a_report_without_its_record_or_files_is_made_again(asked, tmp_path):
    assert asked() == (0, [])
    (tmp_path / 'out' / 'run_0' / 'report.json').write_text('{"version"')
    (tmp_path / 'out' / 'run_1' / 'clearance.csv').unlink()
    assert asked('--resume') == (0, [])
    kept = json.loads((tmp_path / 'out' / 'run_0' / 'report.json').read_text())
    kept['version'] = 'of another year'
    (tmp_path / 'out' / 'run_0' / 'report.json').write_text(json.dumps(kept))
    assert asked('--resume') == (0, ['run_1'])


def test_nothing_of_an_earlier_report_lies_beside_a_new_one(asked, runs, tmp_path):
    assert asked('--compare', runs / 'run_0', '--tolerance', 1)[0] == 0
    out = tmp_path / 'out' / 'run_0'
    assert (out / 'comparison.csv').exists()
    assert (out / 'comparison.png').exists()
    (out / 'audit.csv').write_text('of an audit')
    assert asked() == (0, [])
    names = ['clearance.csv', 'clearance.npz', 'clearance.png', 'report.html', 'report.json']
    assert sorted(each.name for each in out.iterdir()) == names


@pytest.mark.parametrize(
    ('codes', 'worst'), [((3, 4), 3), ((0, 1), 1), ((2, 3), 3), ((1, 2), 2), ((2, 4), 4)]
)
def test_the_gravest_run_is_the_exit_code(asked, monkeypatch, codes, worst):
    left = list(codes)
    monkeypatch.setattr(report, 'make_report', lambda *_: left.pop(0))
    assert asked() == (worst, [])


def test_a_run_that_fails_does_not_end_the_others(asked, tmp_path, capsys):
    assert asked('--between', 'nobody:a') == (2, [])  # an ArgumentError of each
    taken = tmp_path / 'out' / 'run_0' / 'report.html'
    taken.mkdir(parents=True)  # an OSError: a folder stands where the page is to be
    assert asked()[0] == 2
    assert (tmp_path / 'out' / 'run_1' / 'report.html').is_file()


def test_a_report_beside_a_compressed_recording_is_made_again(tmp_path, balls):  # noqa: F811
    rows = [[(0.01 * j, 0, 0.4, 0, 0, 0, 1), HERE] for j in range(5)]
    told = poses(0.1 * np.arange(5), 'ab', rows)
    run = recorder.record(tmp_path / 'run', told, compressed='file')
    asked = ['report', run, '--scene', balls, '--between', 'a:b', '--out', run]
    assert main(list(map(str, asked))) == 0
    assert main([*map(str, asked), '--resume']) == 0
    assert main(list(map(str, asked))) == 0


CUBE = """v 0 0 0
v {0} 0 0
v 0 {0} 0
v 0 0 {0}
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""
URDF = """<robot name="thing"><link name="body"><collision><geometry>
<mesh filename="package://shapes/{}.obj"/></geometry></collision></link>
<link name="world"/><joint name="hold" type="floating"><parent link="world"/>
<child link="body"/></joint><link name="stone"><collision><geometry><sphere radius="0.1"/>
</geometry></collision></link><joint name="lie" type="floating"><parent link="world"/>
<child link="stone"/></joint></robot>"""


def test_files_that_a_later_description_names_count(tmp_path, capsys):
    shapes = tmp_path / 'packages' / 'shapes'
    shapes.mkdir(parents=True)
    for name in 'ab':
        (shapes / f'{name}.obj').write_text(CUBE.format(1.0))
    messages = [
        *(
            (t, '/robot_description', recorder.text(URDF.format(n)))
            for t, n in ((0, 'a'), (1, 'b'))
        ),
        *poses(0.1 + 0.2 * np.arange(10), ['thing::body', 'thing::stone'], [[HERE, HERE]] * 10),
    ]
    messages.sort(key=lambda entry: entry[0])
    run = recorder.record(tmp_path / 'run', messages)
    asked = ['report', run, '--package-root', tmp_path / 'packages', '--out', tmp_path / 'out']
    asked += ['--pictures', 0, '--resume']

    def is_left_out():
        code = main(list(map(str, asked)))
        assert code in (0, 1)
        return 'there is a report of the same' in capsys.readouterr().out

    assert [is_left_out(), is_left_out()] == [False, True]
    (shapes / 'b.obj').write_text(CUBE.format(2.0))
    assert [is_left_out(), is_left_out()] == [False, True]
    (shapes / 'b.obj').unlink()  # the second description is refused, which may be mended
    assert [is_left_out(), is_left_out()] == [False, False]
    (shapes / 'b.obj').write_text(CUBE.format(1.0))
    assert [is_left_out(), is_left_out()] == [False, True]


@pytest.mark.parametrize('blocks', [0, 2])
def test_an_interrupt_is_said_and_what_was_computed_goes_on(
    runs,
    balls,  # noqa: F811
    tmp_path,
    capsys,
    monkeypatch,
    blocks,
):
    monkeypatch.setattr(states, '_MOST_STATES', 1)
    answered, asked = Run._computed, []

    def interrupted(*arguments):
        asked.append(1)
        if len(asked) > blocks:
            raise KeyboardInterrupt
        return answered(*arguments)

    out = tmp_path / 'out'
    command = ['report', runs / 'run_0', '--scene', balls, '--out', out, '--pictures', '0']
    with monkeypatch.context() as harm:
        harm.setattr(Run, '_computed', interrupted)
        assert main(list(map(str, command))) == 130
    kept = f'--resume goes on with {out / "unfinished"}\n' if blocks else ''
    assert capsys.readouterr().err == f'{kept}drake_geom_ros: interrupted\n'
    assert (out / 'unfinished').is_dir() == bool(blocks)
    assert main([*map(str, command), '--resume']) == 0
    assert (out / 'report.json').exists()
