"""What the versions of a model count: the one thing that the inspector does not show."""

from dataclasses import replace

import pytest
from oracles.small_scene import SmallScene, instance

from drake_geom_ros.geometry import (
    GeometryFrame,
    IllustrationProperties,
    ProximityProperties,
    Role,
    RoleAssign,
    Sphere,
)
from drake_geom_ros.geometry.model.scene_content import content_of
from drake_geom_ros.math import RigidTransform

CHANGES = {
    'a source': (lambda s, g: g.RegisterSource('x'), ''),
    'a frame': (lambda s, g: g.RegisterFrame(s.arm, GeometryFrame('x')), 'frames'),
    'a name of a frame': (lambda s, g: g.RenameFrame(s.upper, 'x'), 'frames'),
    'the same name of a frame': (lambda s, g: g.RenameFrame(s.upper, ' upper'), None),
    'a geometry': (lambda s, g: g.RegisterGeometry(s.arm, s.upper, instance('x')), 'proximity'),
    'a bare geometry': (
        lambda s, g: g.RegisterGeometry(s.arm, s.upper, instance('x', proximity=False)),
        '',
    ),
    'a name of a geometry': (lambda s, g: g.RenameGeometry(s.ball, 'x'), ''),
    'a role': (lambda s, g: g.AssignRole(s.arm, s.label, ProximityProperties()), 'proximity'),
    'other properties': (
        lambda s, g: g.AssignRole(s.arm, s.ball, ProximityProperties(), RoleAssign.kReplace),
        'proximity',
    ),
    'a role that is only drawn': (
        lambda s, g: g.AssignRole(s.arm, s.ball, IllustrationProperties()),
        '',
    ),
    'a role taken': (lambda s, g: g.RemoveRole(s.arm, s.ball, Role.kProximity), 'proximity'),
    'a drawn role taken': (lambda s, g: g.RemoveRole(s.arm, s.label, Role.kIllustration), ''),
    'no role taken': (lambda s, g: g.RemoveRole(s.arm, s.ball, Role.kPerception), None),
    'a shape': (lambda s, g: g.ChangeShape(s.arm, s.ball, Sphere(2)), 'proximity'),
    'a shape that is only drawn': (lambda s, g: g.ChangeShape(s.arm, s.label, Sphere(2)), ''),
    'a removal': (lambda s, g: g.RemoveGeometry(s.arm, s.box), 'proximity'),
    'a removal of what is only drawn': (lambda s, g: g.RemoveGeometry(s.arm, s.label), ''),
}


@pytest.mark.parametrize('change', CHANGES)
def test_versions_count_what_changed(change):
    call, kind = CHANGES[change]
    scene = SmallScene()
    versions = content_of(scene.scene_graph).model.versions
    before = replace(versions)
    call(scene, scene.scene_graph)
    assert (versions.any > before.any) == (kind is not None)
    assert (versions.frames > before.frames) == (kind == 'frames')
    assert (versions.proximity > before.proximity) == (kind == 'proximity')


OF_SHAPES = ('other properties', 'a shape', 'a shape that is only drawn')


@pytest.mark.parametrize('change', CHANGES)
def test_names_have_the_version_since_which_they_hold(change):
    call, kind = CHANGES[change]
    scene = SmallScene()
    graph = scene.scene_graph
    before = graph.names_version()
    call(scene, graph)
    holds = kind is None or change in OF_SHAPES
    assert graph.names_version() == (before if holds else graph.model_version())


def test_a_move_of_what_carries_proximity_geometry_counts():
    scene = SmallScene()
    scene.scene_graph.RemoveRole(scene.arm, scene.ball, Role.kProximity)
    before = content_of(scene.scene_graph).model.versions.proximity
    scene.scene_graph.ChangeShape(scene.arm, scene.ball, Sphere(1), RigidTransform([1, 0, 0]))
    assert content_of(scene.scene_graph).model.versions.proximity > before  # the knob moved
