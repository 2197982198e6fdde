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
