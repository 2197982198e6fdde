"""SceneGraph against its contexts: neither sees the other's changes."""

import copy

import numpy as np
import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    GeometryFrame,
    GeometrySet,
    IllustrationProperties,
    ProximityProperties,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.math import RigidTransform

WORLD = SceneGraph.world_frame_id()


def test_every_change_can_be_made_on_a_context_and_the_model_never_notices(scene):
    scene_graph, arm = scene.scene_graph, scene.arm
    context = scene_graph.CreateDefaultContext()
    version, before = scene_graph.model_version(), snapshot(scene_graph.model_inspector())
    for on in ({'context': context}, None):
        suffix = 'a' if on else 'b'
        lead = () if on else (context,)
        given = on or {}
        source = scene_graph.RegisterSource(*lead, name=f's{suffix}', **given)
        frame = scene_graph.RegisterFrame(
            *lead, source_id=source, frame=GeometryFrame('f'), **given
        )
        ball = scene_graph.RegisterGeometry(
            *lead, source_id=source, frame_id=frame, geometry=instance('x'), **given
        )
        scene_graph.RegisterAnchoredGeometry(
            *lead, source_id=source, geometry=instance(f'y{suffix}'), **given
        )
        common = {'source_id': source, 'geometry_id': ball, **given}
        scene_graph.AssignRole(*lead, properties=IllustrationProperties(), **common)
        scene_graph.RemoveRole(*lead, role=Role.kIllustration, **common)
        scene_graph.ChangeShape(*lead, shape=Sphere(9), **common)
        scene_graph.RenameFrame(*lead, frame_id=frame, name='g', **given)
        scene_graph.RenameGeometry(*lead, geometry_id=ball, name='z', **given)
        scene_graph.ExcludeCollisionsWithin(*lead, set=GeometrySet([ball, scene.floor]), **given)
        scene_graph.ExcludeCollisionsBetween(
            *lead, setA=GeometrySet(ball), setB=GeometrySet(scene.box), **given
        )
        inspector = scene.query_of(context).inspector()
        assert inspector.GetName(ball) == 'z'
        assert inspector.GetName(frame) == 'g'
        assert inspector.GetShape(ball) == Sphere(9)
        assert inspector.CollisionFiltered(ball, scene.floor)
        assert inspector.CollisionFiltered(ball, scene.box)
        assert not inspector.CollisionFiltered(ball, scene.ball)
        scene_graph.RemoveGeometry(*lead, **common)
        assert ball not in inspector.GetAllGeometryIds()
    scene_graph.RemoveGeometry(context, arm, scene.ball)
    assert scene_graph.model_version() == version
    assert snapshot(scene_graph.model_inspector()) == before


def snapshot(inspector):
    """Return all that an inspector tells about a scene, filters included."""
    geometries = {
        id: (
            inspector.GetName(id),
            inspector.GetFrameId(id),
            inspector.GetShape(id),
            inspector.GetPoseInFrame(id).ToArray().tolist(),
            [inspector.GetProperties(id, role) for role in Role],
        )
        for id in inspector.GetAllGeometryIds()
    }
    frames = {id: inspector.GetName(id) for id in inspector.GetAllFrameIds()}
    sources = {id: inspector.GetName(id) for id in inspector.GetAllSourceIds()}
    return sources, frames, geometries, sorted(inspector.GetCollisionCandidates())


def test_changes_of_the_model_do_not_reach_contexts(scene):
    scene_graph = scene.scene_graph
    context = scene_graph.CreateDefaultContext()
    inspector = scene.query_of(context).inspector()
    before = snapshot(inspector)
    scene_graph.RenameFrame(scene.upper, 'elbow')
    scene_graph.RenameGeometry(scene.ball, 'globe')
    scene_graph.ChangeShape(scene.arm, scene.box, Sphere(3), RigidTransform([1, 1, 1]))
    scene_graph.AssignRole(scene.arm, scene.label, ProximityProperties())
    scene_graph.ExcludeCollisionsWithin(GeometrySet([scene.upper, scene.lower]))
    scene_graph.RemoveGeometry(scene.room, scene.floor)
    scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('new'))
    scene_graph.RegisterFrame(scene.arm, GeometryFrame('new'))
    scene_graph.RegisterSource('new')
    assert snapshot(inspector) == before
    assert snapshot(scene_graph.model_inspector()) != before


def test_a_shared_context_sees_changes_of_the_model(scene):
    context = scene.scene_graph.CreateSharedContext()
    query = scene.query_of(context)
    scene.scene_graph.RenameFrame(scene.upper, 'elbow')
    scene.scene_graph.RemoveGeometry(scene.room, scene.floor)
    assert query.inspector().GetName(scene.upper) == 'elbow'
    assert query.inspector().num_geometries() == 4


def test_a_query_object_is_live_and_its_copy_is_baked(scene):
    scene_graph = scene.scene_graph
    context = scene_graph.CreateDefaultContext()
    scene.fix(context, upper=(0, 0, 1), lower=(3, 0, 0))
    live = scene.query_of(context)
    baked = copy.copy(live)
    before = (
        baked.GetPoseInWorld(scene.knob).translation().tolist(),
        baked.ComputeSignedDistancePairClosestPoints(scene.ball, scene.box).distance,
    )
    assert before[0] == [0, 0, 2.5]
    scene.fix(context, upper=(0, 0, 5), lower=(4, 0, 0))
    scene_graph.ChangeShape(context, scene.arm, scene.box, Sphere(0.1))
    scene_graph.RenameFrame(context, scene.upper, 'elbow')
    after = live.ComputeSignedDistancePairClosestPoints(scene.ball, scene.box).distance
    assert live.GetPoseInWorld(scene.knob).translation().tolist() == [0, 0, 6.5]
    assert after == pytest.approx(np.hypot(4, 1) - 0.6, abs=1e-12)
    assert live.inspector().GetName(scene.upper) == 'elbow'
    assert baked.inspector().GetName(scene.upper) == 'upper'
    assert before == (
        baked.GetPoseInWorld(scene.knob).translation().tolist(),
        baked.ComputeSignedDistancePairClosestPoints(scene.ball, scene.box).distance,
    )


def test_accuracy_is_what_contexts_get(scene):
    scene_graph = SceneGraph(accuracy='fast')
    assert scene_graph.default_accuracy() == 'fast'
    assert state_of(scene_graph.CreateDefaultContext()).accuracy == 'fast'
    scene_graph.set_default_accuracy('balanced')
    assert state_of(scene_graph.CreateDefaultContext()).accuracy == 'balanced'
    with pytest.raises(RuntimeError, match="accuracy='x'"):
        SceneGraph(accuracy='x')


def test_a_filter_manager_acts_on_what_it_is_asked_for(scene):
    scene_graph, pair = scene.scene_graph, (scene.ball, scene.box)
    context = scene_graph.CreateDefaultContext()
    scene_graph.collision_filter_manager(context).Deactivate(GeometrySet(scene.ball))
    assert scene.query_of(context).inspector().CollisionFiltered(*pair)
    assert not scene_graph.model_inspector().CollisionFiltered(*pair)
    scene_graph.collision_filter_manager().Deactivate(GeometrySet(scene.ball))
    assert scene_graph.model_inspector().CollisionFiltered(*pair)
