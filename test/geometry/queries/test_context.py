"""Contexts: poses whole or not at all, whose frames, and what what-if leaves alone."""

import numpy as np
import pytest
from oracles.small_scene import SmallScene

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometrySet,
    PoseError,
    QueryObject,
    UnknownIdError,
)
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.queries import posed_scene
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.math import RigidTransform


@pytest.fixture
def scene():
    scene = SmallScene()
    scene.context = scene.scene_graph.CreateDefaultContext()
    scene.query = scene.scene_graph.get_query_output_port().Eval(scene.context)
    return scene


def poses(*pairs):
    return FramePoseVector({frame: RigidTransform([x, 0.0, 0.0]) for frame, x in pairs})


def x_of(scene, frame, query=None):
    return (query or scene.query).X_PF(frame).translation()[0]


def test_all_frames_of_a_source_or_none(scene):
    scene.context.SetFramePoses(scene.arm, poses((scene.upper, 1), (scene.lower, 2)))
    assert [x_of(scene, f) for f in (scene.upper, scene.lower)] == [1, 2]
    with pytest.raises(PoseError, match="no pose: 'lower'"):
        scene.context.SetFramePoses(scene.arm, poses((scene.upper, 9)))
    stranger = poses((scene.upper, 9), (scene.lower, 9), (FrameId(10**9), 9))
    with pytest.raises(PoseError, match=r'not its own.*1000000000'):
        scene.context.SetFramePoses(scene.arm, stranger)
    with pytest.raises(PoseError, match="not its own: 'upper'"):
        scene.context.SetFramePoses(scene.room, poses((scene.upper, 9)))
    with pytest.raises(UnknownIdError):
        scene.context.SetFramePoses(type(scene.arm)(10**9), poses((scene.upper, 9)))
    assert [x_of(scene, f) for f in (scene.upper, scene.lower)] == [1, 2]


def test_some_frames_keep_their_poses(scene):
    scene.context.UpdateFramePoses(poses((scene.upper, 1), (scene.lower, 2)))
    scene.context.UpdateFramePoses(poses((scene.lower, 3)))
    assert [x_of(scene, f) for f in (scene.upper, scene.lower)] == [1, 3]
    for frame in (FrameId(10**9), scene.scene_graph.world_frame_id()):
        with pytest.raises(PoseError, match='not in this scene'):
            scene.context.UpdateFramePoses(poses((scene.upper, 9), (frame, 9)))
    assert [x_of(scene, f) for f in (scene.upper, scene.lower)] == [1, 3]


def test_arrays_pose_as_records_do(scene):
    rows = np.array([[4, 0, 0, 0, 0, 0, 1.0], [5, 0, 0, 0, 0, 0, 1.0]])
    vector = FramePoseVector.FromArrays([scene.lower, scene.upper], rows)
    scene.context.SetFramePoses(scene.arm, vector)
    assert [x_of(scene, f) for f in (scene.upper, scene.lower)] == [5, 4]


def test_what_if_has_poses_of_its_own(scene):
    scene.context.UpdateFramePoses(poses((scene.upper, 1), (scene.lower, 0)))
    other = scene.context.what_if()
    other.UpdateFramePoses(poses((scene.upper, 7)))
    assert x_of(scene, scene.upper, QueryObject(other)) == 7
    assert x_of(scene, scene.upper) == 1


def test_a_snapshot_does_not_see_what_comes_after(scene):
    scene.context.UpdateFramePoses(poses((scene.upper, 1), (scene.lower, 0)))
    snapshot = QueryObject(scene.context.what_if())
    before = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    scene.context.UpdateFramePoses(poses((scene.upper, 7)))
    manager = scene.scene_graph.collision_filter_manager(scene.context)
    everything = GeometrySet(scene.scene_graph.model_inspector().GetAllGeometryIds())
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(everything))
    scene.scene_graph.RemoveGeometry(scene.context, scene.arm, scene.box)
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == 0
    after = snapshot.ComputeSignedDistancePairwiseClosestPoints()
    assert len(before) > 0
    np.testing.assert_array_equal(after.distance, before.distance)
    assert scene.box in snapshot.inspector().GetAllGeometryIds()


def test_a_shared_context_follows_its_model(scene):
    shared = scene.scene_graph.CreateSharedContext()
    for context in (scene.context, shared):
        context.UpdateFramePoses(poses((scene.upper, 0), (scene.lower, 0)))
    query = QueryObject(shared)
    before = len(query.ComputeSignedDistancePairwiseClosestPoints())
    scene.scene_graph.RemoveGeometry(scene.arm, scene.box)
    assert len(query.ComputeSignedDistancePairwiseClosestPoints()) < before
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == before


def test_compiling_is_done_once(scene):
    scene.context.compile_kernels()
    scene.context.UpdateFramePoses(poses((scene.upper, 0), (scene.lower, 0)))
    assert scene.context.compile_kernels() == []
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert scene.query.effects().kernels_compiled == []


def test_a_level_that_is_none_is_refused(scene):
    with pytest.raises(ArgumentError, match='superb'):
        scene.context.set_default_accuracy('superb')


@pytest.mark.parametrize('by_source', [False, True])
def test_each_of_many_senders_is_looked_up_once(scene, monkeypatch, by_source):
    """Who poses frames names the same ones each time, and others do so in between."""
    frames = np.array(sorted(f.get_value() for f in (scene.upper, scene.lower)))
    senders = [frames, frames[:1], frames[1:], frames[::-1].copy()]
    looked_up = []
    named = World.named
    monkeypatch.setattr(World, 'named', lambda *args: looked_up.append(1) or named(*args))
    xs = {}
    for turn in range(5):
        for k, ids in enumerate(senders):
            rows = np.zeros((len(ids), 7))
            rows[:, 0], rows[:, 6] = 10.0 * turn + k + np.arange(len(ids)), 1.0
            vector = FramePoseVector.FromArrays(ids, rows)
            if by_source and len(ids) == len(frames):
                scene.context.SetFramePoses(scene.arm, vector)
            else:
                scene.context.UpdateFramePoses(vector)
            xs.update(zip(ids.tolist(), rows[:, 0].tolist(), strict=True))
            assert {v: x_of(scene, FrameId(v)) for v in frames.tolist()} == xs
    assert len(looked_up) == len(senders)


def test_senders_without_end_do_not_fill_the_memory(scene, monkeypatch):
    scene.context.UpdateFramePoses(poses((scene.upper, 1), (scene.lower, 2)))
    monkeypatch.setattr(posed_scene, '_MAX_FRAME_LISTS', 2)
    one = [[scene.upper], [scene.lower], [scene.upper, scene.lower], [scene.lower, scene.upper]]
    for turn in range(3):
        for k, frames in enumerate(one):
            scene.context.UpdateFramePoses(poses(*((f, 10 * turn + k) for f in frames)))
            assert {x_of(scene, f) for f in frames} == {10 * turn + k}
    assert len(state_of(scene.context)._named) <= 2
