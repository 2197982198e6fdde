"""The meshes of shapes: whole, of the right size, and pydrake's where that is installed."""

import importlib.util

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import drake_geom_ros.geometry as ours
from drake_geom_ros.geometry.meshes.volume_surface import neighbours_of
from drake_geom_ros.math import RigidTransform

needs_pydrake = pytest.mark.skipif(
    importlib.util.find_spec('pydrake') is None, reason='pydrake is not installed'
)
KINDS = {'Sphere': 1, 'Box': 3, 'Cylinder': 2, 'Capsule': 2, 'Ellipsoid': 3}


def registered(geometry, shape, hint, *, rigid, modulus=1e5):
    """Return a scene of one geometry with hydroelastic properties, and its id."""
    if geometry is ours:
        transform = RigidTransform()
    else:
        from pydrake.math import RigidTransform as Theirs

        transform = Theirs()
    scene = geometry.SceneGraph()
    properties = geometry.ProximityProperties()
    if rigid:
        geometry.AddRigidHydroelasticProperties(hint, properties)
    else:
        geometry.AddCompliantHydroelasticProperties(hint, modulus, properties)
    instance = geometry.GeometryInstance(transform, shape, 'body')
    instance.set_proximity_properties(properties)
    return scene, scene.RegisterAnchoredGeometry(scene.RegisterSource('source'), instance)


def mesh_of(geometry, shape, hint, *, rigid=False):
    scene, id = registered(geometry, shape, hint, rigid=rigid)
    return scene.model_inspector().maybe_get_hydroelastic_mesh(id)


@st.composite
def kinds_and_sizes(draw):
    kind = draw(st.sampled_from(sorted(KINDS)))
    scale = draw(st.sampled_from([1e-3, 1.0, 1e3]))
    sizes = draw(st.lists(st.floats(0.3, 3.0), min_size=KINDS[kind], max_size=KINDS[kind]))
    return kind, [scale * size for size in sizes], scale * draw(st.floats(0.15, 4.0))


@given(kinds_and_sizes())
@settings(max_examples=60, deadline=None)
def test_a_mesh_is_whole(drawn):
    kind, sizes, hint = drawn
    scene, id = registered(ours, getattr(ours, kind)(*sizes), hint, rigid=False)
    inspector = scene.model_inspector()
    mesh, pressures = (
        inspector.maybe_get_hydroelastic_mesh(id),
        inspector.maybe_get_hydroelastic_pressures(id),
    )
    assert all(mesh.CalcTetrahedronVolume(e) > 0.0 for e in range(mesh.num_elements()))
    surface = ours.ConvertVolumeToSurfaceMesh(mesh)
    a, b, c = (surface.vertex_array()[surface.triangle_array()[:, k]] for k in range(3))
    enclosed = (np.cross(a, b) * c).sum() / 6.0
    assert enclosed == pytest.approx(mesh.CalcVolume(), rel=1e-12)
    assert mesh.CalcVolume() <= ours.CalcVolume(getattr(ours, kind)(*sizes)) * (1 + 1e-12)
    # One piece, 0 on the boundary and the modulus inside.
    outer = np.unique(
        mesh.element_array()[:, [1, 2, 3]][neighbours_of(mesh.element_array())[:, 0] < 0]
    )
    assert (pressures[outer] == 0.0).all()
    assert set(pressures.tolist()) == {0.0, 1e5}
    assert (pressures[mesh.element_array()].max(axis=1) == 1e5).all()


@needs_pydrake
def test_meshes_are_pydrakes():
    import pydrake.geometry as theirs

    random = np.random.default_rng(42)
    same = 0
    for kind in sorted(KINDS) * 8:
        sizes = np.exp(random.uniform(-0.7, 0.7, KINDS[kind])).tolist()
        hint = float(np.exp(random.uniform(-2.0, 1.0)))
        for rigid in (False, True):
            mine, other = (
                mesh_of(geometry, getattr(geometry, kind)(*sizes), hint, rigid=rigid)
                for geometry in (ours, theirs)
            )
            assert mine.num_vertices() == other.num_vertices()
            assert mine.num_elements() == other.num_elements()
            rows = [
                np.array(sorted(np.round(mesh.vertices(), 7).tolist())) for mesh in (mine, other)
            ]
            np.testing.assert_allclose(*rows, rtol=0, atol=2e-7)
            measures = [m.total_area() if rigid else m.CalcVolume() for m in (mine, other)]
            assert measures[0] == pytest.approx(measures[1], rel=1e-12)
            same += 1
    assert same == 80


