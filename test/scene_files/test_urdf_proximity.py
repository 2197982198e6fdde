"""Drake's hydroelastic elements in a URDF mean what its own parser takes them for."""

import pytest

from drake_geom_ros.geometry import CoulombFriction, HydroelasticType, Role, SceneGraph
from drake_geom_ros.scene_files import SceneFileError, read_scene, register, save_scene

NAMES = [
    ('hydroelastic', 'compliance_type'),
    ('hydroelastic', 'resolution_hint'),
    ('hydroelastic', 'hydroelastic_modulus'),
    ('material', 'hunt_crossley_dissipation'),
    ('material', 'relaxation_time'),
    ('material', 'point_contact_stiffness'),
]
HINT = '<drake:mesh_resolution_hint value="0.25"/>'
MODULUS = '<drake:hydroelastic_modulus value="1e6"/>'
CASES = {
    'nothing': '',
    'rigid': '<drake:rigid_hydroelastic/>' + HINT,
    'compliant': '<drake:compliant_hydroelastic/>' + HINT + MODULUS,
    'a modulus of a rigid one': '<drake:rigid_hydroelastic/>' + HINT + MODULUS,
    'numbers alone': HINT + MODULUS,
    'materials': '<drake:hunt_crossley_dissipation value="2"/><drake:relaxation_time value="0.5"/>'
    '<drake:point_contact_stiffness value="1e4"/><drake:mu_dynamic value="0.5"/>'
    '<drake:mu_static value="0.6"/>',
}


def robot(inside):
    return (
        '<robot name="r" xmlns:drake="http://drake.mit.edu"><link name="a">\n<inertial>'
        '<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>\n'
        '<collision><geometry><sphere radius="1"/></geometry>'
        f'<drake:proximity_properties>{inside}</drake:proximity_properties>'
        '</collision></link></robot>'
    )


def ours(urdf):
    scene_graph = SceneGraph()
    loaded = register(scene_graph, read_scene(urdf, format='urdf'))
    (id,) = scene_graph.model_inspector().GetAllGeometryIds()
    return scene_graph.model_inspector().GetProperties(id, Role.kProximity), loaded.warnings


def of_pydrake(urdf):
    parsing = pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    from pydrake.geometry import Role as TheirRole
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    parsing.Parser(plant).AddModelsFromString(urdf, 'urdf')
    (id,) = scene_graph.model_inspector().GetAllGeometryIds(TheirRole.kProximity)
    return scene_graph.model_inspector().GetProximityProperties(id)


def values(properties):
    said = {name: properties.GetPropertyOrDefault(*name, None) for name in NAMES}
    return {name: getattr(value, 'name', value) for name, value in said.items()}


@pytest.mark.parametrize('case', CASES)
def test_properties_are_those_of_pydrakes_parser(case):
    urdf = robot(CASES[case])
    properties, warnings = ours(urdf)
    assert not warnings
    theirs = of_pydrake(urdf)
    # pydrake shows Python no value of the compliance type, only that there is one.
    assert {n for n in NAMES if properties.HasProperty(*n)} == {
        n for n in NAMES if theirs.HasProperty(*n)
    }
    numbers = NAMES[1:]
    assert [properties.GetPropertyOrDefault(*n, None) for n in numbers] == [
        theirs.GetPropertyOrDefault(*n, None) for n in numbers
    ]


@pytest.mark.parametrize(('case', 'kind'), [('rigid', 'kRigid'), ('compliant', 'kCompliant')])
def test_what_takes_part(case, kind):
    properties, _ = ours(robot(CASES[case]))
    assert values(properties)[NAMES[0]] == HydroelasticType[kind].name


@pytest.mark.parametrize(
    ('inside', 'told'),
    [
        ('<drake:rigid_hydroelastic/><drake:compliant_hydroelastic/>', ':3: .*exclude each other'),
        ('<drake:mesh_resolution_hint/>', ':3: .*mesh_resolution_hint has no attribute `value`'),
        ('<drake:hydroelastic_modulus value="hard"/>', ":3: .*'hard' must be a number"),
        ('<drake:hydroelastic_modulus value="-1"/>', ':3: .*must be a number > 0'),
        ('<drake:compliant_hydroelastic/>' + MODULUS, ':3: .*needs .*resolution_hint'),
        ('<drake:Rigid_hydroelastic/>', ':3: .*must be written `rigid_hydroelastic`'),
        (HINT + HINT, ':3: .*a second <mesh_resolution_hint>'),
    ],
)
def test_what_cannot_be_is_refused_with_its_line(inside, told):
    with pytest.raises(SceneFileError, match=told):
        ours(robot(inside))


def test_what_is_not_understood_is_told():
    _, (warning,) = ours(robot('<drake:hydroelastic_margin value="0.01"/>'))
    assert '<drake:hydroelastic_margin> in <proximity_properties> is not understood' in warning


@pytest.mark.parametrize(
    ('elements', 'coefficients'),
    [
        ('<drake:mu_static value="0.9"/><drake:mu_dynamic value="0.7"/>', (0.9, 0.7)),
        ('<drake:mu_static value="0.9"/>', (0.9, 0.9)),
        ('<drake:mu_dynamic value="0.7"/>', (0.7, 0.7)),
    ],
)
def test_friction_is_that_of_pydrake_and_is_saved(elements, coefficients):
    multibody = pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    text = robot(elements)
    plant, of_drake = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    multibody.Parser(plant).AddModelsFromString(text, 'urdf')
    (id,) = of_drake.model_inspector().GetAllGeometryIds()
    properties = of_drake.model_inspector().GetProximityProperties(id)
    theirs = properties.GetProperty('material', 'coulomb_friction')
    assert (theirs.static_friction(), theirs.dynamic_friction()) == coefficients
    scene = read_scene(text)
    scene_graph = SceneGraph()
    register(scene_graph, scene)
    for description in (scene, read_scene(save_scene(scene_graph))):
        (geometry,) = description.geometries
        friction = geometry.roles[Role.kProximity].GetProperty('material', 'coulomb_friction')
        assert friction == CoulombFriction(*coefficients)


def test_a_friction_that_slides_worse_than_it_sticks_is_refused():
    text = robot('<drake:mu_static value="0.5"/><drake:mu_dynamic value="0.7"/>')
    with pytest.raises(SceneFileError, match=r'dynamic_friction = 0\.7.*0 <= dynamic <= static'):
        read_scene(text)
