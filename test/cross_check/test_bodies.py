"""Bodies: public shape, truth and surface are the same, wherever a body is; grids, too."""

import pickle

import numpy as np
import pytest
from oracles import body_truth as truth
from oracles import closed_forms
from oracles.hard_cases.construct import turned, unit

from drake_geom_ros.cross_check.bodies import BOUNDED, PRIMITIVES, Body, Pair
from drake_geom_ros.cross_check.surfaces import height, support_value, width
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry.meshes._solids import volume
from drake_geom_ros.geometry.meshes._welding import merged
from drake_geom_ros.geometry.shapes.primitives import for_queries
from truth.bodies import grids
from truth.bodies.grids import L, solid
from truth.bodies.random_bodies import random_body, random_rotation


def body(kind):
    return random_body(np.random.default_rng(1), kind, 12)


@pytest.mark.parametrize('kind', [*PRIMITIVES, 'Convex', 'Mesh'])
def test_the_shape_is_that_of_the_truth(kind):
    number, parameters = body(kind).form
    shape = body(kind).shape
    counts_as, ours = for_queries(shape).in_pairs
    assert counts_as == (CONVEX if kind == 'Mesh' else number)
    if kind in ('Convex', 'Mesh'):  # the hull may order its vertices anew
        end = 1 + 3 * int(parameters[0])
        ours, parameters = (np.sort(x[1:end].reshape(3, -1), axis=1) for x in (ours, parameters))
    np.testing.assert_array_equal(ours, parameters)


def test_a_point_is_a_sphere_without_size_to_others():
    point = body('Point')
    assert point.shape.radius() == 0.0
    assert point.radius == 0.0
    assert point.form[0] == 1


def test_radii():
    assert Body('Capsule', (1.0, 4.0)).radius == 3.0
    assert Body('Cylinder', (3.0, 8.0)).radius == 5.0
    assert Body('Box', (3.0, 4.0, 12.0)).radius == 6.5
    assert Body('HalfSpace').radius == 0.0
    assert Body('Convex', ((0.0, 3.0, 4.0), (1.0, 0.0, 0.0))).radius == 5.0


