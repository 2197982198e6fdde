"""Versions of the geometry: the same while nothing of a role changed."""

import copy

import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    GeometryVersion,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

ROLES = (Role.kProximity, Role.kIllustration, Role.kPerception)


class Scene:
    """Two balls: one with proximity and illustration roles, one with proximity."""

    def __init__(self):
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('robot')
        self.frame = self.graph.RegisterFrame(self.source, GeometryFrame('frame'))
        self.ball, self.other = self.register('ball'), self.register('other')
        self.graph.AssignRole(self.source, self.ball, IllustrationProperties())

    def register(self, name, proximity=True):
        ball = instance(name, proximity=proximity)
        return self.graph.RegisterGeometry(self.source, self.frame, ball)

    def version(self):
        return self.graph.model_inspector().geometry_version()


def same(one, other):
    return [one.IsSameAs(other, role) for role in ROLES]


# What pydrake 1.51 says of the same changes.
CHANGES = {
    'a name': (lambda s: s.graph.RenameGeometry(s.ball, 'x'), [True, True, True]),
    'a frame': (lambda s: s.graph.RenameFrame(s.frame, 'x'), [True, True, True]),
    'no role': (lambda s: s.register('new', proximity=False), [True, True, True]),
    'register': (lambda s: s.register('new'), [False, True, True]),
    'remove': (lambda s: s.graph.RemoveGeometry(s.source, s.other), [False, True, True]),
    'shape': (lambda s: s.graph.ChangeShape(s.source, s.ball, Sphere(2)), [False, False, True]),
    'role': (
        lambda s: s.graph.AssignRole(s.source, s.ball, PerceptionProperties()),
        [True, True, False],
    ),
    'replace': (
        lambda s: s.graph.AssignRole(s.source, s.ball, ProximityProperties(), RoleAssign.kReplace),
        [False, True, True],
    ),
    'remove role': (
        lambda s: s.graph.RemoveRole(s.source, s.ball, Role.kIllustration),
        [True, False, True],
    ),
    'filter': (
        lambda s: s.graph.collision_filter_manager().Deactivate(GeometrySet(s.ball)),
        [False, True, True],
    ),
}


@pytest.mark.parametrize(('change', 'expected'), CHANGES.values(), ids=CHANGES)
def test_a_change_shows_in_the_roles_that_it_concerns(change, expected):
    scene = Scene()
    before = scene.version()
    assert same(before, scene.version()) == [True] * 3
    change(scene)
    assert same(before, scene.version()) == expected
    assert same(scene.version(), scene.version()) == [True] * 3


def test_a_declaration_is_a_change():
    scene = Scene()
    frame = scene.graph.RegisterFrame(scene.source, GeometryFrame('away'))
    far = GeometryInstance(RigidTransform(), Sphere(1), 'far')
    far.set_proximity_properties(ProximityProperties())
    scene.graph.RegisterGeometry(scene.source, frame, far)
    before = scene.version()
    declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet([scene.ball, far.id()]))
    scene.graph.collision_filter_manager().Apply(declaration)
    assert same(before, scene.version()) == [False, True, True]


def test_contexts_and_clones_go_their_own_ways():
    scene = Scene()
    before = scene.version()
    context, clone = scene.graph.CreateDefaultContext(), scene.graph.Clone()
    inspector = scene.graph.get_query_output_port().Eval(context).inspector()
    assert same(before, inspector.geometry_version()) == [True] * 3
    assert same(before, clone.model_inspector().geometry_version()) == [True] * 3
    scene.graph.RemoveGeometry(scene.source, scene.ball)
    scene.graph.RemoveGeometry(context, scene.source, scene.ball)
    assert same(scene.version(), inspector.geometry_version()) == [False, False, True]
    assert same(before, clone.model_inspector().geometry_version()) == [True] * 3


def test_a_version_without_a_scene():
    version = GeometryVersion()
    for other in (copy.copy(version), copy.deepcopy(version), GeometryVersion(other=version)):
        assert same(version, other) == [True] * 3
    assert same(version, GeometryVersion()) == [False] * 3
    with pytest.raises(RuntimeError, match='has no versions'):
        version.IsSameAs(version, Role.kUnassigned)
