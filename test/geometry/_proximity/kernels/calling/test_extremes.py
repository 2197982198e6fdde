"""Pairs far from a metre are answered at a metre, digit for digit."""

import numpy as np
import pytest

from drake_geom_ros.geometry import Box, Convex, Cylinder, Ellipsoid, Sphere
from drake_geom_ros.geometry._proximity.kernels.calling import extremes
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry.meshes.source import MeshData
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.math import RotationMatrix
from truth.bodies.random_bodies import random_directions

R = np.array(RotationMatrix.MakeXRotation(0.5).matrix())


@pytest.mark.parametrize(
    ('size', 'p', 'extreme'),
    [
        (1.0, [0, 0, 0], False),
        (0.0, [0, 1e-3, 0], False),
        (1e-60, [0, 0, 0], True),
        (1e-60, [0, 0, -1], False),
        (1.0, [1e60, 0, 0], True),
        (np.inf, [0, 0, 0], True),
    ],
)
def test_what_is_extreme(size, p, extreme):
    assert extremes.is_extreme(size, np.array(p, dtype=float)) == extreme


@pytest.mark.parametrize('exponent', [-1000, -600, 0, 300, 900])
@pytest.mark.parametrize('shape', [Box(1, 2, 3), Cylinder(0.5, 2), Ellipsoid(0.5, 1, 2)])
def test_an_answer_scales_with_its_pair(shape, exponent):
    address = calling.compiled_address(convex.signed_distance_of_cores)
    other, p = Ellipsoid(0.3, 0.2, 0.1), np.array([2.0, 0.5, 0.25])
    rows = []
    for e in (0, exponent):
        row = np.zeros(calling.PAIR_WIDTH)
        kinds, lengths = zip(*(for_queries(each).in_pairs for each in (shape, other)), strict=True)
        lengths = [np.ldexp(each, e) for each in lengths]
        A = calling.OrientedShape(kinds[0], lengths[0], np.eye(3))
        B = calling.OrientedShape(kinds[1], lengths[1], R)
        aim = calling.Aim(np.ldexp(4.0, e), np.ldexp(1e-9, e), np.inf, 0.0)
        extremes.at_one_metre(address, A, B, np.ldexp(p, e), aim, row)
        rows.append(row)
    lengths = [calling.DISTANCE, calling.ERROR_BOUND, *range(calling.WITNESS_A, 10)]
    rows[0][lengths] = np.ldexp(rows[0][lengths], exponent)
    np.testing.assert_array_equal(rows[0], rows[1])


def test_a_hull_keeps_the_number_of_its_vertices_and_its_lists():
    directions = random_directions(np.random.default_rng(0), 600)
    shape = for_queries(Convex.FromMeshData(MeshData(directions))).in_pairs.parameters
    count = int(shape[0])
    copy = extremes.resized(CONVEX, shape, 10)
    lengths = slice(1, 3 * count + 7)  # defect, ball and radius too
    np.testing.assert_array_equal(copy[lengths], 1024.0 * shape[lengths])
    np.testing.assert_array_equal(copy[3 * count + 7 :], shape[3 * count + 7 :])
    assert copy[0] == count
    assert for_queries(Sphere(1.0)).in_pairs.parameters.tolist() == [1.0]
