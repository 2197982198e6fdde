"""Two runs are compared by time or by phase, and what came nearer is told."""

from base64 import b64encode

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import HERE, balls, poses  # noqa: F401

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings import IncompleteRecordingError, clearance, compare_runs


def run_past(folder, times, x):
    """Record a ball that goes by the box along x, and its height above it."""
    rows = [[(a, 0.0, 0.5 + 0.0 * a, 0, 0, 0, 1), HERE] for a in x]
    return recorder.record(folder, poses(times, 'ab', rows))


def test_by_phase_it_does_not_matter_how_fast_a_run_is(tmp_path, balls):  # noqa: F811
    x = np.linspace(-1.0, 1.0, 2001)
    slow = run_past(tmp_path / 'slow', 0.01 * np.arange(2001), x)
    # The same way at twice the speed, with a rest in its middle.
    stop = np.concatenate((x[:1001:2], np.repeat(x[1000], 300), x[1000::2]))
    fast = run_past(tmp_path / 'fast', 0.01 * np.arange(len(stop)), stop)
    one, other = (clearance(run, balls, between=['a:b']) for run in (slow, fast))
    assert one.travelled[-1] == pytest.approx(2.0)
    assert other.travelled[-1] == pytest.approx(2.0)
    (by_phase,) = compare_runs(one, other, by='phase')
    assert by_phase.is_whole.mean() > 0.9
    assert np.nanmax(np.abs(by_phase.difference)) < 0.003
    (by_time,) = compare_runs(one, other)
    assert np.nanmax(np.abs(by_time.difference)) > 0.1
    assert not by_time.is_whole[-1]  # the other one had ended
    (pair,) = by_time.pairs
    assert (pair.run, pair.other) == (pytest.approx(0.3), pytest.approx(0.3))


def test_what_came_nearer_is_told_and_is_an_exit_code(tmp_path, balls, capsys):  # noqa: F811
    times, x = 0.1 * np.arange(50), np.linspace(1.0, 2.0, 50)
    old = run_past(tmp_path / 'old', times, x)
    nearer = x.copy()
    nearer[20] -= 0.05
    new = run_past(tmp_path / 'new', times, nearer)
    (found,) = compare_runs(*(clearance(r, balls, between=['a:b']) for r in (new, old)))
    much, where = found.nearer()
    assert 0.03 < much < 0.06
    assert where == pytest.approx(2.0, abs=0.01)

    def report(run, other, *more):
        arguments = [run, '--scene', balls, '--between', 'a:b', '--compare', other]
        arguments += ['--out', tmp_path / 'out', *more]
        return main(['report', *map(str, arguments)])

    assert report(new, old) == 4
    assert 'nearer' in capsys.readouterr().out
    assert (tmp_path / 'out' / 'comparison.png').exists()
    page = (tmp_path / 'out' / 'report.html').read_text()
    beside = b64encode((tmp_path / 'out' / 'comparison.png').read_bytes()).decode()
    assert beside in page
    (pair,) = found.pairs
    cells = (pair.name_A, pair.name_B, f'{pair.run:.9g}', f'{pair.other:.9g}')
    assert ''.join(f'<td>{cell}</td>' for cell in cells) in page.replace(' class=n', '')
    assert report(new, old, '--tolerance', '0.1') == 0
    assert report(old, new) == 0
    short = run_past(tmp_path / 'short', times[:20], x[:20])
    assert report(old, short) == 1  # of what the other one does not have nobody knows
    (found,) = compare_runs(*(clearance(r, balls, between=['a:b']) for r in (old, short)))
    assert 0.3 < found.is_whole.mean() < 0.7  # a state holds for a second
    assert not found.is_whole[-1]
    with pytest.raises(ArgumentError, match='other sets'):
        compare_runs(clearance(new, balls), clearance(old, balls, between=['a:b']))
    with pytest.raises(ArgumentError, match='one of time, phase'):
        compare_runs(clearance(new, balls), clearance(old, balls), by='weather')


def test_what_the_other_run_does_not_tell_is_said(tmp_path, balls, capsys):  # noqa: F811
    times, x = 0.1 * np.arange(50), np.linspace(1.0, 2.0, 50)
    run = run_past(tmp_path / 'run', times, x)
    late = run_past(tmp_path / 'late', times + 5.0 * (times > 2.0), x)  # silent for 5 s
    (found,) = compare_runs(
        *(clearance(r, balls, between=['a:b']) for r in (run, late)), by='phase'
    )
    assert not found.not_known_of_run
    assert found.not_known_of_other == ('1 gap without data, 5.100 s in all',)
    with pytest.raises(IncompleteRecordingError, match='the other run: 1 gap'):
        found.nearer()
    assert found.nearer(allow_incomplete=True)[0] == 0.0
    out = tmp_path / 'out'
    asked = ['report', run, '--scene', balls, '--between', 'a:b', '--compare', late, '--by']
    assert main([*map(str, asked), 'phase', '--pictures', '0', '--out', str(out)]) == 1
    assert f'not known of {late}: 1 gap without data' in capsys.readouterr().out
    assert 'The other run: Not all is known:<ul><li>1 gap' in (out / 'report.html').read_text()
