"""Nearly equal cylinders, tilted by some 1e-5: the slowest and loosest of convex pairs once.

Where the ways out along the axis and across it are equally long they are the loosest still.
"""

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw

SEEDS = range(12)
TIGHT = 2e-10  # of the size; ``exact`` aims at 1e-10
LOOSE = 1e-5  # of the radius, where ways out are equally long: docs/what_it_vouches_for.md


def answer(first, second, X_AB):
    graph = SceneGraph()
    source = graph.RegisterSource('two')
    poses = {}
    for shape, X_WF in ((first, RigidTransform()), (second, X_AB)):
        frame = graph.RegisterFrame(source, GeometryFrame(f'{len(poses)}'))
        body = GeometryInstance(RigidTransform(), shape, 'body')
        body.set_proximity_properties(ProximityProperties())
        graph.RegisterGeometry(source, frame, body)
        poses[frame] = X_WF
    context = graph.CreateDefaultContext()
    context.UpdateFramePoses(FramePoseVector(poses))
    query = graph.get_query_output_port().Eval(context)
    (found,) = query.ComputeSignedDistancePairwiseClosestPoints()
    return found


def height(shape, R, p, n):
    """Return how far a cylinder reaches along n (3,)."""
    along = R.T @ n
    disc = shape.radius() * np.hypot(along[0], along[1])
    return p @ n + disc + shape.length() / 2 * abs(along[2])


@pytest.mark.parametrize('seed', SEEDS)
def test_bounds_are_tight_at_any_place(seed):
    rng = np.random.default_rng(seed)
    radius, length = 10 ** rng.uniform(-1, 1, 2)
    nearly = 10 ** rng.uniform(-9, -3)
    size = max(radius, length)
    places = (
        np.zeros(3),
        1e-6 * size * rng.normal(size=3),
        np.array([0.0, 0.0, length * rng.choice([0.999, 1.0, 1.001])]),
        np.array([2 * radius * rng.choice([0.999, 1.0, 1.001]), 0.0, 0.0]),
    )
    first, second = (
        Cylinder(radius, length),
        Cylinder(radius * (1 + nearly), length * (1 - nearly)),
    )
    for place in places:
        roll, pitch = 1e-5 * rng.normal(size=2)
        tilted = RollPitchYaw(roll, pitch, rng.uniform(-3, 3)).ToRotationMatrix()
        found = answer(first, second, RigidTransform(tilted, place))
        assert found.error_bound <= TIGHT * size
        # The gap between the planes that support them along the normal proves it.
        n = found.nhat_BA_W
        gap = -height(first, np.eye(3), np.zeros(3), -n) - height(
            second, tilted.matrix(), place, n
        )
        # Overlapping bodies are that deep at most; those apart are that far at least.
        slack = 1e-14 * size
        if found.distance < 0.0:
            assert found.distance >= gap - found.error_bound - slack
        else:
            assert gap >= found.distance - found.error_bound - slack


def widths(first, second, R, p):
    """Yield how far ``second`` is to be moved to be out, along the axes and ways across them."""
    turns = np.linspace(0.0, 2.0 * np.pi, 720)
    across = np.stack((np.cos(turns), np.sin(turns), np.zeros_like(turns)), -1)
    up = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    for ways in (up, across):
        for n in (*ways, *(ways @ R.T)):
            yield height(first, np.eye(3), np.zeros(3), n) + height(second, R, p, -n)


def as_deep_along_as_across(rng, radius, tilt, more):
    """Return (first, second, R): cylinders whose ways out differ by ``more`` [m]; R is tilted."""
    other = radius * (1.0 + 10 ** rng.uniform(-7, -3))
    turn = rng.uniform(0.0, 2.0 * np.pi)
    tilted = RollPitchYaw(tilt * np.cos(turn), tilt * np.sin(turn), rng.uniform(-3, 3))
    first, second = Cylinder(radius, 2.0 * radius), Cylinder(other, 2.0 * (other + more))
    return first, second, tilted.ToRotationMatrix()


def test_ways_out_that_are_equally_long_widen_the_bound_as_documented():
    rng, shares = np.random.default_rng(5), []
    for tilt in (1e-7, 1e-6, 1e-5):
        for share in (-1.0, -0.3, 0.0, 0.3, 1.0):
            radius = 10 ** rng.uniform(-1, 1)
            first, second, R = as_deep_along_as_across(rng, radius, tilt, share * tilt * radius)
            found = answer(first, second, RigidTransform(R, np.zeros(3)))
            # Each of these is a way out, so none is shorter than the least that the depth may be.
            shortest = min(widths(first, second, R.matrix(), np.zeros(3)))
            assert -found.distance - found.error_bound <= shortest
            shares.append(found.error_bound / radius)
    assert max(shares) <= LOOSE
    assert max(shares) > TIGHT  # else it is mended, and the page has a row too many


def least_overlap(first, second, tilt):
    """Return how deep two cylinders about one point are in each other, the second tilted [m].

    The least over all directions of how far both reach is across both axes, or in their plane,
    between the axes (the sum of two concave functions is least at an end).
    """
    across = first.radius() + second.radius()
    along = [
        height(first, np.eye(3), np.zeros(3), n) + height(second, turned(tilt), np.zeros(3), n)
        for n in (np.array([0.0, 0.0, 1.0]), turned(tilt)[:, 2])
    ]
    return min(across, *along)


def turned(tilt):
    return RollPitchYaw(tilt, 0.0, 0.0).ToRotationMatrix().matrix()


@pytest.mark.parametrize('seed', SEEDS)
def test_as_long_as_wide_the_truth_is_within_the_wide_bound(seed):
    rng = np.random.default_rng(seed)
    size = 10 ** rng.uniform(-1, 1)
    nearly, tilt = rng.uniform(0.0, 5e-6), rng.uniform(1e-6, 2e-5)
    first = Cylinder(0.5 * size, size)
    second = Cylinder(0.5 * size * (1 + nearly), size * (1 - nearly))
    found = answer(first, second, RigidTransform(RollPitchYaw(tilt, 0.0, 0.0), np.zeros(3)))
    known = least_overlap(first, second, tilt)
    assert abs(-found.distance - known) <= found.error_bound + 1e-14 * size
    assert found.error_bound <= LOOSE * first.radius()
