"""Solids: the public shape and the truth's shape are the same one."""

import pickle

import numpy as np
import pytest

from drake_geom_ros.evidence.accuracy.solids import Solid, outward_triangles, random_solid

KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'HalfSpace', 'Convex', 'Mesh')


@pytest.mark.parametrize('kind', KINDS)
def test_the_shape_is_that_of_the_truth(kind):
    solid = random_solid(np.random.default_rng(1), kind, 12)
    number, parameters = solid.support()
    assert solid.shape._type_number() == (8 if kind == 'Mesh' else number)
    ours = solid.shape._kernel_parameters()
    if kind in ('Convex', 'Mesh'):  # the hull may order its vertices anew
        end = 1 + 3 * int(parameters[0])
        ours, parameters = (np.sort(x[1:end].reshape(-1, 3), axis=0) for x in (ours, parameters))
    np.testing.assert_array_equal(ours, parameters)


def test_a_point_is_a_sphere_without_size_to_others():
    solid = random_solid(np.random.default_rng(1), 'Point')
    assert solid.shape.radius() == 0.0
    assert solid.reach() == 0.0


def test_triangles_look_outward():
    vertices = random_solid(np.random.default_rng(2), 'Convex', 20).vertices
    a, b, c = (vertices[outward_triangles(vertices)[:, k]] for k in range(3))
    assert (np.einsum('ij,ij->i', np.cross(b - a, c - a), a) > 0.0).all()


def test_what_is_pickled_is_made_anew():
    solid = Solid('Box', (1.0, 2.0, 3.0))
    assert solid.shape.depth() == 2.0
    assert pickle.loads(pickle.dumps(solid)).shape == solid.shape
