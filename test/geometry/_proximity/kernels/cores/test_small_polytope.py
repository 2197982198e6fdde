"""The polytope without links stays a closed surface, and its planes are those of its corners."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.cores import small_polytope
from drake_geom_ros.geometry._proximity.kernels.cores.polytope import plane_of
from truth.bodies.random_bodies import random_directions

OCTAHEDRON = (
    *((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)),
    *((2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)),
)
CORNERS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


class _Polytope:
    def __init__(self, vertices, faces):
        self.block = np.zeros(small_polytope.growth_numbers())
        self.growth = small_polytope.growth_arrays(self.block)
        self.points, self.corners, self.planes, self.masks, _, _ = self.growth
        self.count, self.total = len(vertices), len(faces)
        self.points[: self.count, :3] = vertices
        for f, corners in enumerate(faces):
            small_polytope.set_corners(self.corners, f, *corners)
        self.set_planes(0)

    def set_planes(self, first):
        arrays = self.points, self.corners, self.planes
        small_polytope.set_planes(*arrays, first, self.total, 2.0)

    def add(self, vertex):
        """Grow to a vertex; return the number of new faces."""
        self.points[self.count, :3] = vertex
        self.total, new = small_polytope.expand(self.growth, self.count, self.total, 1e-15)
        self.set_planes(self.total - new)
        self.count += new > 0
        return new

    def is_closed(self):
        return small_polytope.is_closed(self.corners, self.count, self.total, self.masks)

    def rows(self, array, rows):
        return np.asarray(array).reshape(-1, small_polytope.MOST_ROWS)[rows, : self.total]


def test_it_grows_to_any_points_and_stays_closed_and_convex():
    rng = np.random.default_rng(1)
    polytope = _Polytope(CORNERS, OCTAHEDRON)
    for p in random_directions(rng, small_polytope.MOST_GROWN - 6):
        assert polytope.add(p) >= 3
        assert polytope.is_closed()
        assert polytope.total == 2 * polytope.count - 4
    normals = polytope.rows(polytope.planes, [0, 1, 2]).T
    offsets, keys = polytope.rows(polytope.planes, [small_polytope.OFFSET, small_polytope.KEY])
    np.testing.assert_array_equal(keys, offsets)
    points = polytope.points[: polytope.count, :3]
    assert (points @ normals.T <= offsets + 1e-14).all()
    nearest = small_polytope.nearest(polytope.planes, polytope.total)
    assert offsets[nearest] == offsets.min()


def test_nothing_sees_a_point_inside():
    polytope = _Polytope(CORNERS, OCTAHEDRON)
    assert polytope.add((0.1, 0.2, 0.3)) == 0
    assert polytope.total == len(OCTAHEDRON)
    assert polytope.is_closed()


def test_a_horizon_that_comes_to_a_vertex_twice_is_left_alone():
    """Two opposite faces at a vertex are made to see the point, and their neighbours not."""
    polytope = _Polytope(CORNERS, OCTAHEDRON)
    offsets = polytope.planes[small_polytope.MOST_ROWS * small_polytope.OFFSET :]
    offsets[:8] = [0.0, 9.0, 0.0, 9.0, 9.0, 9.0, 9.0, 9.0]
    assert polytope.add((0.0, 0.0, 2.0)) == 0
    assert polytope.total == len(OCTAHEDRON)
    assert polytope.is_closed()


@pytest.mark.parametrize('kind', ['point', 'needle', 'in a row', 'tiny'])
def test_the_plane_of_a_sliver_is_that_of_a_polytope(kind):
    rng = np.random.default_rng(3)
    vertices = CORNERS.copy()
    if kind == 'point':
        vertices[2] = vertices[0]
    elif kind == 'needle':
        vertices[2] = vertices[0] + 1e-15 * rng.normal(size=3)
    elif kind == 'in a row':
        vertices[2] = 0.5 * (vertices[0] + vertices[4])
    else:
        vertices = 1e-160 * vertices
    polytope = _Polytope(vertices, OCTAHEDRON)
    faces = polytope.rows(polytope.corners, [0, 1, 2]).T
    planes = polytope.rows(polytope.planes, [0, 1, 2, 3]).T
    for corners, plane in zip(faces, planes, strict=True):
        n, offset = plane_of(*(tuple(vertices[v]) for v in corners), 2.0)
        np.testing.assert_allclose(plane, [*n, offset], rtol=0, atol=1e-15)
        np.testing.assert_allclose(np.linalg.norm(plane[:3]), 1.0, rtol=0, atol=1e-14)


def test_no_face_is_nearest_where_there_is_none_or_all_are_settled():
    polytope = _Polytope(CORNERS, OCTAHEDRON)
    assert small_polytope.nearest(polytope.planes, 0) == 0
    polytope.planes[small_polytope.MOST_ROWS * small_polytope.KEY :][:8] = np.inf
    assert polytope.planes[small_polytope.MOST_ROWS * small_polytope.KEY] == np.inf
    assert small_polytope.nearest(polytope.planes, 8) in range(9)
