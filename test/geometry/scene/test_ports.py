"""Ports: poses go in as a whole or not at all, query objects come out."""

import pytest

from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    GeometryFrame,
    PoseError,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform

WORLD = SceneGraph.world_frame_id()


def test_poses_nest(scene):
    context = scene.scene_graph.CreateDefaultContext()
    scene.fix(context, upper=(0, 0, 1), lower=(3, 0, 0))
    query = scene.query_of(context)
    assert query.GetPoseInWorld(scene.lower) == RigidTransform([3, 0, 1])
    assert query.GetPoseInParent(scene.lower) == RigidTransform([3, 0, 0])
    assert query.GetPoseInWorld(scene.knob) == RigidTransform([0, 0, 2.5])


@pytest.mark.parametrize('kind', ['missing', 'foreign', 'unknown', 'world', 'none'])
def test_poses_are_refused_as_a_whole(scene, kind):
    scene_graph = scene.scene_graph
    foreign = scene_graph.RegisterFrame(scene.room, GeometryFrame('lift'))
    context = scene_graph.CreateDefaultContext()
    scene.fix(context, upper=(0, 0, 1), lower=(3, 0, 0))
    values = {scene.upper: RigidTransform([9, 9, 9]), scene.lower: RigidTransform([9, 9, 9])}
    if kind == 'missing':
        del values[scene.lower]
    elif kind == 'none':
        values.clear()
    else:
        extra = {'foreign': foreign, 'unknown': FrameId(10**6), 'world': WORLD}[kind]
        values[extra] = RigidTransform()
    with pytest.raises(PoseError, match='refused, nothing was changed'):
        scene_graph.get_source_pose_port(scene.arm).FixValue(context, FramePoseVector(values))
    lift = FramePoseVector({foreign: RigidTransform()})
    scene_graph.get_source_pose_port(scene.room).FixValue(context, lift)
    query = scene.query_of(context)
    assert query.GetPoseInWorld(scene.upper) == RigidTransform([0, 0, 1])
    assert query.GetPoseInWorld(scene.lower) == RigidTransform([3, 0, 1])


def test_ports_want_contexts_and_poses(scene):
    context, port = scene.scene_graph.CreateDefaultContext(), scene.scene_graph
    for call, words in (
        (lambda: port.get_query_output_port().Eval('c'), "Eval: context = 'c'"),
        (lambda: port.get_query_output_port().Eval(scene.scene_graph), 'SceneGraphContext'),
        (
            lambda: port.get_source_pose_port(scene.arm).FixValue(context, {}),
            'value = {} must be of type FramePoseVector',
        ),
        (
            lambda: port.get_source_pose_port(scene.arm).FixValue(None, FramePoseVector()),
            'context = None',
        ),
        (lambda: port.collision_filter_manager('c'), "context = 'c'"),
    ):
        with pytest.raises(RuntimeError, match=words):
            call()


def test_poses_that_are_given_twice_or_by_several_sources_all_count(scene):
    """Poses are taken over by the next question, whatever came in between."""
    lift = scene.scene_graph.RegisterFrame(scene.room, GeometryFrame('lift'))
    context = scene.scene_graph.CreateDefaultContext()
    port = scene.scene_graph.get_source_pose_port(scene.room)
    for step in range(4):
        scene.fix(context, upper=(0, 0, 9), lower=(9, 0, 0))
        port.FixValue(context, FramePoseVector({lift: RigidTransform([step, 2, 0])}))
        scene.fix(context, upper=(0, 0, step), lower=(3, 0, 0))
        if step % 2:
            context.UpdateFramePoses(FramePoseVector({scene.upper: RigidTransform([0, 1, step])}))
        query = scene.query_of(context.copy() if step > 1 else context)
        assert query.GetPoseInWorld(lift) == RigidTransform([step, 2, 0])
        assert query.GetPoseInWorld(scene.lower) == RigidTransform([3, step % 2, step])


def test_a_vector_may_change_after_it_was_given(scene):
    context = scene.scene_graph.CreateDefaultContext()
    poses = FramePoseVector({scene.upper: RigidTransform(), scene.lower: RigidTransform()})
    scene.scene_graph.get_source_pose_port(scene.arm).FixValue(context, poses)
    poses.set_value(scene.lower, RigidTransform([1, 2, 3]))
    poses.clear()
    assert scene.query_of(context).GetPoseInWorld(scene.lower) == RigidTransform()
