"""SceneGraph: the rules of registering, and pydrake's overloads."""

import inspect

import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    Box,
    DuplicateError,
    GeometryFrame,
    GeometrySet,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.model.scene_content import content_of
from drake_geom_ros.math import RigidTransform

WORLD = SceneGraph.world_frame_id()


def test_sources_without_a_name_get_one():
    scene_graph = SceneGraph()
    inspector = scene_graph.model_inspector()
    for source in (scene_graph.RegisterSource(), scene_graph.RegisterSource('')):
        assert inspector.GetName(source) == f'Source_{source.get_value()}'
    named = scene_graph.RegisterSource(name=' arm\t')
    assert inspector.GetName(named) == 'arm'


@pytest.mark.parametrize(
    ('name', 'words'),
    [
        ('arm', r"'arm' is taken; there are \['SceneGraphInternal', 'arm', 'room'\]"),
        (' arm ', "'arm' is taken"),
        ('SceneGraphInternal', 'is taken'),
        (' ', 'empty'),
    ],
)
def test_source_names_are_unique_everywhere(scene, name, words):
    with pytest.raises(RuntimeError, match=words):
        scene.scene_graph.RegisterSource(name)
    assert scene.scene_graph.model_inspector().num_sources() == 3


def test_names_are_checked_when_the_role_is_assigned(scene):
    scene_graph, arm = scene.scene_graph, scene.arm
    twin = scene_graph.RegisterGeometry(arm, scene.upper, instance('ball', proximity=False))
    scene_graph.AssignRole(arm, twin, IllustrationProperties())
    with pytest.raises(DuplicateError, match='AssignRole'):
        scene_graph.AssignRole(arm, twin, ProximityProperties())
    assert scene_graph.RemoveRole(arm, scene.ball, Role.kProximity) == 1
    scene_graph.AssignRole(arm, twin, ProximityProperties())
    other_frame = scene_graph.RegisterGeometry(arm, scene.lower, instance('ball'))
    assert scene_graph.model_inspector().GetName(other_frame) == 'ball'


def test_a_name_that_was_given_up_is_free_again(scene):
    scene_graph = scene.scene_graph
    scene_graph.RenameFrame(scene.upper, 'elbow')
    scene_graph.RegisterFrame(scene.arm, GeometryFrame('upper'))
    scene_graph.RenameGeometry(scene.ball, 'globe')
    second = scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('ball'))
    scene_graph.RemoveGeometry(scene.arm, second)
    scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('ball'))
    scene_graph.RemoveGeometry(scene.arm, scene.knob)
    scene_graph.RenameGeometry(scene.ball, 'knob')
    for taken, register in (
        ('elbow', lambda: scene_graph.RegisterFrame(scene.arm, GeometryFrame('elbow'))),
        ('knob', lambda: scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('knob'))),
    ):
        with pytest.raises(DuplicateError, match=taken):
            register()


def test_registered_properties_are_copies(scene):
    properties = ProximityProperties()
    properties.AddProperty('g', 'n', 1)
    scene.scene_graph.AssignRole(scene.arm, scene.label, properties)
    properties.UpdateProperty('g', 'n', 2)
    held = scene.scene_graph.model_inspector().GetProximityProperties(scene.label)
    assert held.GetProperty('g', 'n') == 1
    with pytest.raises(RuntimeError, match='kReplace'):
        held.UpdateProperty('g', 'n', 3)
    changed = ProximityProperties(held)
    changed.UpdateProperty('g', 'n', 3)
    scene.scene_graph.AssignRole(scene.arm, scene.label, changed, RoleAssign.kReplace)
    held = scene.scene_graph.model_inspector().GetProximityProperties(scene.label)
    assert held.GetProperty('g', 'n') == 3
    made = instance('x')
    registered = scene.scene_graph.RegisterGeometry(scene.arm, scene.upper, made)
    made.mutable_proximity_properties().AddProperty('g', 'n', 4)
    held = scene.scene_graph.model_inspector().GetProximityProperties(registered)
    assert not held.HasGroup('g')
    with pytest.raises(RuntimeError, match='kReplace'):
        held.AddProperty('g', 'n', 4)


def test_replacing_properties_keeps_filters(scene):
    scene_graph = scene.scene_graph
    scene_graph.ExcludeCollisionsWithin(GeometrySet([scene.ball, scene.box]))
    scene_graph.AssignRole(scene.arm, scene.ball, ProximityProperties(), RoleAssign.kReplace)
    assert scene_graph.model_inspector().CollisionFiltered(scene.ball, scene.box)
    scene_graph.RemoveRole(scene.arm, scene.ball, Role.kProximity)
    scene_graph.AssignRole(scene.arm, scene.ball, ProximityProperties())
    assert not scene_graph.model_inspector().CollisionFiltered(scene.ball, scene.box)


def test_what_is_on_a_geometry_stays_on_it(scene):
    scene_graph, inspector = scene.scene_graph, scene.scene_graph.model_inspector()
    assert inspector.GetFrameId(scene.knob) == scene.upper
    scene_graph.ChangeShape(scene.arm, scene.ball, Box(1, 1, 1), RigidTransform([0, 2, 0]))
    assert inspector.GetPoseInFrame(scene.knob) == RigidTransform([0, 2, 0.5])
    assert inspector.GetPoseInParent(scene.knob) == RigidTransform([0, 0, 0.5])
    scene_graph.ChangeShape(scene.arm, scene.knob, Sphere(1), RigidTransform([0, 5, 0]))
    assert inspector.GetPoseInParent(scene.knob) == RigidTransform([0, 3, 0])
    scene_graph.RemoveGeometry(scene.arm, scene.ball)
    assert inspector.GetGeometries(scene.upper) == []


