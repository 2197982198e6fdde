"""Bodies: the public shape and the truth's shape are the same one, wherever it is."""

import pickle

import numpy as np
import pytest

from drake_geom_ros.evidence.bodies import Body, Pair
from drake_geom_ros.evidence.grids import L, solid
from drake_geom_ros.evidence.random_bodies import random_body, random_rotation

KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'HalfSpace', 'Convex', 'Mesh')


def body(kind):
    return random_body(np.random.default_rng(1), kind, 12)


@pytest.mark.parametrize('kind', KINDS)
def test_the_shape_is_that_of_the_truth(kind):
    number, parameters = body(kind).form
    shape = body(kind).shape
    assert shape._type_number() == (8 if kind == 'Mesh' else number)
    ours = shape._kernel_parameters()
    if kind in ('Convex', 'Mesh'):  # the hull may order its vertices anew
        end = 1 + 3 * int(parameters[0])
        ours, parameters = (np.sort(x[1:end].reshape(-1, 3), axis=0) for x in (ours, parameters))
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
    np.testing.assert_allclose(moved.R, np.eye(3), atol=1e-15)
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
