"""Hydroelastic properties in scene files: read, refused, and written again."""

import pytest

from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddRigidHydroelasticProperties,
    HydroelasticType,
    ProximityProperties,
    Role,
    SceneGraph,
)
from drake_geom_ros.scene_files import SceneFileError, describe, read_scene, register, to_yaml

SPHERE = '{type: sphere, radius: 0.1}'
SCENE = """
frames: [{{name: f}}]
geometries:
- name: body
  frame: f
  shape: {shape}
  roles: {{proximity: {{hydroelastic: {{{said}}}}}}}
"""
SOFT = 'compliance_type: compliant, resolution_hint: 0.05, hydroelastic_modulus: 1e6'


def scene_of(said, shape=SPHERE):
    text = SCENE.format(shape=shape, said=said)
    scene_graph = SceneGraph()
    return scene_graph, register(scene_graph, read_scene(text, format='yaml'))


def properties_of(scene_graph):
    (id,) = scene_graph.model_inspector().GetAllGeometryIds()
    return scene_graph.model_inspector().GetProperties(id, Role.kProximity)


def expected(add, *values):
    properties = ProximityProperties()
    add(*values, properties)
    return properties


@pytest.mark.parametrize(
    ('said', 'shape', 'properties'),
    [
        (SOFT, SPHERE, expected(AddCompliantHydroelasticProperties, 0.05, 1e6)),
        (SOFT.replace('1e6', '1000000'), SPHERE,
         expected(AddCompliantHydroelasticProperties, 0.05, 1e6)),
        ('compliance_type: rigid, resolution_hint: 1', SPHERE,
         expected(AddRigidHydroelasticProperties, 1.0)),
        ('compliance_type: rigid', '{type: half_space}', expected(AddRigidHydroelasticProperties)),
        ('compliance_type: compliant, slab_thickness: 0.02, hydroelastic_modulus: 2e5',
         '{type: half_space}',
         expected(AddCompliantHydroelasticPropertiesForHalfSpace, 0.02, 2e5)),
    ],
)  # fmt: skip
def test_a_file_says_what_drakes_functions_say_and_a_saved_one_too(said, shape, properties):
    scene_graph, _ = scene_of(said, shape)
    assert properties_of(scene_graph) == properties
    again = SceneGraph()
    text = to_yaml(describe(scene_graph))
    register(again, read_scene(text, format='yaml'))
    assert properties_of(again) == properties
    assert to_yaml(describe(again)) == text


def test_one_that_is_undefined_takes_no_part():
    scene_graph, _ = scene_of('compliance_type: undefined')
    kind = properties_of(scene_graph).GetProperty('hydroelastic', 'compliance_type')
    assert kind is HydroelasticType.kUndefined
    (id,) = scene_graph.model_inspector().GetAllGeometryIds()
    assert scene_graph.model_inspector().maybe_get_hydroelastic_mesh(id) is None


@pytest.mark.parametrize(
    ('said', 'shape', 'told'),
    [
        ('compliance_type: soft', SPHERE, r':7: .*soft.* must be one of rigid, compliant'),
        ('compliance: rigid', SPHERE, r':7: .*unknown key; allowed are compliance_type, '),
        (SOFT.replace('0.05', '0'), SPHERE, r':7: .*resolution_hint.* must be > 0'),
        (SOFT.replace('1e6', 'hard'), SPHERE, r':7: .*must be a number'),
        (SOFT + ', margin: 0.1', SPHERE, r'hydroelastic/margin. is not supported'),
        ('compliance_type: compliant, hydroelastic_modulus: 1e6', SPHERE,
         r':4: .*a Sphere needs the property .hydroelastic/resolution_hint'),
        ('compliance_type: compliant, resolution_hint: 0.1', SPHERE,
         r':4: .*needs the property .hydroelastic/hydroelastic_modulus'),
        (SOFT, '{type: half_space}', r':4: .*needs the property .hydroelastic/slab_thickness'),
        (SOFT.replace('0.05', '1e-6'), SPHERE, r':4: .*resolution hint 1e-06 m is too fine'),
        ('compliance_type: rigid',
         '{type: occupied_cells, resolution: 0.1, centres: [[0.05, 0.05, 0.05]]}',
         r':4: .*OccupiedCells has no hydroelastic body'),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_the_place(said, shape, told):
    with pytest.raises(SceneFileError, match=told):
        scene_of(said, shape)


def test_the_group_is_free_for_other_roles():
    text = SCENE.replace('proximity', 'illustration').format(shape=SPHERE, said='anything: 1')
    register(SceneGraph(), read_scene(text, format='yaml'))