def test_a_body_that_was_moved_shares_its_shape():
    one, R = body('Convex'), random_rotation(np.random.default_rng(3))
    shape = one.shape
    moved = one.placed(R, np.ones(3)).moved(R.T, np.array([1.0, 0.0, 0.0]))
    assert moved.shape is shape
    np.testing.assert_allclose(moved.R, np.eye(3), rtol=0, atol=1e-15)
    np.testing.assert_allclose(moved.p, R.T @ np.ones(3) + [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(one.p, np.zeros(3))
    assert one.scaled(2.0).radius == 2.0 * one.radius


def test_what_is_pickled_is_made_anew():
    one = Body('Box', (1.0, 2.0, 3.0))
    assert one.shape.depth() == 2.0
    again = pickle.loads(pickle.dumps(one))
    assert again.__dict__.keys() == Body('Box').__dict__.keys()
    assert again.shape == one.shape


def test_a_solid_has_its_property_and_triangles_with_an_area():
    notch = solid(L)
    assert notch.properties.GetProperty('mesh', 'solid') is True
    assert not body('Mesh').properties.HasGroup('mesh')
    flat = Body('Solid', notch.size, triangles=(*notch.triangles, (0, 1, 0)))
    assert len(flat.corners) == len(notch.corners) == len(notch.triangles)


def test_the_smaller_body_of_a_pair():
    pair = Pair(Body('Box', (3.0, 4.0, 12.0)), Body('Sphere', (0.0,), p=np.array([0, 0, 20.0])))
    assert (pair.extent, pair.smaller, pair.away) == (6.5 + 20.0, 6.5, 20.0)
    assert Pair(Body('HalfSpace'), Body('Sphere', (2.0,))).smaller == 2.0
    assert Pair(Body('HalfSpace'), Body('Point')).smaller == 0.0


CELLS = {'L': grids.L, 'U': grids.U, 'ring': grids.RING, 'hollow': grids.HOLLOW}
names = pytest.mark.parametrize('name', CELLS)


@names
@pytest.mark.parametrize('cuts', [1, 3])
def test_the_surface_is_closed_and_looks_out(name, cuts):
    body = grids.solid(CELLS[name], cuts=cuts, scale=0.5)
    assert volume(body.corners) == pytest.approx(len(CELLS[name]) / 8.0)
    vertices, triangles = merged(np.array(body.size), np.array(body.triangles))
    assert len(vertices) == len(body.size)  # none stands twice
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert len(triangles) == cuts**2 * len(grids.surface(CELLS[name])[1])


@names
def test_the_boxes_are_the_body(name):
    parts = grids.boxes(CELLS[name])
    middles = np.array(CELLS[name]) + 0.5
    inside = [(np.abs(middles - box.p) < 0.5 * np.array(box.size)).all(axis=1) for box in parts]
    assert np.any(inside, axis=0).all()
    holes = np.array([cell for cell in np.ndindex(4, 4, 4) if cell not in CELLS[name]]) + 0.5
    assert not any((np.abs(holes - b.p) < 0.5 * np.array(b.size)).all(axis=1).any() for b in parts)


def test_only_the_largest_boxes_are_told():
    sizes = sorted(box.size for box in grids.boxes(grids.U))
    assert sizes == [(1.0, 2.0, 1.0), (1.0, 2.0, 1.0), (3.0, 1.0, 1.0)]
    assert [box.size for box in grids.boxes(grids.CUBE)] == [(1.0, 1.0, 1.0)]


def test_lines_may_lie_anywhere():
    lines = [np.array([-1.0, 0.0, 4.0]), np.array([0.0, 0.5, 1.0]), np.array([2.0, 3.0])]
    body = grids.solid(grids.L, lines, cuts=2)
    assert volume(body.corners) == pytest.approx(1.0 * 0.5 + 4.0 * 0.5 + 1.0 * 0.5)
    assert sorted(box.size for box in body.parts) == [(1.0, 1.0, 1.0), (5.0, 0.5, 1.0)]
    np.testing.assert_array_equal(
        np.unique(np.array(body.size)[:, 0]), [-1.0, -0.5, 0.0, 2.0, 4.0]
    )


@pytest.mark.parametrize('kind', [*BOUNDED, 'Convex'])
def test_reach_and_height_of_the_extreme_point(kind):
    rng = np.random.default_rng(1)
    for _ in range(20):
        one, n = turned(rng, kind), unit(rng.normal(size=3))
        p = truth.support_point(one, n)
        assert support_value(one, n) == pytest.approx((p - one.p) @ n, abs=1e-14)
        assert height(one, p) == pytest.approx(0.0, abs=1e-14)
        # Before a corner of a hull, or a strong curve, the height is that over one plane.
        assert 1e-4 < height(one, p + 1e-3 * n) < 1.2e-3
        if kind != 'Convex':
            inside = p - 1e-3 * n
            expected = float(closed_forms.point_distance(*one.form, one.R.T @ (inside - one.p)))
            # That of an ellipsoid is the first order of it.
            off = 1e-5 if kind == 'Ellipsoid' else 1e-14
            assert height(one, inside) == pytest.approx(expected, abs=off)


def test_a_half_space_reaches_along_its_normal_only():
    plane = turned(np.random.default_rng(2), 'HalfSpace')
    assert support_value(plane, plane.R[:, 2]) == 0.0
    assert support_value(plane, plane.R[:, 0]) == np.inf
    assert height(plane, plane.p - 2.0 * plane.R[:, 2]) == pytest.approx(-2.0)


def test_the_width_of_a_pair():
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = turned(rng, 'Box'), turned(rng, 'Ellipsoid')
        n = unit(rng.normal(size=3))
        apart = truth.support_point(a, -n) - truth.support_point(b, n)
        assert width(a, b, n) == pytest.approx(apart @ n, abs=1e-14)
