"""Hydroelastic properties, and the defaults that a scene gives."""

import math
from fractions import Fraction

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddRigidHydroelasticProperties,
    DefaultProximityProperties,
    GeometryError,
    GeometryInstance,
    HalfSpace,
    HydroelasticType,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    SceneGraphConfig,
    Sphere,
    TriangleSurfaceMesh,
    VolumeMesh,
)
from drake_geom_ros.math import RigidTransform


def names_of(properties):
    return set(properties.GetPropertiesInGroup('hydroelastic'))


def test_which_properties_are_added():
    for add, names in (
        (lambda p: AddRigidHydroelasticProperties(p), {'compliance_type'}),
        (lambda p: AddRigidHydroelasticProperties(properties=p), {'compliance_type'}),
        (
            lambda p: AddRigidHydroelasticProperties(0.1, p),
            {'compliance_type', 'resolution_hint'},
        ),
        (
            lambda p: AddCompliantHydroelasticProperties(0.1, 1e5, p),
            {'compliance_type', 'resolution_hint', 'hydroelastic_modulus'},
        ),
        (
            lambda p: AddCompliantHydroelasticPropertiesForHalfSpace(0.1, 1e5, p),
            {'compliance_type', 'slab_thickness', 'hydroelastic_modulus'},
        ),
    ):
        properties = ProximityProperties()
        add(properties)
        assert names_of(properties) == names
        with pytest.raises(RuntimeError, match='already'):
            add(properties)


@pytest.mark.parametrize(
    'number', [np.float32(0.5), np.float16(0.5), np.int64(2), np.uint8(2), Fraction(1, 2)]
)
def test_numbers_of_all_kinds_are_numbers(number):
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(number, number, properties)
    AddCompliantHydroelasticPropertiesForHalfSpace(number, number, ProximityProperties())
    for name in ('resolution_hint', 'hydroelastic_modulus'):
        kept = properties.GetProperty('hydroelastic', name)
        assert (type(kept), kept) == (float, float(number))
    defaults = DefaultProximityProperties(
        compliance_type='compliant', hydroelastic_modulus=number, resolution_hint=number
    )
    scene_graph, config = SceneGraph(), SceneGraphConfig(default_proximity_properties=defaults)
    scene_graph.set_config(config)
    held = scene_graph.get_config().default_proximity_properties.hydroelastic_modulus
    assert (type(held), held) == (float, float(number))
    given = ProximityProperties()
    given.AddProperty('hydroelastic', 'compliance_type', HydroelasticType.kCompliant)
    for name in ('resolution_hint', 'hydroelastic_modulus'):
        given.AddProperty('hydroelastic', name, number)
    given.AddProperty('proximity', 'padding', number)
    scene, _, id = scene_of(Sphere(1.0), given)
    assert scene.model_inspector().maybe_get_hydroelastic_mesh(id).num_elements() > 0


BAD = [0.0, -1.0, math.nan, math.inf, True, np.bool_(True), 'soft', 10**400, np.array([0.5])]


@pytest.mark.parametrize('bad', BAD)
def test_values_that_are_refused_leave_nothing(bad):
    properties = ProximityProperties()
    for call, others in (
        (AddRigidHydroelasticProperties, ()),
        (AddCompliantHydroelasticProperties, (1e5,)),
        (AddCompliantHydroelasticPropertiesForHalfSpace, (1e5,)),
    ):
        with pytest.raises(RuntimeError):
            call(bad, *others, properties)
    with pytest.raises(RuntimeError):
        AddCompliantHydroelasticProperties(0.1, bad, properties)
    assert not properties.HasGroup('hydroelastic')


def scene_of(shape, properties=None, config=None):
    scene = SceneGraph() if config is None else SceneGraph(config=config)
    source = scene.RegisterSource('source')
    instance = GeometryInstance(RigidTransform(), shape, 'body')
    instance.set_proximity_properties(properties or ProximityProperties())
    return scene, source, scene.RegisterAnchoredGeometry(source, instance)


