"""Messages that are taken many at once are answered, to the bit, as they are one by one."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from recordings import recorder

from drake_geom_ros.recordings import clearance, player

CELL = Path(__file__).parents[1] / 'batch' / 'cell.yaml'
URDF = CELL.with_name('arm.urdf').read_text()
# The tray waits for its first pose, and the arm's base is posed by the scene file.
TEXT = CELL.read_text().replace(', pose: {position: [0.6, 0.1, 0.4]}', '')
NAMES = ('turn', 'bend', 'roll', 'slide')
HERE = (0, 0, 0, 0, 0, 0, 1)


@pytest.fixture
def scene(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    file = tmp_path / 'cell.yaml'
    file.write_text(TEXT)
    return file


def quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def joints(rng, t, names=NAMES, late=0.0):
    return recorder.joint_state(t - late, names, rng.uniform(0.0, 0.1, len(names)))


def tray(rng, t):
    row = (*rng.uniform(0.3, 0.9, 3), *quaternion(rng))
    return recorder.frame_poses(t, ['things::tray'], row)


def disturbances(rng, t):
    """Yield what is no part of a run, or not always."""
    kind = rng.integers(9)
    if kind == 0:
        yield t, '/joint_states', joints(rng, t, NAMES[:2])  # another sender of the same
    elif kind == 1:
        message = joints(rng, t)
        message.position[1] = np.nan
        yield t, '/joint_states', message
    elif kind == 2:
        message = joints(rng, t)
        message.position[3] = 1e305
        yield t, '/joint_states', message
    elif kind == 3:
        message = tray(rng, t)
        message.poses[3:] = 0.0
        yield t, '/poses', message
    elif kind == 4:
        row = (*rng.normal(size=3), *quaternion(rng))
        yield t, '/poses', recorder.frame_poses(t, ['arm::base'], row)
    elif kind == 5:
        yield t, '/tf', recorder.transforms(t, ('hand', 'tray', HERE))  # it hangs on the arm
    elif kind == 6:
        yield t, '/tf', recorder.transforms(t, ('world', 'tray', HERE))
    elif kind == 7:
        yield t, '/joint_states', recorder.joint_state(t, ['wheel'], [0.0])
    else:
        message = joints(rng, t)
        message.velocity = rng.normal(size=4)
        yield t, '/joint_states', message


def messages(seed, count, *, split, clock, sparse):
    """Return messages of an arm and a tray, of some senders, disturbed now and then."""
    rng = np.random.default_rng(seed)
    found, again, offset = [], None, 0.0
    for k in range(count):
        t = 0.02 * k + (3.0 if k > count // 2 else 0.0)
        if clock and rng.random() < 0.7:
            offset += 70.0 if rng.random() < 0.02 else 0.0
            found.append((t - 0.003, '/clock', recorder.clock(recorder.BEGIN / 1e9 + t + offset)))
        if split:
            found.append((t, '/joint_states', joints(rng, t, NAMES[:3], rng.choice([0.0, 1.5]))))
            if k % 3 == 0 and k > 5:
                found.append((t + 0.001, '/joint_states', joints(rng, t, NAMES[3:])))
        else:
            again = joints(rng, t) if again is None or rng.random() < 0.98 else again
            found.append((t, '/joint_states', again))
        if k > 10 and rng.random() < 0.8:
            found.append((t + 0.002, '/poses', tray(rng, t)))
        if rng.random() < sparse:
            found += disturbances(rng, t + 0.005)
    return found


def same(found, expected):
    for pairs, others in zip(found.sets.values(), expected.sets.values(), strict=True):
        for field in fields(pairs):
            one, other = getattr(pairs, field.name), getattr(others, field.name)
            np.testing.assert_array_equal(one, other, err_msg=field.name)
    for name in ('stamps', 'gaps', 'troubles', 'refused', 'begin', 'end', 'travelled'):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), err_msg=name)


@pytest.mark.parametrize('rate', [0.0, 37.0])
@pytest.mark.parametrize('split', [False, True])
@pytest.mark.parametrize('clock', [False, True])
@pytest.mark.parametrize(('seed', 'sparse'), [(1, 0.0), (2, 0.02), (3, 0.2)])
def test_runs_are_as_one_by_one(tmp_path, monkeypatch, scene, seed, sparse, clock, split, rate):
    told = messages(seed, 300, split=split, clock=clock, sparse=sparse)
    run = recorder.record(tmp_path / 'run', told)
    between = ['arm:wall', '*:tray']
    runs = []
    real = player.run_of
    monkeypatch.setattr(player, 'run_of', lambda *args: runs.append(real(*args)) or runs[-1])
    found = clearance(run, scene, between=between, rate=rate)
    assert sparse > 0.1 or sum(each is not None for each in runs) > 1
    monkeypatch.setattr(player, '_SHORTEST', 10**9)
    same(found, clearance(run, scene, between=between, rate=rate))
