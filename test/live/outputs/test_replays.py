"""Replay files of a node: of what, how many, and that they reproduce what was published."""

import numpy as np
import pytest
from live.live_scenes import TWO_BALLS, live_scene

from drake_geom_ros.geometry import FramePoseVector, SignedDistanceResults
from drake_geom_ros.live.outputs import replays as replays_module
from drake_geom_ros.live.outputs.replays import Replays
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.replay import read, recorded, reproduce

TEXT = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}, {name: nowhere, source: s}]
geometries:
- {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
- {name: post, source: s, shape: {type: box, size: [0.1, 0.1, 1]}}
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def live():
    return live_scene(TWO_BALLS, lambda: 0.0)


@pytest.fixture
def broken(monkeypatch):
    """Make every answer break its promise, from a set of indices on."""
    monkeypatch.setattr(
        SignedDistanceResults, 'breaks_promise', lambda results: np.ones(len(results), dtype=bool)
    )


def cycle(scene, replays, x):
    """Pose the balls, ask, and let the replays look."""
    names = scene.model.names
    poses = {names.frame('a'): RigidTransform([0.5, 0, 0]), names.frame('b'): _at(x)}
    scene.model.context.UpdateFramePoses(FramePoseVector(poses))
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints(10.0)
    replays.look_at(scene, results, 10.0)
    return results


def _at(x):
    return RigidTransform([x, 0.3, 0])


def test_one_file_for_each_pair_of_shape_types(scene, broken, tmp_path):
    folder = tmp_path / 'new' / 'folder'
    replays = Replays(lambda: (str(folder), 20))
    for x in (0.6, 0.7, 0.8):
        cycle(scene, replays, x)
        told = replays.write()
    assert told == []
    files = sorted(path.name for path in folder.iterdir())
    assert [name.rpartition('_')[0] for name in files] == [
        'replay_box_sphere',
        'replay_halfspace_sphere',
        'replay_sphere_sphere',
    ]


def test_the_file_holds_the_scene_of_that_cycle(scene, broken, tmp_path):
    replays = Replays(lambda: (str(tmp_path), 20))
    results = cycle(scene, replays, 0.6)
    cycle(scene, replays, 0.9)  # before it is written the scene has moved on
    told = replays.write()
    assert len(told) == 3
    for path in tmp_path.iterdir():
        assert any(text.endswith(f'python -m drake_geom_ros replay {path}') for text in told)
        replay = read(path)
        pairs = list(zip(results.id_A.tolist(), results.id_B.tolist(), strict=True))
        index = pairs.index(replay.ids)
        assert replay.answer.distance == results.distance[index]
        assert replay.question.max_distance == 10.0
        assert replay.question.hint is None
        assert repr(reproduce(replay)) == repr(replay.answer)


def test_the_hint_is_the_normal_of_the_last_cycle(scene, tmp_path, monkeypatch):
    hints = {}

    def kept(query, results, index, accuracy, max_distance, hint):
        hints[results.id_A[index], results.id_B[index]] = hint
        return recorded(query, results, index, accuracy, max_distance, hint)

    monkeypatch.setattr(replays_module, 'recorded', kept)
    replays = Replays(lambda: (str(tmp_path), 20))
    before = cycle(scene, replays, 0.6)
    monkeypatch.setattr(
        SignedDistanceResults, 'breaks_promise', lambda results: np.ones(len(results), dtype=bool)
    )
    cycle(scene, replays, 0.7)
    replays.write()
    assert len(hints) == 3
    for ids, hint in hints.items():
        pairs = list(zip(before.id_A, before.id_B, strict=True))
        assert hint == tuple(before.nhat_BA_W[pairs.index(ids)].tolist())


def test_a_promise_that_is_kept_leaves_no_file(scene, tmp_path):
    replays = Replays(lambda: (str(tmp_path), 20))
    cycle(scene, replays, 0.6)
    assert replays.write() == []
    assert list(tmp_path.iterdir()) == []


def test_without_a_folder_nothing_is_looked_at(scene, monkeypatch):
    def forbidden(results):
        raise AssertionError('looked at')

    monkeypatch.setattr(SignedDistanceResults, 'breaks_promise', forbidden)
    replays = Replays(lambda: ('', 20))
    cycle(scene, replays, 0.6)
    assert replays.write() == []


def test_a_limit_and_a_folder_that_cannot_be_are_told(scene, broken, tmp_path):
    replays = Replays(lambda: (str(tmp_path), 1))
    cycle(scene, replays, 0.6)
    told = replays.write()
    assert len(list(tmp_path.iterdir())) == 1
    assert ['replay_limit' in text for text in told] == [False, True, True]
    (tmp_path / 'file').touch()
    elsewhere = Replays(lambda: (str(tmp_path / 'file'), 20))
    cycle(scene, elsewhere, 0.6)
    assert all('no replay file could be written' in text for text in elsewhere.write())