def test_the_mesh_follows_the_properties():
    scene, source, id = scene_of(Sphere(1.0))
    assert scene.model_inspector().maybe_get_hydroelastic_mesh(id) is None
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(2.0, 1e5, properties)
    scene.AssignRole(source, id, properties, RoleAssign.kReplace)
    inspector = scene.model_inspector()
    assert inspector.maybe_get_hydroelastic_mesh(id).num_elements() == 8
    assert inspector.maybe_get_hydroelastic_pressures(id).tolist().count(1e5) == 1
    scene.RenameGeometry(id, 'other')
    scene.ChangeShape(source, id, Sphere(2.0))
    assert inspector.maybe_get_hydroelastic_mesh(id).num_elements() == 32


def test_a_half_space_has_no_mesh():
    properties = ProximityProperties()
    AddCompliantHydroelasticPropertiesForHalfSpace(0.1, 1e5, properties)
    scene, _, id = scene_of(HalfSpace(), properties)
    assert scene.model_inspector().maybe_get_hydroelastic_mesh(id) is None


def test_other_compliance_types_and_margins_are_refused():
    for name, value in (('compliance_type', 'rigid'), ('margin', 1e-3)):
        properties = ProximityProperties()
        properties.AddProperty('hydroelastic', name, value)
        if name == 'margin':
            AddRigidHydroelasticProperties(0.1, properties)
        with pytest.raises(GeometryError, match=name):
            scene_of(Sphere(1.0), properties)


@pytest.mark.parametrize(
    ('kind', 'mesh'), [('rigid', TriangleSurfaceMesh), ('compliant', VolumeMesh)]
)
def test_defaults_are_for_contexts(kind, mesh):
    config = SceneGraphConfig(DefaultProximityProperties(compliance_type=kind))
    scene, _, id = scene_of(Sphere(0.05), config=config)
    assert scene.get_config() == config
    assert scene.get_config() is not config
    assert scene.model_inspector().maybe_get_hydroelastic_mesh(id) is None
    for one in (scene, scene.Clone()):
        query = one.get_query_output_port().Eval(one.CreateDefaultContext())
        assert isinstance(query.inspector().maybe_get_hydroelastic_mesh(id), mesh)
        assert one.get_config(one.CreateDefaultContext()) == config
    with pytest.raises(GeometryError, match='CreateSharedContext'):
        scene.CreateSharedContext()
    scene.set_config(SceneGraphConfig())
    query = scene.get_query_output_port().Eval(scene.CreateDefaultContext())
    assert query.inspector().maybe_get_hydroelastic_mesh(id) is None


def test_own_properties_go_before_defaults():
    properties = ProximityProperties()
    properties.AddProperty('hydroelastic', 'compliance_type', HydroelasticType.kUndefined)
    config = SceneGraphConfig(DefaultProximityProperties(compliance_type='rigid'))
    scene, _, id = scene_of(Sphere(0.05), properties, config)
    query = scene.get_query_output_port().Eval(scene.CreateDefaultContext())
    assert query.inspector().maybe_get_hydroelastic_mesh(id) is None
    assert (
        query.inspector().GetProximityProperties(id).GetProperty('hydroelastic', 'resolution_hint')
        == 0.02
    )


