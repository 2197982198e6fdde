"""A mesh that would have too many elements is refused before it is made, with the hint to give."""

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import drake_geom_ros.geometry as ours
from drake_geom_ros.geometry.hydroelastic import _counts
from drake_geom_ros.geometry.hydroelastic._counts import MOST_ELEMENTS, elements_of
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import SceneFileError, read_scene, register

ROUND = {
    'Sphere': ours.Sphere(0.25),
    'Ellipsoid': ours.Ellipsoid(0.25, 0.1, 0.2),
    'Cylinder': ours.Cylinder(0.25, 0.5),
    'flat Cylinder': ours.Cylinder(0.25, 0.1),
    'long Cylinder': ours.Cylinder(0.25, 1.0),
    'Capsule': ours.Capsule(0.25, 0.5),
}


def registered(scene, source, shape, hint, *, rigid):
    properties = ours.ProximityProperties()
    if rigid:
        ours.AddRigidHydroelasticProperties(hint, properties)
    else:
        ours.AddCompliantHydroelasticProperties(hint, 1e5, properties)
    instance = ours.GeometryInstance(RigidTransform(), shape, 'body')
    instance.set_proximity_properties(properties)
    return scene.RegisterAnchoredGeometry(source, instance)


@given(st.sampled_from(sorted(ROUND)), st.floats(0.02, 2.0))
@example('flat Cylinder', 0.02)
@example('long Cylinder', 0.02)
@settings(max_examples=40, deadline=None)
def test_the_count_is_known_before_the_mesh_is_made(name, hint):
    scene = ours.SceneGraph()
    id = registered(scene, scene.RegisterSource('source'), ROUND[name], hint, rigid=False)
    mesh = scene.model_inspector().maybe_get_hydroelastic_mesh(id)
    assert elements_of(ROUND[name], hint) == mesh.num_elements()


@pytest.mark.parametrize('rigid', [False, True])
@pytest.mark.parametrize('hint', [1e-5, 1e-300])
@pytest.mark.parametrize('name', sorted(ROUND))
def test_a_hint_that_is_too_fine_is_refused_with_counts_and_the_hint_to_give(name, hint, rigid):
    shape, scene = ROUND[name], ours.SceneGraph()
    source = scene.RegisterSource('source')
    with pytest.raises(ours.GeometryError) as refused:
        registered(scene, source, shape, hint, rigid=rigid)
    told = str(refused.value)
    assert f'{hint:g} m is too fine' in told
    assert repr(shape) in told
    count, most = re.search(r'into (\S+) tetrahedra, and at most (\d+) are', told).groups()
    assert float(count) == pytest.approx(elements_of(shape, hint), rel=0.1)
    assert int(most) == MOST_ELEMENTS
    least = float(re.search(r'give at least (\S+) m', told).group(1))
    assert elements_of(shape, least) <= MOST_ELEMENTS < elements_of(shape, 0.99 * least)
    assert scene.model_inspector().num_geometries() == 0


def test_a_ball_of_half_a_million_tetrahedra_is_refused():
    scene = ours.SceneGraph()
    with pytest.raises(ours.GeometryError, match='into 524288 tetrahedra'):
        registered(scene, scene.RegisterSource('source'), ours.Sphere(0.25), 0.002, rigid=False)


@pytest.mark.parametrize('rigid', [False, True])
@pytest.mark.parametrize('kind', ['Convex', 'Mesh'])
def test_a_mesh_of_too_many_elements_is_refused(monkeypatch, kind, rigid):
    monkeypatch.setattr(_counts, 'MOST_ELEMENTS', 11)
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    shape = ours.Convex(points=corners.T, label='cube')
    if kind == 'Mesh':
        surface = shape.hull_surface()
        shape = ours.Mesh.FromMeshData(ours.MeshData(*surface))
    scene = ours.SceneGraph()
    source = scene.RegisterSource('source')
    with pytest.raises(ours.GeometryError, match=r'has 12 triangles.*at most 11 are allowed'):
        registered(scene, source, shape, 0.1, rigid=rigid)
    assert scene.model_inspector().num_geometries() == 0
    monkeypatch.setattr(_counts, 'MOST_ELEMENTS', 12)
    registered(scene, source, shape, 0.1, rigid=rigid)


def test_a_scene_file_is_refused_with_the_place_and_nothing_of_it_is_taken():
    text = """
geometries:
- {name: small, shape: {type: sphere, radius: 1}}
- name: fine
  shape: {type: sphere, radius: 0.25}
  roles: {proximity: {hydroelastic: {compliance_type: compliant, hydroelastic_modulus: 1e6,
    resolution_hint: 0.002}}}
"""
    scene = ours.SceneGraph()
    with pytest.raises(SceneFileError, match=r':4: .*0.002 m is too fine.*at least 0.00307 m'):
        register(scene, read_scene(text, format='yaml'))
    assert scene.model_inspector().num_geometries() == 0
