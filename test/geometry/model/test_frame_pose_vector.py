"""FramePoseVector: filled by id or from arrays, it is the same."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from oracles.poses import random_poses

from drake_geom_ros.geometry import FrameId, FramePoseVector, GeometryId, PoseError
from drake_geom_ros.math import RigidTransform

POSES = random_poses(20, seed=5)
IDS = [FrameId(k) for k in range(40, 0, -2)]
VALUES = np.array([id.get_value() for id in IDS])


def by_id():
    return FramePoseVector(
        {id: RigidTransform.FromArray(pose) for id, pose in zip(IDS, POSES, strict=True)}
    )


@pytest.mark.parametrize(
    'vector',
    [
        by_id(),
        FramePoseVector.FromArrays(IDS, POSES),
        FramePoseVector.FromArrays(VALUES, POSES),
        FramePoseVector.FromArrays(VALUES.astype(np.uint64), POSES.tolist()),
    ],
)
def test_all_ways_give_the_same(vector):
    assert vector.size() == len(vector) == 20
    assert vector.ids() == vector.frame_ids() == IDS
    assert vector._ids.tolist() == VALUES.tolist()
    assert vector._ids.dtype == np.int64
    for k, (id, pose) in enumerate(zip(IDS, POSES, strict=True)):
        X_PF = RigidTransform.FromArray(pose)
        assert vector.has_id(id)
        assert vector.value(id) == X_PF
        assert np.array_equal(vector._R_PFs[k], X_PF.rotation().matrix())
        assert np.array_equal(vector._p_PFs[k], X_PF.translation())
    assert not vector.has_id(FrameId(1))


def test_from_arrays_makes_no_python_object_for_a_frame():
    vector = FramePoseVector.FromArrays(VALUES, POSES)
    assert len(vector) == 20
    assert len(vector._R_PFs) == 20
    assert vector._values is None


def test_values_can_be_set_on_either():
    for vector in (by_id(), FramePoseVector.FromArrays(VALUES, POSES)):
        vector.set_value(IDS[3], RigidTransform([7, 8, 9]))
        vector.set_value(id=FrameId(1), value=RigidTransform([1, 1, 1]))
        assert vector.ids() == [*IDS, FrameId(1)]
        assert vector._p_PFs[3].tolist() == [7, 8, 9]
        assert vector._p_PFs[20].tolist() == [1, 1, 1]
        np.testing.assert_array_equal(vector._p_PFs[:3], POSES[:3, :3])
        vector.clear()
        assert vector.size() == 0
        assert vector._R_PFs.shape == (0, 3, 3)


def test_poses_are_copies():
    poses, mine = POSES.copy(), RigidTransform([1, 2, 3])
    vector = FramePoseVector.FromArrays(VALUES, poses)
    poses[:] = 0.0
    assert np.array_equal(vector._p_PFs, POSES[:, :3])
    vector.set_value(IDS[0], mine)
    mine.set_translation([0, 0, 0])
    vector.value(IDS[0]).set_translation([0, 0, 0])
    assert vector.value(IDS[0]) == RigidTransform([1, 2, 3])


def test_ids_are_copies_though_the_same_ones_come_again():
    mine = np.sort(VALUES)
    first, second = (FramePoseVector.FromArrays(mine, POSES) for _ in 'ab')
    mine[-1] += 100
    third = FramePoseVector.FromArrays(mine, POSES)
    assert first.id_values().tolist() == second.id_values().tolist() == sorted(VALUES.tolist())
    assert third.id_values().tolist() == mine.tolist()
    with pytest.raises(ValueError, match='read-only'):
        first.id_values()[0] = 7
    refused = POSES.copy()
    refused[3, 4] = np.nan
    with pytest.raises(PoseError, match='not finite'):
        FramePoseVector.FromArrays(mine, refused)


def test_another_number_of_dimensions_is_refused_where_the_frames_are_known():
    known = np.sort(VALUES)
    FramePoseVector.FromArrays(known, POSES)
    for ids, poses in ((known[:, None], POSES), (known, POSES.ravel()), (known[0], POSES[0])):
        with pytest.raises(PoseError):
            FramePoseVector.FromArrays(np.array(ids), poses)
    for poses in (POSES[:-1], POSES[:, :6]):
        with pytest.raises(PoseError):
            FramePoseVector.FromArrays(known, poses)


def unwritable(array):
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    ('ids', 'poses'),
    [
        (np.repeat(np.sort(VALUES), 2)[::2], POSES),
        (np.sort(VALUES), np.repeat(POSES, 2, axis=0)[::2]),
        (np.sort(VALUES), np.asfortranarray(POSES)),
        (unwritable(np.sort(VALUES)), POSES),
        (np.sort(VALUES), unwritable(POSES.copy())),
        (np.sort(VALUES).astype(np.int32), POSES),
        (np.sort(VALUES), POSES.astype('>f8')),
    ],
)
def test_arrays_of_any_layout_are_read_as_what_they_show(ids, poses):
    """After such as is usual, whose frames are known then."""
    usual = FramePoseVector.FromArrays(np.sort(VALUES), POSES)
    vector = FramePoseVector.FromArrays(ids, poses)
    assert vector.id_values().tolist() == usual.id_values().tolist()
    for mine, others in zip(vector._as_arrays(), usual._as_arrays(), strict=True):
        np.testing.assert_array_equal(mine, others)


def test_none_at_all():
    for vector in (FramePoseVector(), FramePoseVector.FromArrays([], np.zeros((0, 7)))):
        assert vector.size() == 0
        assert vector.ids() == []
        assert vector._p_PFs.shape == (0, 3)
        with pytest.raises(RuntimeError, match='no pose of <FrameId value=3> among 0 frames'):
            vector.value(FrameId(3))


def with_row(row):
    poses = POSES.copy()
    poses[7] = row
    return poses


@pytest.mark.parametrize(
    ('ids', 'poses', 'words'),
    [
        (VALUES, POSES[:, :6], r'shape \(20, 6\)'),
        (VALUES, POSES[:19], '20 frame_ids for 19 poses'),
        (VALUES, with_row([0, 0, math.nan, 0, 0, 0, 1]), r'poses\[7\].*not finite'),
        (VALUES, with_row([0, 0, math.inf, 0, 0, 0, 1]), r'poses\[7\].*not finite'),
        (VALUES, with_row([0, -2e302, 0, 0, 0, 0, 1]), r'poses\[7\].*beyond 1.71e\+302 m'),
        (VALUES, with_row([0, 0, 0, 1, 0, 0, 1]), r'poses\[7\].*norm 1.414'),
        (VALUES, with_row([0, 0, 0, 0, 0, 0, 0]), r'poses\[7\].*norm 0'),
        (VALUES // 8, POSES, 'frame 0 is named more than once'),
        (VALUES[None], POSES, r'shape \(1, 20\)'),
        (VALUES.astype(float), POSES, r'frame id = .*40.0.* must be of type FrameId'),
        ([GeometryId(1)], POSES[:1], 'must be of type FrameId'),
        (3, POSES[:1], 'iterable'),
    ],
)
def test_bad_arrays_are_refused_as_a_whole(ids, poses, words):
    with pytest.raises(PoseError, match=words):
        FramePoseVector.FromArrays(ids, poses)


def test_wrong_kinds_are_refused():
    vector = FramePoseVector()
    with pytest.raises(RuntimeError, match='FrameId'):
        vector.set_value(GeometryId(1), RigidTransform())
    with pytest.raises(RuntimeError, match='RigidTransform'):
        vector.set_value(FrameId(1), np.eye(4))
    with pytest.raises(RuntimeError, match=r'set_value.*beyond'):
        vector.set_value(FrameId(1), RigidTransform([0, 0, 1e308]))
    assert vector.size() == 0


@pytest.mark.parametrize('held', [0, 1, 2, 5])
def test_vectors_that_are_held_keep_their_poses(held):
    """Each has room of its own, for as long as anybody holds a part of what is in it."""
    ids = np.arange(3, 23)
    vectors, kept = [], []
    for seed in range(12):
        poses = random_poses(20, seed=seed)
        vectors.append(FramePoseVector.FromArrays(ids, poses))
        kept.append((vectors[-1]._p_PFs if seed % 2 else None, poses))
        del vectors[: max(0, len(vectors) - held)]
        for vector, (_, expected) in zip(vectors, kept[len(kept) - len(vectors) :], strict=True):
            assert np.array_equal(vector._p_PFs, expected[:, :3])
        for p_PFs, expected in kept:
            assert p_PFs is None or np.array_equal(p_PFs, expected[:, :3])


@pytest.mark.parametrize('spoil', [np.nan, np.inf, 1e303])
def test_what_is_refused_leaves_no_trace(spoil):
    ids, poses = np.arange(3, 23), random_poses(20, seed=1)
    first = FramePoseVector.FromArrays(ids, poses)
    bad = poses.copy()
    bad[7, 1] = spoil
    for _ in range(3):
        with pytest.raises(PoseError, match=r'poses\[7\]|row 7|finite'):
            FramePoseVector.FromArrays(ids, bad)
    again = FramePoseVector.FromArrays(ids, poses)
    for vector in (first, again):
        assert np.array_equal(vector._p_PFs, poses[:, :3])


def test_arrays_that_nobody_may_write_to_and_threads_are_taken():
    ids = np.arange(3, 23)
    expected = [random_poses(20, seed=seed) for seed in range(8)]
    for poses in expected:
        poses.flags.writeable = False

    def pose(k):
        return [FramePoseVector.FromArrays(ids, expected[k])._p_PFs.copy() for _ in range(300)]

    with ThreadPoolExecutor(8) as pool:
        for k, found in enumerate(pool.map(pose, range(8))):
            assert all(np.array_equal(p_PFs, expected[k][:, :3]) for p_PFs in found)
