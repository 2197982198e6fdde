"""A compliant Mesh of a .vtk file: its own tetrahedra, and a pressure by the distance inward."""

import itertools
import logging

import numpy as np
import pytest
from oracles.contact_scenes import Body, query_of, surfaces
from oracles.mesh_files import vtk

import drake_geom_ros.geometry as ours
from drake_geom_ros.math import RigidTransform
from truth.bodies.random_bodies import random_rotation

MODULUS = 1e5


def ell(cells=3, seed=0):
    """Return points and tetrahedra of an L of cubes, its inner points moved at random."""
    kept = [
        cube
        for cube in itertools.product(range(2 * cells), range(cells), range(2 * cells))
        if cube[0] < cells or cube[2] < cells
    ]
    points, rows = cubes(kept)
    mesh = ours.VolumeMesh.FromArrays(rows, points)
    boundary = set(map(tuple, ours.ConvertVolumeToSurfaceMesh(mesh).vertex_array().tolist()))
    inner = np.array([tuple(point) not in boundary for point in points.tolist()])
    points[inner] += np.random.default_rng(seed).uniform(-0.15, 0.15, (inner.sum(), 3))
    return points / (2 * cells), rows


def cubes(kept):
    """Return points and tetrahedra of cubes of size 1, by their lowest corners."""
    # Six tetrahedra along the diagonal of each cube fit those of its neighbours.
    corners, rows = {}, []
    for cube in kept:
        for order in itertools.permutations(range(3)):
            at, row = np.array(cube), []
            for axis in (None, *order):
                if axis is not None:
                    at = at + np.eye(3, dtype=int)[axis]
                row.append(corners.setdefault(tuple(at.tolist()), len(corners)))
            turn = np.linalg.det(np.eye(3)[list(order)])
            rows.append(row if turn > 0 else [row[1], row[0], *row[2:]])
    return np.array(list(corners), dtype=float), rows


def sums_of(found):
    """Return number, area, force on M and pressures at the middles of the faces."""
    mesh, field = found.poly_mesh_W(), found.poly_e_MN()
    faces = range(mesh.num_elements())
    areas = np.array([mesh.area(k) for k in faces])
    pressures = [field.EvaluateCartesian(k, mesh.element_centroid(k)) for k in faces]
    force = (areas * pressures) @ np.array([mesh.face_normal(k) for k in faces])
    return len(areas), areas.sum(), force, np.sort(pressures)


def inside_the_hole(cube):
    return 3 <= cube[0] < 9 and 3 <= cube[1] < 9


@pytest.fixture(scope='module')
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp('vtk') / 'ell.vtk'
    path.write_text(vtk(*ell()))
    return str(path)


@pytest.fixture(scope='module')
def refined_path(tmp_path_factory):
    """The L without tetrahedra that have all corners on the boundary."""
    points, rows = ell()
    mesh = ours.RefineVolumeMesh(ours.VolumeMesh.FromArrays(rows, points))
    path = tmp_path_factory.mktemp('vtk') / 'refined.vtk'
    path.write_text(vtk(mesh.vertex_array(), mesh.element_array().tolist()))
    return str(path)


def of_file(path, modulus=MODULUS, scale=1.0):
    return Body('MeshFile', (path, scale), modulus)


def mesh_and_pressures(path, scale=1.0):
    query, (id,), _ = query_of([of_file(path, scale=scale)], [(np.eye(3), np.zeros(3))])
    inspector = query.inspector()
    mesh = inspector.maybe_get_hydroelastic_mesh(id)
    return mesh, inspector.maybe_get_hydroelastic_pressures(id)


def brute_distances(points):
    """Return how far points are inside the L of size 1: by its sides, and the edge within."""
    x, y, z = points.T
    to_sides = np.minimum.reduce([x, z, y, 0.5 - y])
    within = np.hypot(np.maximum(0.5 - x, 0.0), np.maximum(0.5 - z, 0.0))
    return np.minimum.reduce([to_sides, within, 1 - x, 1 - z])


def test_the_pressure_grows_with_the_distance_to_the_boundary(path):
    mesh, pressures = mesh_and_pressures(path)
    points, rows = ell()
    refined = ours.RefineVolumeMesh(ours.VolumeMesh.FromArrays(rows, points))
    np.testing.assert_array_equal(mesh.vertex_array(), refined.vertex_array())
    np.testing.assert_array_equal(mesh.element_array(), refined.element_array())
    distances = brute_distances(mesh.vertex_array())
    expected = MODULUS * distances / distances.max()
    np.testing.assert_allclose(pressures, expected, rtol=1e-7, atol=1e-9)
    assert pressures.max() == MODULUS


@pytest.mark.parametrize('scale', [2.0, (1, 1, -1), (-0.5, 1, 2)])
def test_it_scales(path, scale):
    mesh, pressures = mesh_and_pressures(path, scale)
    assert mesh.CalcVolume() == pytest.approx(0.375 * abs(np.prod(np.broadcast_to(scale, 3))))
    assert (pressures >= 0.0).all()
    assert pressures.max() == MODULUS


def poses_and_others(path, count):
    random = np.random.default_rng(4)
    others = [Body('Sphere', (0.4,), 2e5), Body('Box', (0.5, 0.6, 0.7), 0.0)]
    others += [Body('HalfSpace', (), 0.0), of_file(path, 2e5, (1, -1, 1))]
    for number in range(count):
        poses = [(random_rotation(random), random.normal(size=3) * 0.2) for _ in range(2)]
        bodies = [of_file(path, 0.0 if number % 5 == 4 else MODULUS), others[number % 4]]
        if bodies[0].modulus == 0.0 and bodies[1].modulus == 0.0:
            bodies[1] = others[0]
        yield bodies, poses