def test_what_comes_into_a_context_gets_its_defaults():
    config = SceneGraphConfig(DefaultProximityProperties(compliance_type='rigid'))
    scene, source, _ = scene_of(Sphere(0.05), config=config)
    context = scene.CreateDefaultContext()
    inspector = scene.get_query_output_port().Eval(context).inspector()
    scene.set_config(SceneGraphConfig())  # of contexts made from now on

    def instance(name):
        return GeometryInstance(RigidTransform(), Sphere(0.05), name)

    late = instance('late')
    late.set_proximity_properties(ProximityProperties())
    ids = [scene.RegisterAnchoredGeometry(context, source, late)]
    assert not late.proximity_properties().HasGroup('hydroelastic')
    ids.append(scene.RegisterAnchoredGeometry(context, source, instance('later')))
    scene.AssignRole(context, source, ids[1], ProximityProperties())
    for _ in range(2):
        for id in ids:
            assert isinstance(inspector.maybe_get_hydroelastic_mesh(id), TriangleSurfaceMesh)
        scene.AssignRole(context, source, ids[1], ProximityProperties(), RoleAssign.kReplace)
    # A copy of the context goes on so, the scene does not.
    copied = context.what_if().copy()
    last = instance('last')
    last.set_proximity_properties(ProximityProperties())
    id = scene.RegisterAnchoredGeometry(copied, source, last)
    query = scene.get_query_output_port().Eval(copied)
    assert query.inspector().maybe_get_hydroelastic_mesh(id) is not None
    id = scene.RegisterAnchoredGeometry(source, instance('own'))
    scene.AssignRole(source, id, ProximityProperties())
    assert scene.model_inspector().maybe_get_hydroelastic_mesh(id) is None


def test_contexts_share_what_their_defaults_made():
    config = SceneGraphConfig(DefaultProximityProperties(compliance_type='compliant'))
    scene, _, id = scene_of(Sphere(0.05), config=config)
    inspectors = [
        scene.get_query_output_port().Eval(scene.CreateDefaultContext()).inspector()
        for _ in range(2)
    ]
    a, b = (inspector.maybe_get_hydroelastic_mesh(id) for inspector in inspectors)
    assert a is b
    config.default_proximity_properties.resolution_hint = 0.1
    scene.set_config(config)
    query = scene.get_query_output_port().Eval(scene.CreateDefaultContext())
    assert query.inspector().maybe_get_hydroelastic_mesh(id).num_elements() < a.num_elements()


def test_a_change_of_config_is_one_of_the_model():
    scene, _, _ = scene_of(Sphere(0.05))
    before, names = scene.model_version(), scene.names_version()
    scene.set_config(SceneGraphConfig())
    assert scene.model_version() == before
    copied = scene.CreateSharedContext().copy()
    scene.set_config(SceneGraphConfig(DefaultProximityProperties(margin=1.0)))
    assert scene.model_version() > before
    assert scene.names_version() == names
    assert not scene.TakeOver(copied)  # which knows nothing of it
    # The geometries that the shared context has are the scene's: they get no defaults.
    with pytest.raises(GeometryError, match=r'set_config.*shares'):
        scene.set_config(SceneGraphConfig(DefaultProximityProperties(compliance_type='rigid')))
    assert scene.get_config().default_proximity_properties.margin == 1.0


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('compliance_type', 'soft'),
        ('compliance_type', None),
        ('resolution_hint', -0.1),
        ('resolution_hint', '0.1'),
        ('hydroelastic_modulus', True),
        ('hydroelastic_modulus', math.nan),
        ('dynamic_friction', 0.6),
        ('dynamic_friction', None),
        ('static_friction', -0.1),
        ('hunt_crossley_dissipation', math.inf),
        ('relaxation_time', -1),
        ('point_stiffness', 0.0),
        ('resolution_hint', 0.0),
        ('margin', -1.0),
        ('slab_thickness', math.nan),
    ],
)
def test_a_bad_config_changes_nothing(name, value):
    scene = SceneGraph()
    with pytest.raises(RuntimeError, match=name):
        scene.set_config(SceneGraphConfig(DefaultProximityProperties(**{name: value})))
    assert scene.get_config() == SceneGraphConfig()


def test_a_config_of_another_kind_is_refused():
    scene = SceneGraph()
    for config in ('compliant', SceneGraphConfig(default_proximity_properties='compliant')):
        with pytest.raises(RuntimeError):
            scene.set_config(config)
    assert scene.get_config() == SceneGraphConfig()
