"""States that are kept in a file tell what those in memory do; what is interrupted goes on."""

import os
import signal
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import HERE, balls, poses, random_rows  # noqa: F401

from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import clearance, compare_runs, recording, run, states
from drake_geom_ros.recordings.comparing import SetComparison
from drake_geom_ros.recordings.highlights import highlights
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.pair_sets import pair_sets
from drake_geom_ros.recordings.report_plot import draw
from drake_geom_ros.recordings.report_tables import write_csv, write_npz
from drake_geom_ros.recordings.run import Run, RunOptions
from drake_geom_ros.recordings.stored_states import StoredClearances, StoredStates

BETWEEN = ['a:b', 'floor:a']
TESTS = Path(__file__).parents[1]


@pytest.fixture
def recorded(tmp_path):
    """Return a recording in which b waits at first, things touch, and a sender falls silent."""
    rows, times = 0.22 * random_rows(120, 2, seed=4), 0.05 * np.arange(120)
    rows[..., 3:] /= np.linalg.norm(rows[..., 3:], axis=-1, keepdims=True)
    messages = poses(times[:10], 'a', rows[:10, 0]) + poses(times[10:60], 'ab', rows[10:60])
    messages += poses(times[60:], 'a', rows[60:, 0]) + poses([9.0, 9.1], 'ab', rows[:2])
    return recorder.record(tmp_path / 'run', messages)


def kept_in(folder, recorded, scene, asked=(), **more):
    """Return a pass through a recording, and what it keeps."""
    opened = opened_recording(
        recorded,
        scene=scene,
        topics=None,
        stale_after=1.0,
        accuracy='exact',
        world_frame='world',
        package_roots=(),
    )
    question = RunOptions(sets=pair_sets(BETWEEN), **more)
    certified = bool(question.certify)
    return Run(opened, question), StoredStates(folder, BETWEEN, dict(asked), certified=certified)


def all_of(passing, kept):
    list(passing.parts(kept))
    return StoredClearances.of(passing.facts(), kept)


def flat(value):
    """Return numbers and names of what is nested, for comparison."""
    if hasattr(value, '__dataclass_fields__'):
        return {n: flat(getattr(value, n)) for n in value.__dataclass_fields__ if n != 'block'}
    if isinstance(value, dict):
        return {name: flat(each) for name, each in value.items()}
    if isinstance(value, (tuple, list)):
        return [flat(each) for each in value]
    return value


@pytest.mark.parametrize('certify', [0.0, 0.001])
@pytest.mark.parametrize('most', [1, 7, 1000])
def test_a_file_tells_what_memory_tells(tmp_path, recorded, balls, monkeypatch, most, certify):  # noqa: F811
    whole = clearance(recorded, balls, between=BETWEEN, certify=certify)
    monkeypatch.setattr(states, '_MOST_STATES', most)
    found = all_of(*kept_in(tmp_path / 'kept', recorded, balls, certify=certify))
    assert found.count == len(whole.times)
    assert found.reservations() == whole.reservations()
    np.testing.assert_equal(
        flat(found.least(allow_incomplete=True)), flat(whole.least(allow_incomplete=True))
    )
    np.testing.assert_equal(flat(found.moments['a:b']), flat(whole.moments['a:b']))
    thresholds = 0.0, 0.1
    own, other = highlights(found, thresholds), highlights(whole, thresholds)
    assert own['a:b'].contact_count > 3
    assert own['a:b'].lost
    for name in BETWEEN:
        assert own[name].held == pytest.approx(other[name].held)
        for what in ('contacts', 'contact_count', 'ages', 'lost', 'shown'):
            mine, theirs = (flat(getattr(each[name], what)) for each in (own, other))
            np.testing.assert_equal(mine, theirs)
        np.testing.assert_allclose(own[name].below, other[name].below, rtol=0, atol=1e-9)
        if certify:
            assert found.certified(name) == whole[name].certified()
    assert draw(found, own, thresholds, 'x') == draw(whole, other, thresholds, 'x')
    tables = []
    for each in (found, whole):
        write_csv(each, tmp_path / 'x.csv')
        write_npz(each, tmp_path / 'x.npz')
        tables.append((tmp_path / 'x.csv').read_text())
        arrays = dict(np.load(tmp_path / 'x.npz'))
        tables.append(arrays)
    assert tables[0] == tables[2]
    np.testing.assert_equal(tables[1], tables[3])
    np.testing.assert_array_equal(tables[1]['distance_0'], whole['a:b'].distance)
    np.testing.assert_array_equal(tables[1]['p_WCb_1'], whole['floor:a'].p_WCb)
    for by in ('time', 'phase'):
        pairs = zip(compare_runs(found, whole, by), compare_runs(whole, found, by), strict=True)
        for one, back in pairs:
            assert isinstance(one, SetComparison)
            np.testing.assert_array_equal(one.run, back.run)
            np.testing.assert_array_equal(one.run, one.other)
            np.testing.assert_array_equal(one.is_whole, back.is_whole)
            assert one.nearer(allow_incomplete=True)[0] == 0.0


