"""Sizes and points at the ends of their ranges, and contacts that rounding may hide."""

import math

import numpy as np
import pytest
from numba import config
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    MeshData,
    Sphere,
)
from drake_geom_ros.math.tolerances import FARTHEST

TOO_LARGE = math.nextafter(FARTHEST, math.inf)
# Where compiled code scales to infinity, Python raises OverflowError.
SUBNORMAL = () if config.DISABLE_JIT else (1e-310,)


def query(*bodies):
    """Return the query object of bodies (shape, height), each on a frame of its own."""
    shapes, heights = zip(*bodies, strict=True)
    return ShapeScene(*shapes).posed(*([0.0, 0.0, height] for height in heights)).query


@pytest.mark.parametrize(
    ('kind', 'numbers', 'name'),
    [
        (Sphere, (TOO_LARGE,), 'radius'),
        (Box, (1.0, 1.7e308, 1.0), 'depth'),
        (Capsule, (1.0, TOO_LARGE), 'length'),
        (Cylinder, (1e303, 1.0), 'radius'),
        (Ellipsoid, (1.0, 1.0, 1.7e308), 'c'),
    ],
)
def test_a_size_beyond_the_range_is_refused_with_its_value(kind, numbers, name):
    with pytest.raises(RuntimeError) as caught:
        kind(*numbers)
    value = max(numbers)
    assert str(caught.value) == f'{kind.__name__}: {name} = {value:g} must be <= 1.71e+302 [m]'
    kind(*(min(number, FARTHEST) for number in numbers))


@pytest.mark.parametrize('scale', [1e303, -1e303, 1.7e308])
def test_a_mesh_that_reaches_beyond_the_range_is_refused_with_how_far(scale):
    corners = 2.0 * np.vstack([np.zeros(3), np.eye(3)])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    shape = Convex.FromMeshData(MeshData(corners, faces), scale)
    with pytest.raises(RuntimeError, match=r'no coordinate may be beyond 1\.71e\+302 m'):
        query((shape, 0.0))


def test_a_point_beyond_the_range_is_refused_with_its_value():
    ball = query((Sphere(0.1), 0.0))
    (row,) = ball.ComputeSignedDistanceToPoint([0.0, FARTHEST, 0.0])
    assert math.isfinite(row.distance)
    for far in (TOO_LARGE, -1.7e308):
        with pytest.raises(
            RuntimeError, match=r'the coordinate -?1\.7.* m; none may be beyond 1\.71e'
        ):
            ball.ComputeSignedDistanceToPoint([[0.0, 0.0, 0.0], [0.0, far, 0.0]])


@pytest.mark.parametrize('shape', [Sphere(FARTHEST), Box(*[FARTHEST] * 3)])
def test_at_the_ends_of_the_range_answers_are_finite(shape):
    (row,) = query(
        (Sphere(0.1), FARTHEST), (shape, -FARTHEST)
    ).ComputeSignedDistancePairwiseClosestPoints()
    assert math.isfinite(row.distance)
    assert math.isfinite(row.error_bound)


@pytest.mark.parametrize('size', [1e12, 1e15, 1e18, 1e200])
@pytest.mark.parametrize('kind', ['box', 'cylinder', 'ball'])
def test_what_rounding_may_hide_of_a_large_body_counts_as_contact(kind, size):
    """The interval of the distance tells: below 0 a contact is possible, above there is none."""
    half = 0.5 * size
    shape = {'box': Box(size, size, size), 'cylinder': Cylinder(half, size), 'ball': Sphere(half)}[
        kind
    ]
    for height in (half, half + 1e-10 * size, 0.9 * half):
        asked = query((Sphere(0.1), height), (shape, 0.0))
        (row,) = asked.ComputeSignedDistancePairwiseClosestPoints()
        assert asked.HasCollisions() == (row.distance < row.error_bound)
    asked = query((Sphere(0.1), half), (shape, 0.0))
    assert asked.HasCollisions()
    # What may be is no penetration: nobody could tell its depth.
    assert len(asked.ComputePointPairPenetration()) == (size == 1e12)


def test_what_is_far_from_the_origin_may_collide_where_its_pose_is_rounded():
    far = 1e15
    asked = query((Sphere(0.1), far), (Sphere(0.1), far + 0.25))
    (row,) = asked.ComputeSignedDistancePairwiseClosestPoints()
    assert asked.HasCollisions() == (row.distance < row.error_bound)


def of_ellipsoids(v):
    """Ellipsoids with semi-axes v, or as large, and what they meet."""
    mine = Ellipsoid(1.0, 1.0, v), Ellipsoid(v, 1.0, 1.0), Ellipsoid(v, v, 2.0 * v)
    others = Capsule(0.3, 1.0), Cylinder(0.3, 1.0), Box(1.0, 1.0, 1.0), Sphere(0.2)
    others += Ellipsoid(0.3, 0.4, 0.5), Cylinder(v, 1.0), Capsule(v, 1.0), Sphere(v)
    return [(one, other) for one in mine for other in (*others, *mine)]


@pytest.mark.parametrize('number', range(33))
@pytest.mark.parametrize('v', [1e-160, 1e-170, *SUBNORMAL])
def test_no_pair_is_left_out_however_small_a_semi_axis_is(v, number):
    """A pair that overlaps is among all and answered alone, as with a semi-axis of 1e-30."""
    (A, B), (C, D) = of_ellipsoids(v)[number], of_ellipsoids(1e-30)[number]
    for p in ((0.0, 0.0, 0.0), (0.05, 0.02, 0.01)):
        scene = ShapeScene(A, B).posed((0.0, 0.0, 0.0), p)
        found = scene.query.ComputeSignedDistancePairwiseClosestPoints(10.0)
        assert len(found) == 1
        alone = scene.pair((0.0, 0.0, 0.0), p)
        numbers = *alone.nhat_BA_W, *alone.p_ACa, *alone.p_BCb, alone.distance
        assert np.isfinite(numbers).all()
        truth = ShapeScene(C, D).pair((0.0, 0.0, 0.0), p)
        assert alone.distance == pytest.approx(truth.distance, abs=1e-8)
