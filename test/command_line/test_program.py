"""The program as it is started: exit codes, one line for an error, no ROS."""

import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line import query
from drake_geom_ros.command_line.program import main

SCENE = str(ROOT / 'scenes/minimal.yaml')


def start(*arguments):
    return subprocess.run(
        [sys.executable, '-m', 'drake_geom_ros', *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=240,
    )


@pytest.mark.processes
def test_it_runs_as_a_module():
    done = start('query', 'scenes/minimal.yaml', '--max-distance', '0.5')
    assert done.returncode == 0, done.stderr
    header, row = done.stdout.splitlines()
    assert header.startswith('geometry_a,geometry_b,distance,')
    assert row.startswith('scene::world/post,scene::ball/ball,0.35,')


@pytest.mark.processes
def test_what_a_scene_needs_is_compiled_beforehand():
    done = start('compile', 'scenes/minimal.yaml')
    assert done.returncode == 0, done.stderr
    assert 'kernels are ready, in ' in done.stdout.splitlines()[-1]
    again = start('compile', 'scenes/minimal.yaml')
    assert len(again.stdout.splitlines()) == 1


@pytest.mark.processes
def test_a_reader_that_leaves_early_is_no_error():
    script = f'{sys.executable} -m drake_geom_ros check {SCENE} | true; echo "${{PIPESTATUS[0]}}"'
    done = subprocess.run(
        ['bash', '-c', script], cwd=ROOT, capture_output=True, text=True, timeout=240
    )
    assert done.stdout.strip() in ('0', '141')
    assert done.stderr == ''


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['query', '/nowhere.yaml'], ['/nowhere.yaml', 'cannot be read']),
        (['query', SCENE, '--poses', 'poses.txt'], ['poses.txt', '.csv', '.json']),
        (['query', SCENE, '--poses', '/nowhere.csv'], ['/nowhere.csv']),
        (['query', SCENE, '--what', 'points'], ['--points']),
        (['query', SCENE, '--points', 'p.csv'], ['--what points']),
        (['query', SCENE, '--what', 'points', '--points', '/nowhere.csv'], ['/nowhere.csv']),
        (['query', SCENE, '--output', '/nowhere/out.csv'], ['/nowhere/out.csv']),
        (['convert', SCENE, 'out.txt'], ['out.txt', '.yaml']),
        (['convert', SCENE, '/nowhere/out.yaml'], ['/nowhere/out.yaml']),
    ],
)
def test_what_cannot_be_is_said_in_one_line(capsys, arguments, words):
    assert main(arguments) == 2
    output, errors = capsys.readouterr()
    assert output == ''
    assert errors.count('\n') == 1
    for word in words:
        assert word in errors


def test_an_interrupt_is_no_traceback(capsys, monkeypatch):
    def interrupted(options):
        raise KeyboardInterrupt

    monkeypatch.setattr(query, 'run', interrupted)
    assert main(['query', SCENE]) == 130
    assert capsys.readouterr().err == 'drake_geom_ros: interrupted\n'


@pytest.mark.parametrize(
    'arguments',
    [
        [],
        ['dance'],
        ['query'],
        ['query', SCENE, '--what', 'weather'],
        ['query', SCENE, '--max-distance', '-1'],
        ['query', SCENE, '--max-distance', 'nan'],
        ['query', SCENE, '--max-distance', 'far'],
        ['query', SCENE, '--accuracy', 'superb'],
    ],
)
def test_wrong_usage_is_exit_code_2(capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert 'usage:' in capsys.readouterr().err