@needs_pydrake
def test_a_box_with_two_least_sides_is_cut_into_fewer():
    import pydrake.geometry as theirs

    for sizes in ((1.0, 1.0, 3.0), (3.0, 1.0, 1.0), (1.0, 3.0, 1.0)):
        mine, other = (mesh_of(geometry, geometry.Box(*sizes), 0.7) for geometry in (ours, theirs))
        assert (mine.num_vertices(), mine.num_elements()) == (16, 32)
        assert (other.num_vertices(), other.num_elements()) == (17, 40)
    for sizes in ((1.0, 1.0, 1.0), (2.0, 2.0, 1.0), (1.0, 2.0, 3.0)):
        mine, other = (mesh_of(geometry, geometry.Box(*sizes), 0.7) for geometry in (ours, theirs))
        assert mine.num_vertices() == other.num_vertices()
        assert mine.num_elements() == other.num_elements()


def test_shapes_of_the_same_half_sizes_have_no_thin_cells():
    for shape in (
        ours.Box(1.0, 1.0, 1.0 + 1e-13),
        ours.Box(2.0, 1.0, 1.0),
        ours.Cylinder(1.0, 2.0 + 1e-13),
        ours.Cylinder(1.0, 2.0 - 1e-13),
    ):
        mesh = mesh_of(ours, shape, 0.5)
        volumes = [mesh.CalcTetrahedronVolume(e) for e in range(mesh.num_elements())]
        assert min(volumes) > 1e-3


def test_a_convex_is_cut_about_its_centre_of_volume():
    corners = np.array(
        [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)] + [[2, 0.5, 0.5]]
    )
    mesh = mesh_of(ours, ours.Convex(points=corners.T, label='house'), 1.0)
    assert mesh.CalcVolume() == pytest.approx(1.0 + 1.0 / 3.0)
    np.testing.assert_allclose(mesh.vertex(mesh.num_vertices() - 1), [0.6875, 0.5, 0.5])


@pytest.mark.parametrize(
    ('shape', 'hint', 'says'),
    [
        (ours.Sphere(1.0), 1e-4, 'too fine'),
        (ours.Cylinder(1.0, 1.0), 1e-5, 'too fine'),
        (ours.Capsule(0.5, 0.5), 0.006, 'too fine for the shape Capsule'),
        (ours.Sphere(0.0), 0.1, 'no volume'),
        (ours.HalfSpace(), 0.1, 'slab_thickness'),
        (ours.MeshcatCone(1.0), 0.1, 'MeshcatCone'),
    ],
)
def test_what_cannot_be_cut_is_refused(shape, hint, says):
    with pytest.raises(ours.GeometryError, match=says):
        mesh_of(ours, shape, hint)


def test_a_missing_hint_is_refused_and_the_scene_stays():
    scene, _ = registered(ours, ours.Box(1, 1, 1), 0.1, rigid=True)
    source = scene.RegisterSource('other')
    properties = ours.ProximityProperties()
    ours.AddRigidHydroelasticProperties(properties)
    ball = ours.GeometryInstance(RigidTransform(), ours.Sphere(1.0), 'ball')
    ball.set_proximity_properties(properties)
    with pytest.raises(ours.GeometryError, match="'hydroelastic/resolution_hint'"):
        scene.RegisterAnchoredGeometry(source, ball)
    assert scene.model_inspector().NumGeometriesForFrame(scene.world_frame_id()) == 1


def test_solid_meshes_are_rigid_only():
    data = ours.MeshData(
        np.vstack((np.zeros(3), np.eye(3))), [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    )
    shape = ours.Mesh.FromMeshData(data)
    assert mesh_of(ours, shape, 1.0, rigid=True).num_triangles() == 4
    assert mesh_of(ours, shape, 1.0).CalcVolume() == pytest.approx(1 / 6)
    scene, _ = registered(ours, shape, 1.0, rigid=True)
    properties = ours.ProximityProperties()
    properties.AddProperty('mesh', 'solid', True)
    ours.AddCompliantHydroelasticProperties(1.0, 1e5, properties)
    instance = ours.GeometryInstance(RigidTransform(), shape, 'solid')
    instance.set_proximity_properties(properties)
    with pytest.raises(ours.GeometryError, match='make it rigid'):
        scene.RegisterAnchoredGeometry(scene.RegisterSource('s'), instance)
