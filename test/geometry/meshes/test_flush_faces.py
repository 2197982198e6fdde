"""Bodies of one mesh that lie on each other are one solid, without the area between them."""

import numpy as np
import pytest
import trimesh
from oracles.forms import row_of

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import (
    GeometryInstance,
    Mesh,
    MeshData,
    MeshFileError,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry.meshes._flush_faces import without_flush_areas
from drake_geom_ros.geometry.meshes._solids import solid_of, volume
from drake_geom_ros.math import RigidTransform
from truth.bodies.grids import surface

ONES = (1.0, 1.0, 1.0)
PLATE = ((2.0, 2.0, 0.125), (0.0, 0.0, 0.0))
ON_PLATE = ((0.5, 0.25, 0.75), (0.125, 0.25, 0.4375))
BESIDE = ((0.25, 0.5, 0.5), (0.5, 0.25, 0.3125))
CASES = {
    'a block on a plate': (PLATE, ON_PLATE),
    'two blocks on a plate that touch': (PLATE, ON_PLATE, BESIDE),
    'a part of a face': (((1, 1, 1), (0, 0, 0)), ((1, 1, 1), (1, 0.5, 0.25))),
    'in a corner of a face': (((1, 1, 1), (0, 0, 0)), ((0.5, 0.5, 0.5), (0.75, 0.25, 0.25))),
    'a plate on both sides': (PLATE, ON_PLATE, ((0.5, 0.5, 0.5), (0.25, 0.25, -0.3125))),
}


def box(size, centre):
    return trimesh.creation.box(
        extents=size, transform=trimesh.transformations.translation_matrix(centre)
    )


def joined(*meshes):
    """The triangles of all, without a common boundary."""
    counts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + n for mesh, n in zip(meshes, counts, strict=False)]
    return np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces)


def cells_of(boxes):
    """The surface of the union of boxes: that of cells of a grid through all their faces."""
    lows, highs = (np.array([np.add(c, 0.5 * s * np.array(e)) for e, c in boxes]) for s in (-1, 1))
    ticks = [np.unique(np.concatenate((lows[:, k], highs[:, k]))) for k in range(3)]
    inside = []
    for cell in np.ndindex(*(len(t) - 1 for t in ticks)):
        middle = np.array([ticks[k][i : i + 2].mean() for k, i in enumerate(cell)])
        if ((lows < middle) & (middle < highs)).all(axis=1).any():
            inside.append(cell)
    vertices, triangles = surface(inside, ticks)
    return np.array(vertices), np.array(triangles)


def turn(seed):
    """A rotation and a translation [m], neither for the seed 0."""
    rng = np.random.default_rng(seed)
    if seed == 0:
        return np.eye(3), np.zeros(3)
    return np.linalg.qr(rng.normal(size=(3, 3)))[0] * [1, 1, 1], rng.normal(size=3) * 10


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('name', CASES)
def test_distances_and_depths_are_those_of_the_union(name, seed):
    """Balls around and in the bodies, also where two of them meet."""
    boxes = CASES[name]
    R, p = turn(seed)
    scale = np.diag([1.0, 1.0, np.sign(np.linalg.det(R))])
    R = R @ scale
    vertices, triangles = joined(*(box(*each) for each in boxes))
    parts = MeshData(vertices @ R.T + p, triangles)
    union = cells_of(boxes)
    truth = Body('Solid', union[0] @ R.T + p, triangles=union[1])
    mesh = Body('Solid', np.array(parts.vertices), triangles=triangles)
    assert solid_of(parts, ONES)[0] == SOLID
    rng = np.random.default_rng(seed)
    for at in [*rng.uniform(-0.7, 0.9, (12, 3)), [0.125, 0.25, 0.0625], [0.5, 0.25, 0.25]]:
        ball = Body('Sphere', (0.05,), p=R @ np.array(at) + p)
        rows = [row_of(ball, body) for body in (mesh, truth)]
        assert abs(rows[0][0] - rows[1][0]) <= rows[0][10] + rows[1][10], at
    points = rng.uniform(-0.7, 0.9, (200, 3)) @ R.T + p
    of_parts, of_union = (
        distances_to(MeshData(body.size, body.triangles), points) for body in (mesh, truth)
    )
    np.testing.assert_allclose(of_parts, of_union, rtol=0.0, atol=1e-12)
    assert (of_parts < 0.0).any()


def distances_to(mesh, points):
    """The signed distances [m] of points to a mesh."""
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), Mesh.FromMeshData(mesh), 'm')
    instance.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    return query.ComputeSignedDistanceToPoint(points).distance


def test_a_cylinder_stands_on_a_plate():
    """The cut is along chords; a ball in the plate beneath it sees the plate's bottom."""
    cylinder = trimesh.creation.cylinder(0.3, 0.5, transform=box_pose((0.2, 0.1, 0.3125)))
    parts = MeshData(*joined(box(*PLATE), cylinder))
    assert solid_of(parts, ONES)[0] == SOLID
    mesh = Body('Solid', np.array(parts.vertices), triangles=np.array(parts.triangles))
    ball = Body('Sphere', (0.01,), p=np.array([0.2, 0.1, 0.0625]))
    assert row_of(ball, mesh)[0] == pytest.approx(-0.125 - 0.01, abs=1e-12)


def box_pose(centre):
    return trimesh.transformations.translation_matrix(centre)


@pytest.mark.parametrize('name', CASES)
def test_cutting_keeps_the_volume_and_halves_no_other_area(name):
    vertices, triangles = joined(*(box(*each) for each in CASES[name]))
    corners = vertices[triangles]
    cut = without_flush_areas(corners)
    assert volume(cut.corners) == pytest.approx(volume(corners), rel=1e-12)
    union = cells_of(CASES[name])
    assert areas(cut.corners) == pytest.approx(areas(union[0][union[1]]), rel=1e-12)


def areas(corners):
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(sides, axis=1).sum()


def test_faces_that_are_apart_or_look_the_same_way_are_left_alone():
    above = ((0.5, 0.25, 0.75), (0.125, 0.25, 0.4375 + 1e-9))
    for boxes in ((PLATE, above), (PLATE, ((1, 1, 0.125), (0, 0, 0)))):
        vertices, triangles = joined(*(box(*each) for each in boxes))
        assert without_flush_areas(vertices[triangles]) is None


def test_a_block_that_is_sunk_into_the_plate_is_refused():
    size, (x, y, z) = ON_PLATE
    with pytest.raises(MeshFileError, match='crosses itself'):
        solid_of(MeshData(*joined(box(*PLATE), box(size, (x, y, z - 1e-3)))), ONES)