@pytest.mark.parametrize('certify', [0.0, 0.001])
@pytest.mark.parametrize('harm', ['none', 'half a line', 'half a block', 'a byte', 'no rows'])
def test_what_was_interrupted_goes_on(tmp_path, recorded, balls, monkeypatch, harm, certify):  # noqa: F811
    monkeypatch.setattr(states, '_MOST_STATES', 10)
    expected = all_of(*kept_in(tmp_path / 'expected', recorded, balls, certify=certify))
    passing, kept = kept_in(tmp_path / 'kept', recorded, balls, certify=certify)
    parts = passing.parts(kept)
    for _ in range(6):
        next(parts)
    parts.close()
    rows, lines = tmp_path / 'kept' / 'states', tmp_path / 'kept' / 'blocks.jsonl'
    left = 6
    if harm == 'half a line':
        lines.write_bytes(lines.read_bytes()[:-7])
        left = 5
    elif harm == 'half a block':
        rows.write_bytes(rows.read_bytes()[:-7])
        left = 5
    elif harm == 'a byte':
        data = bytearray(rows.read_bytes())
        data[len(data) // 6 * 2 + 50] ^= 1  # in the third block
        rows.write_bytes(data)
        left = 2
    elif harm == 'no rows':
        rows.unlink()
        left = 0
    asked = []
    answered = Run._computed
    monkeypatch.setattr(Run, '_computed', lambda *a: asked.append(1) or answered(*a))
    passing, kept = kept_in(tmp_path / 'kept', recorded, balls, certify=certify)
    found = all_of(passing, kept)
    blocks = sum(1 for _ in expected.parts())
    assert len(asked) == blocks - left
    for own, other in zip(found.parts(), expected.parts(), strict=True):
        np.testing.assert_equal(flat(own), flat(other))
    assert lines.read_bytes() == (tmp_path / 'expected' / 'blocks.jsonl').read_bytes()
    assert rows.read_bytes() == (tmp_path / 'expected' / 'states').read_bytes()
    np.testing.assert_equal(flat(found.moments['a:b']), flat(expected.moments['a:b']))


def test_what_was_asked_otherwise_does_not_count(tmp_path, recorded, balls, monkeypatch):  # noqa: F811
    monkeypatch.setattr(states, '_MOST_STATES', 10)
    all_of(*kept_in(tmp_path / 'kept', recorded, balls, {'distance': 1}))
    asked = []
    answered = Run._computed
    monkeypatch.setattr(Run, '_computed', lambda *a: asked.append(1) or answered(*a))
    all_of(*kept_in(tmp_path / 'kept', recorded, balls, {'distance': 1}))
    assert not asked
    all_of(*kept_in(tmp_path / 'kept', recorded, balls, {'distance': 2}))
    assert asked


KILLED = """
import os, signal, sys
from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import stored_states, states
states._MOST_STATES = 10
put, done = stored_states.StoredStates.add, []
def add(self, *given):
    put(self, *given)
    done.append(1)
    if len(done) == 5:
        os.kill(os.getpid(), signal.SIGKILL)
stored_states.StoredStates.add = add
main(sys.argv[1:])
"""


@pytest.mark.processes
def test_a_report_that_was_killed_goes_on(tmp_path, recorded, balls, monkeypatch):  # noqa: F811
    asked = ['report', recorded, '--scene', balls, '--between', 'a:b', '--pictures', 1, '--out']
    arguments = [*map(str, asked), str(tmp_path / 'out')]
    environment = {**os.environ, 'PYTHONPATH': f'{TESTS.parent}:{os.environ["PYTHONPATH"]}'}
    done = subprocess.run([sys.executable, '-c', KILLED, *arguments], env=environment, check=False)
    assert done.returncode == -signal.SIGKILL
    assert [each.name for each in (tmp_path / 'out').iterdir()] == ['unfinished']
    monkeypatch.setattr(states, '_MOST_STATES', 10)
    computed = []
    answered = run.Run._computed
    monkeypatch.setattr(run.Run, '_computed', lambda *a: computed.append(1) or answered(*a))
    assert main([*arguments, '--resume']) == 1
    resumed = len(computed)
    assert main([*map(str, asked), str(tmp_path / 'whole')]) == 1
    assert len(computed) - resumed == resumed + 5
    names = {each.name for each in (tmp_path / 'whole').iterdir()}
    assert {each.name for each in (tmp_path / 'out').iterdir()} == names
    for name in ('clearance.csv', 'clearance.png'):
        own, other = (tmp_path / folder / name for folder in ('out', 'whole'))
        assert own.read_bytes() == other.read_bytes()
    arrays = [dict(np.load(tmp_path / f / 'clearance.npz')) for f in ('out', 'whole')]
    np.testing.assert_equal(*arrays)


def test_memory_does_not_grow_with_the_length_of_a_recording(tmp_path, balls, monkeypatch):  # noqa: F811
    monkeypatch.setattr(states, '_MOST_STATES', 200)
    monkeypatch.setattr(recording, '_MOST_MESSAGES', 200)
    peaks = []
    for count in (300, 2000, 20_000):
        times = 0.01 * np.arange(count)
        x = 0.6 + 0.3 * np.cos(times)
        rows = [[HERE, (each, 0, 0, 0, 0, 0, 1)] for each in x]
        path = recorder.record(tmp_path / f'run_{count}', poses(times, 'ab', rows))
        del rows
        out = tmp_path / f'out_{count}'
        tracemalloc.start()
        options = ['--scene', balls, '--between', 'a:b', '--pictures', 0, '--out', out]
        assert main(['report', *map(str, (path, *options))]) == 0
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # The first one has all kernels and fonts read. The states of the last one are 2 MB.
    assert peaks[2] - peaks[1] < 500_000