def test_surfaces_are_pydrakes(refined_path):
    theirs = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    logging.getLogger('drake').setLevel(logging.ERROR)
    compared = 0
    for bodies, poses in poses_and_others(refined_path, 48):
        mine, other = surfaces(bodies, poses), surfaces(bodies, poses, theirs)
        assert len(mine) == len(other)
        for a, b in zip(mine, other, strict=True):
            count, area, force, pressures = sums_of(a)
            count_b, area_b, force_b, pressures_b = sums_of(b)
            assert count == count_b
            assert area == pytest.approx(area_b, rel=1e-9)
            np.testing.assert_allclose(force, force_b, rtol=1e-9, atol=1e-9 * MODULUS)
            np.testing.assert_allclose(pressures, pressures_b, rtol=1e-9, atol=1e-9 * MODULUS)
            compared += 1
    assert compared >= 10


BLOCK = list(itertools.product(range(3), repeat=3))
FIN = [*BLOCK, *((x, 1, 1) for x in range(3, 9))]  # with corners on the boundary alone
TWO = [*BLOCK, *((x + 20, y, z) for x, y, z in BLOCK)]
RING = [c for c in itertools.product(range(12), range(12), range(3)) if not inside_the_hole(c)]


def found_with(tmp_path, kept, other, place):
    """Return the surfaces of cubes and another body, which is at a place."""
    path = tmp_path / 'cubes.vtk'
    path.write_text(vtk(*cubes(kept)))
    poses = [(np.eye(3), np.zeros(3)), (np.eye(3), np.array(place))]
    query, _, _kept = query_of([of_file(str(path)), other], poses)
    return query.ComputeContactSurfaces()


@pytest.mark.parametrize('x', [6.5, 10.0])
@pytest.mark.parametrize('modulus', [0.0, 1e5])
def test_a_thin_fin_presses(tmp_path, x, modulus):
    """Its tetrahedra have no pressure as they come: in a ball they overlapped, and looked free."""
    (found,) = found_with(tmp_path, FIN, Body('Sphere', (1.4,), modulus), (x, 1.5, 1.5))
    assert found.total_area() > 1.0


def test_several_pieces_are_refused(tmp_path):
    """The box has one of them deep within, which has no surface with it; the other is free."""
    with pytest.raises(ours.GeometryError, match='in 2 pieces, which share no face'):
        found_with(tmp_path, TWO, Body('Box', (9.0, 9.0, 9.0), 0.0), (21.5, 1.5, 1.5))


def test_the_hole_of_a_ring_is_free(tmp_path):
    assert len(found_with(tmp_path, RING, Body('Sphere', (1.0,), 1e5), (6.0, 6.0, 1.5))) == 0
    deep = Body('Sphere', (0.3,), 1e-3)
    with pytest.raises(ours.GeometryError, match='overlap and have no surface'):
        found_with(tmp_path, RING, deep, (1.5, 6.0, 1.5))
    with pytest.raises(ours.GeometryError, match='overlap and have no surface'):
        found_with(tmp_path, RING, Body('Box', (30.0, 30.0, 30.0), 0.0), (6.0, 6.0, 1.5))


def test_the_mesh_and_the_penetration_are_pydrakes(refined_path):
    theirs = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    bodies, poses = (
        [of_file(refined_path), Body('Sphere', (0.4,), 2e5)],
        [(np.eye(3), np.zeros(3))] * 2,
    )
    # Where only the hull is: between the arms of the L.
    poses[1] = np.eye(3), np.array([0.85, 0.25, 0.85])
    found = []
    for geometry in (ours, theirs):
        query, ids, _kept = query_of(bodies, poses, geometry)
        mesh = query.inspector().maybe_get_hydroelastic_mesh(ids[0])
        assert not isinstance(mesh, geometry.TriangleSurfaceMesh)
        (pair,) = query.ComputePointPairPenetration()
        vertices = np.array([np.asarray(vertex) for vertex in mesh.vertices()])
        found.append((mesh.num_elements(), vertices, pair.depth))
    assert found[0][0] == found[1][0]
    np.testing.assert_array_equal(found[0][1], found[1][1])
    assert found[0][2] == pytest.approx(found[1][2], abs=1e-9)


def test_a_solid_has_its_own_tetrahedra_too(path):
    """What is refused of other meshes, whose tetrahedra would be those of the hull."""
    scene = ours.SceneGraph()
    properties = ours.ProximityProperties()
    ours.AddCompliantHydroelasticProperties(1.0, MODULUS, properties)
    properties.AddProperty('mesh', 'solid', True)
    instance = ours.GeometryInstance(RigidTransform(), ours.Mesh(path), 'body')
    instance.set_proximity_properties(properties)
    id = scene.RegisterAnchoredGeometry(scene.RegisterSource('source'), instance)
    mesh = scene.model_inspector().maybe_get_hydroelastic_mesh(id)
    assert mesh.num_elements() >= len(ell()[1])


def test_without_a_vertex_inside_it_gets_one(tmp_path):
    one = tmp_path / 'one.vtk'
    one.write_text(vtk([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]]))
    _, pressures = mesh_and_pressures(str(one))
    assert pressures.tolist() == [0, 0, 0, 0, MODULUS]