def test_what_was_on_a_geometry_and_is_gone_stays_gone(scene):
    scene_graph = scene.scene_graph
    context = scene_graph.CreateDefaultContext()
    scene_graph.RemoveGeometry(scene.arm, scene.knob)
    scene_graph.ChangeShape(scene.arm, scene.ball, Sphere(1), RigidTransform([0, 2, 0]))
    scene_graph.RemoveGeometry(scene.arm, scene.ball)
    # The context has its own knob, still on its own ball.
    X_FG = RigidTransform([0, 2, 0])
    scene_graph.ChangeShape(context, scene.arm, scene.ball, Sphere(1), X_FG)
    inspector = scene.query_of(context).inspector()
    assert inspector.GetPoseInFrame(scene.knob) == RigidTransform([0, 2, 0.5])


def test_names_of_sources_are_taken_on_one_side_only(scene):
    context = scene.scene_graph.CreateDefaultContext()
    scene.scene_graph.RegisterSource(context, 'tool')
    with pytest.raises(DuplicateError, match='tool'):
        scene.scene_graph.RegisterSource(context, 'tool')
    scene.scene_graph.RegisterSource('tool')


def test_changing_a_shape_keeps_roles_pose_and_filters(scene):
    scene_graph, inspector = scene.scene_graph, scene.scene_graph.model_inspector()
    scene_graph.ExcludeCollisionsBetween(GeometrySet(scene.ball), GeometrySet(scene.box))
    scene_graph.ChangeShape(scene.arm, scene.ball, Sphere(2))
    assert inspector.GetShape(scene.ball) == Sphere(2)
    assert inspector.GetPoseInFrame(scene.ball) == RigidTransform([0, 0, 1])
    assert inspector.CollisionFiltered(scene.ball, scene.box)


def test_roles_of_a_frame_are_removed_for_the_source_alone(scene):
    scene_graph = scene.scene_graph
    pole = scene_graph.RegisterAnchoredGeometry(scene.arm, instance('pole'))
    assert scene_graph.RemoveRole(scene.arm, WORLD, Role.kProximity) == 1
    assert scene_graph.RemoveRole(scene.arm, pole, Role.kProximity) == 0
    assert scene_graph.RemoveRole(scene.arm, scene.upper, Role.kProximity) == 2
    assert scene_graph.RemoveRole(scene.arm, scene.upper, Role.kUnassigned) == 0
    assert scene_graph.model_inspector().GetAllGeometryIds(Role.kProximity) == [
        scene.box,
        scene.floor,
    ]


def test_keywords_are_pydrakes(scene):
    scene_graph, arm = scene.scene_graph, scene.arm
    frame_id = scene_graph.RegisterFrame(
        source_id=arm, parent_id=scene.upper, frame=GeometryFrame('k')
    )
    scene_graph.RegisterFrame(source_id=arm, frame=GeometryFrame('l'))
    one = scene_graph.RegisterGeometry(
        source_id=arm, frame_id=frame_id, geometry=instance('one', proximity=False)
    )
    two = scene_graph.RegisterGeometry(source_id=arm, geometry_id=one, geometry=instance('two'))
    scene_graph.RegisterAnchoredGeometry(source_id=arm, geometry=instance('three'))
    scene_graph.AssignRole(
        source_id=arm, geometry_id=one, properties=PerceptionProperties(), assign=RoleAssign.kNew
    )
    assert scene_graph.RemoveRole(source_id=arm, geometry_id=one, role=Role.kPerception) == 1
    assert scene_graph.RemoveRole(source_id=arm, frame_id=frame_id, role=Role.kProximity) == 1
    scene_graph.ChangeShape(source_id=arm, geometry_id=two, shape=Sphere(1), X_FG=RigidTransform())
    scene_graph.RenameFrame(frame_id=frame_id, name='m')
    scene_graph.RenameGeometry(geometry_id=two, name='deux')
    scene_graph.ExcludeCollisionsWithin(set=GeometrySet(scene.ball))
    scene_graph.ExcludeCollisionsBetween(setA=GeometrySet(one), setB=GeometrySet(two))
    scene_graph.RemoveGeometry(source_id=arm, geometry_id=two)
    assert scene_graph.model_inspector().GetName(frame_id) == 'm'


def test_help_shows_what_callers_give():
    parameters = inspect.signature(SceneGraph.RemoveGeometry).parameters
    assert list(parameters) == ['self', 'source_id', 'geometry_id', 'context']
    assert SceneGraph.RemoveGeometry.__name__ == 'RemoveGeometry'


def test_the_filters_know_what_is_anchored(scene):
    pole = scene.scene_graph.RegisterAnchoredGeometry(scene.room, instance('pole'))
    explain = content_of(scene.scene_graph).filters.explain
    assert explain(pole.get_value(), scene.floor.get_value()) == ['anchored']
    assert explain(scene.ball.get_value(), scene.knob.get_value()) == ['same frame']
