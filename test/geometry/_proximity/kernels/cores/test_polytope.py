"""The growing polytope stays a closed surface, and its bounds hold for triangles of any kind."""

from fractions import Fraction

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.cores import polytope
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put
from truth.bodies.random_bodies import random_directions

MOST = 80
ROWS = 8 * MOST
ORIGIN = (0.0, 0.0, 0.0)


class _Polytope:
    """A tetrahedron and what is expanded from it."""

    def __init__(self, corners):
        self.points = np.zeros((MOST, 9))
        for k, corner in enumerate(corners):
            put(self.points, k, tuple(corner), ORIGIN)
        self.faces = np.zeros((ROWS, polytope.FACE_WIDTH), dtype=np.int32)
        self.planes = np.zeros((ROWS, polytope.PLANE_WIDTH))
        self.heap, self.stack = np.zeros(ROWS, dtype=np.int32), np.zeros(ROWS, dtype=np.int32)
        self.horizon = np.zeros((ROWS, 3), dtype=np.int32)
        self.starting_at = np.full(MOST, -1, dtype=np.int32)
        polytope.link_tetrahedron(self.points, self.faces)
        self.count, self.total, self.waiting = 4, 4, 0
        self._add(0)

    def _add(self, first):
        self.waiting = polytope.add_faces(
            self.points, self.faces, self.planes, self.heap, first, self.total, self.waiting, 1.0
        )

    def pop(self):
        f, self.waiting = polytope.pop_living(self.faces, self.planes, self.heap, self.waiting)
        return f

    def expand(self, f, w):
        first = self.total
        self.total = polytope.expand(
            self.points, self.faces, self.planes, self.horizon, self.stack, self.starting_at,
            f, tuple(w), ORIGIN, self.count, self.total, 1.0,
        )  # fmt: skip
        self.count += 1
        self._add(first)

    def living(self):
        return [f for f in range(self.total) if self.faces[f, polytope.ALIVE]]

    def assert_closed(self):
        across = {}
        for f in self.living():
            for k in range(3):
                edge = self.faces[f, k], self.faces[f, (k + 1) % 3]
                assert edge not in across
                across[edge] = f, self.faces[f, polytope.ACROSS + k]
        for (start, end), (face, other) in across.items():
            assert across[end, start] == (other, face)


def test_expanding_the_nearest_face_keeps_the_surface_closed_and_fills_arandom_directions():
    polytope_ = _Polytope([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)] / np.sqrt(3))
    polytope_.assert_closed()
    offsets = []
    while polytope_.count < MOST:
        f = polytope_.pop()
        offsets.append(polytope_.planes[f, polytope.OFFSET])
        polytope_.expand(f, polytope_.planes[f, :3].copy())
        polytope_.assert_closed()
    assert np.all(np.diff(offsets) >= -1e-14)
    assert offsets[0] == pytest.approx(1 / 3, abs=1e-15)
    assert offsets[-1] > 0.9


def test_faces_come_off_the_heap_by_offset():
    rng = np.random.default_rng(1)
    planes = np.zeros((50, polytope.PLANE_WIDTH))
    planes[:, polytope.OFFSET] = rng.normal(size=50)
    faces = np.ones((50, polytope.FACE_WIDTH), dtype=np.int32)
    faces[::7, polytope.ALIVE] = 0
    heap, waiting = np.zeros(50, dtype=np.int32), 0
    for f in range(50):
        polytope.push(heap, waiting, planes, f)
        waiting += 1
    order = []
    while waiting > 0:
        f, waiting = polytope.pop_living(faces, planes, heap, waiting)
        if f >= 0:
            order.append(f)
    assert tuple(polytope.pop_living(faces, planes, heap, 0)) == (-1, 0)
    living = np.flatnonzero(faces[:, polytope.ALIVE])
    assert order == sorted(living, key=lambda f: planes[f, polytope.OFFSET])


@pytest.mark.parametrize('height', [1.0, 1e-6, 1e-12, 1e-16, 0.0])
def test_no_point_of_a_face_is_nearer_than_its_offset(height):
    rng = np.random.default_rng(2)
    for a, b, off in zip(*(random_directions(rng, 20) for _ in range(3)), strict=True):
        c = 0.3 * a + 0.7 * b + height * off
        points = np.zeros((4, 9))
        for k, corner in enumerate((a, b, c)):
            put(points, k, tuple(corner), ORIGIN)
        faces = np.array([[0, 1, 2, 0, 0, 0, 1]], dtype=np.int32)
        planes = np.zeros((1, polytope.PLANE_WIDTH))
        polytope.set_plane(faces, planes, points, 0, 1.0)
        assert np.linalg.norm(planes[0, :3]) == pytest.approx(1, abs=1e-15)
        weights = rng.dirichlet(np.ones(3), size=200)
        nearest = np.linalg.norm(weights @ np.array([a, b, c]), axis=1).min()
        assert planes[0, polytope.OFFSET] <= nearest + 1e-15


