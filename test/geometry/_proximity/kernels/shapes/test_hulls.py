"""A climb ends where a look at every vertex does, whatever the hull."""

import numpy as np
import pytest
from oracles.worlds import random_rotations
from scipy.spatial import ConvexHull

from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import CLIMBED, hull_parameters
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    farthest_edge,
    farthest_vertex,
    hull_defect,
    hull_radius,
)
from truth.bodies.random_bodies import random_directions


def directions(count, rng):
    return np.vstack([random_directions(rng, count), np.eye(3), -np.eye(3)])


def on_ball(count, rng):
    return directions(count, rng)[:count]


def on_needle(count, rng):
    return on_ball(count, rng) * [1e-4, 1e-4, 1.0]


def drum(count, rng):
    """A cylinder as CAD programs write it: two polygons of many corners."""
    angle = np.linspace(0.0, 2.0 * np.pi, count // 2, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([np.insert(ring, 2, z, axis=1) for z in (-0.2, 0.2)])


def lattice(count, rng):
    """A rounded box of equal steps: most directions have several extreme vertices."""
    p = np.stack(np.meshgrid(*[np.arange(-4.0, 5.0)] * 3), axis=-1).reshape(-1, 3)
    return p[np.abs(np.linalg.norm(p, axis=1) - 4.0) < 0.3]


SHAPES = (on_ball, on_needle, drum, lattice)


def hull(points):
    """Return the corners of a hull and its triangles, counter-clockwise from outside."""
    found = ConvexHull(points)
    used = np.unique(found.simplices)
    triangles = np.searchsorted(used, found.simplices)
    a, b, c = (points[used][triangles[:, k]] for k in range(3))
    inwards = np.einsum('ij,ij->i', np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return points[used], triangles


@pytest.mark.parametrize('make', SHAPES)
@pytest.mark.parametrize('count', [CLIMBED, 1200])
def test_the_vertex_is_farthest_up_to_the_defect(make, count):
    rng = np.random.default_rng(count)
    vertices, triangles = hull(make(count, rng) @ random_rotations(rng, 1)[0].T + 0.1)
    shape = hull_parameters(vertices, triangles)
    assert hull_defect(shape) <= 600 * np.finfo(float).eps * np.ptp(vertices, axis=0).sum()
    normals = np.cross(*(vertices[triangles[:, k]] - vertices[triangles[:, 0]] for k in (1, 2)))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    rounding = 8 * np.finfo(float).eps * hull_radius(shape)
    # Face normals are the hard ones: all corners of the face are as far.
    for n in np.vstack([directions(300, rng), normals[:300]]):
        reached = float(np.dot(farthest_vertex(shape, *n), n))
        assert reached >= (vertices @ n).max() - hull_defect(shape) - rounding


@pytest.mark.parametrize('make', SHAPES)
@pytest.mark.parametrize('count', [20, 60, CLIMBED + 100])
def test_the_edge_is_that_of_least_slope(make, count):
    """Large hulls look at neighbours only, small ones at every vertex."""
    rng = np.random.default_rng(count)
    vertices, triangles = hull(make(count, rng) @ random_rotations(rng, 1)[0].T + 0.1)
    shape = hull_parameters(vertices, triangles)
    for n in directions(200, rng):
        here, other = (np.array(end) for end in farthest_edge(shape, *n))
        assert here == pytest.approx(farthest_vertex(shape, *n), abs=0)
        away = vertices - here
        lengths = np.linalg.norm(away, axis=1)
        there = lengths > 0.0
        slopes = -(away[there] @ n) / lengths[there]
        slope = -np.dot(other - here, n) / np.linalg.norm(other - here)
        assert slope <= slopes.min() + 1e-12


def test_large_hulls_have_edges_and_small_ones_none():
    rng = np.random.default_rng(0)
    small, large = (hull_parameters(*hull(on_ball(n, rng))) for n in (CLIMBED - 1, CLIMBED))
    assert len(small) == 8 + 3 * (CLIMBED - 1)
    assert hull_defect(small) == 0.0
    assert len(large) > 8 + 3 * CLIMBED
    assert hull_defect(large) > 0.0


def test_a_hull_with_many_flat_vertices_is_not_climbed():
    """Vertices that stick out by rounding only could end a climb anywhere."""
    side = np.linspace(-1.0, 1.0, 16)
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    bulge = 1.0 + 1e-9 * (2.0 - x**2 - y**2)
    points = np.vstack([np.column_stack([x, y, z]) for z in (bulge, -bulge)])
    vertices, triangles = hull(points)
    assert len(vertices) >= CLIMBED
    assert len(hull_parameters(vertices, triangles)) == 8 + 3 * len(vertices)


def test_radius_is_that_of_the_farthest_vertex():
    vertices, triangles = hull(on_ball(220, np.random.default_rng(1)) * [1.0, 2.0, 3.0])
    farthest = np.linalg.norm(vertices, axis=1).max()
    assert hull_radius(hull_parameters(vertices, triangles)) == pytest.approx(farthest, rel=1e-15)


@pytest.mark.parametrize('size', [1e-200, 1.0, 1e200])
@pytest.mark.parametrize('farthest', range(5))
def test_radius_counts_every_vertex_at_any_size(farthest, size):
    vertices = np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [-1, 0, 0]])
    vertices[farthest] *= 3.0
    shape = np.concatenate([[5.0], size * vertices.T.ravel()])
    with np.errstate(over='ignore'):
        assert hull_radius(shape) == pytest.approx(3.0 * size, rel=1e-15)
    for vertex in vertices:
        n = vertex / np.linalg.norm(vertex)
        assert farthest_vertex(shape, *n) == tuple(size * vertex)