@pytest.mark.parametrize('power', [2.0**-40, 1.0, 2.0**40])
@pytest.mark.parametrize(
    ('corners', 'normal', 'offset'),
    [
        ([(-1, 2, 0), (0, 2, 0), (1, 2, 0)], (0, 1, 0), 2.0),
        ([(0, 2, 0), (1, 2, 0), (0, 2, 0)], (0, 1, 0), 2.0),
        ([(0, 2, 1), (0, 2, 1), (0, 2, 1)], (0, 2 / 5**0.5, 1 / 5**0.5), 5**0.5),
        ([(3, 4, 0), (6, 8, 0), (9, 12, 0)], (0.6, 0.8, 0), 5.0),
        ([(-1, 0, 0), (0, 0, 0), (1, 0, 0)], None, 0.0),
        ([(1, 0, 0), (1, 0, 0), (-1, 0, 0)], None, 0.0),
        ([(0, 0, 2), (1, 0, 2), (0, 1, 2)], (0, 0, 1), 2.0),
        ([(0, 0, 2), (0, 1, 2), (1, 0, 2)], (0, 0, -1), -2.0),  # the origin is in front of it
    ],
)
def test_corners_in_a_row_have_the_plane_across_the_way_to_them(corners, normal, offset, power):
    points = np.zeros((4, 9))
    for k, corner in enumerate(corners):
        put(points, k, tuple(power * np.array(corner, dtype=float)), ORIGIN)
    faces = np.array([[0, 1, 2, 0, 0, 0, 1]], dtype=np.int32)
    planes = np.zeros((1, polytope.PLANE_WIDTH))
    polytope.set_plane(faces, planes, points, 0, power)
    found = planes[0, :3]
    if normal is None:
        assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)
        assert found[0] == 0.0
    else:
        np.testing.assert_allclose(found, normal, rtol=0, atol=1e-15)
    assert planes[0, polytope.OFFSET] == pytest.approx(power * offset, rel=1e-15)


@pytest.mark.parametrize(('height', 'seen'), [(0.4e-15, False), (1.8e-15, True), (1.0, True)])
def test_what_is_in_the_plane_of_a_face_does_not_kill_it(height, seen):
    """Above the slanted face of a tetrahedron and, by the height, above that at x = 0."""
    tetrahedron = _Polytope([(0, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0)])
    upright, slanted = (int(np.argmax(tetrahedron.planes[:4, axis])) for axis in (0, 1))
    tetrahedron.expand(slanted, (height, 0.9, 0.9))
    tetrahedron.assert_closed()
    assert tetrahedron.faces[slanted, polytope.ALIVE] == 0
    assert tetrahedron.faces[upright, polytope.ALIVE] == (0 if seen else 1)


def test_there_is_room_to_the_last_face():
    for rows, grown in ((6, 4), (7, 7)):  # a corner cut off a tetrahedron: three faces for one
        tetrahedron = _Polytope([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        tetrahedron.faces, tetrahedron.planes = tetrahedron.faces[:rows], tetrahedron.planes[:rows]
        f = int(np.argmax(tetrahedron.planes[:4, polytope.OFFSET]))
        tetrahedron.expand(f, (0.5, 0.5, 0.5))
        assert tetrahedron.total == grown


def test_a_face_of_one_point_has_a_normal_still():
    faces = np.array([[0, 1, 2, 0, 0, 0, 1]], dtype=np.int32)
    planes = np.zeros((1, polytope.PLANE_WIDTH))
    polytope.set_plane(faces, planes, np.zeros((4, 9)), 0, 1.0)
    assert np.linalg.norm(planes[0, :3]) == 1.0
    assert planes[0, polytope.OFFSET] == 0.0


def test_a_horizon_that_meets_itself_is_refused():
    horizon = np.array([[0, 1, 0], [1, 0, 0], [0, 2, 0]], dtype=np.int32)
    faces = np.zeros((20, polytope.FACE_WIDTH), dtype=np.int32)
    starting_at = np.full(4, -1, dtype=np.int32)
    assert polytope.link_cone(faces, horizon, 3, 3, 10, starting_at) == 10


@pytest.mark.parametrize('turn', range(3))
@pytest.mark.parametrize('thin', [1e-3, 1e-6, 1e-9])
def test_the_normal_of_a_thin_triangle_is_as_exact_as_of_a_wide_one(turn, thin):
    """Two of its corners are close to each other; the truth is in exact arithmetic."""
    rng = np.random.default_rng(9)
    for _ in range(20):
        corners = rng.uniform(0.5, 1.0, (3, 3))
        corners[1] = corners[0] + thin * rng.normal(size=3)
        corners = np.roll(corners, turn, axis=0)
        a, b, c = np.vectorize(Fraction)(corners)
        (x, y, z), (u, v, w) = b - a, c - a
        exact = [y * w - z * v, z * u - x * w, x * v - y * u]
        largest = max(abs(each) for each in exact)
        truth = np.array([float(each / largest) for each in exact])
        found = polytope.normal(*(tuple(corner.tolist()) for corner in corners))
        assert found == pytest.approx(truth / np.linalg.norm(truth), abs=1e-14)
