"""Interpolated poses against fifty digits: within what is taken off for their rounding."""

import math

import mpmath
import numpy as np
import pytest
from batch.floating_bodies import Floating

from drake_geom_ros.geometry import Sphere
from drake_geom_ros.geometry._proximity.motion.arrays import SCREW, SLERP
from drake_geom_ros.geometry._proximity.motion.interpolants import put_state
from drake_geom_ros.geometry._proximity.motion.motion_loops import MotionLoops
from drake_geom_ros.geometry._proximity.motion.rates import prepare
from drake_geom_ros.geometry._proximity.tolerances import (
    INTERPOLATED_POSITION,
    INTERPOLATED_ROTATION,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.batched import matrices_from_poses

mpmath.mp.dps = 50


@pytest.fixture(scope='module')
def loops():
    bodies = Floating([Sphere(0.1), Sphere(0.1)])
    ids = np.array([frame.get_value() for frame in bodies.ids])
    scene, _ = PackedScene.of(bodies.graph.CreateDefaultContext(), ids, about_points=False)
    world, none = scene.world(), np.zeros(2)
    stop = np.zeros(1, dtype=np.int64)
    return world, MotionLoops(world, scene.pairs, scene.moved, none, math.inf, stop)


def orthogonal(R):
    """Return the rotation nearest to a matrix, to fifty digits, by Newton's iteration."""
    M = mpmath.matrix(R.tolist())
    for _ in range(8):
        M = (M + mpmath.inverse(M).T) / 2
    return M


def turn_of(M):
    """Return axis and angle of a rotation that is no half turn."""
    v = [M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]]
    length = mpmath.sqrt(sum(x * x for x in v))
    angle = mpmath.atan2(length, M[0, 0] + M[1, 1] + M[2, 2] - 1)
    return [x / length for x in v], angle


def skew(a):
    return mpmath.matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rotation(axis, angle):
    K = skew(axis)
    return mpmath.eye(3) + mpmath.sin(angle) * K + (1 - mpmath.cos(angle)) * (K * K)


def exact(R0, p0, R1, p1, kind, t):
    """Return R and p at a time, of rotations and positions in fifty digits."""
    axis, angle = turn_of(R0.T * R1)
    R = R0 * rotation(axis, t * angle)
    if kind == SLERP:
        return R, p0 + t * (p1 - p0)

    def moved(x):
        """Return the integral of rotations from 0 to an angle, over the angle."""
        K = skew(axis)
        first, second = (1 - mpmath.cos(x)) / angle, (x - mpmath.sin(x)) / angle
        return mpmath.eye(3) * (x / angle) + first * K + second * (K * K)

    u = mpmath.lu_solve(moved(angle), R0.T * (p1 - p0))
    return R, p0 + R0 * (moved(t * angle) * u)


@pytest.mark.parametrize('kind', [SLERP, SCREW])
@pytest.mark.parametrize('size', [1e-9, 1e-4, 0.3, 3.0])
def test_poses_are_as_near_to_the_exact_ones_as_is_taken_off(loops, kind, size):
    world, motion = loops
    rng, arrays = np.random.default_rng(7), motion._arrays
    for _ in range(6):
        axis = rng.normal(size=3)
        half = 0.5 * size * rng.uniform(0.5, 1.0)
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        turn = np.array([*(math.sin(half) * axis / np.linalg.norm(axis)), math.cos(half)])
        start = [*rng.uniform(-9, 9, 3), *q]
        end = [*rng.uniform(-9, 9, 3), *turn]
        Rs, ps = matrices_from_poses([start, [0, 0, 0, *turn], end])
        ends = np.array([Rs[0] @ Rs[1], np.eye(3)])
        row = np.hstack((Rs[:1].reshape(1, 9), ps[:1]))
        arrays.starts[:] = row
        arrays.ends[:] = np.hstack((ends[:1].reshape(1, 9), ps[2:]))
        arrays.flags[0] = kind
        prepare(motion._handle)
        R0, R1 = orthogonal(Rs[0]), orthogonal(ends[0])
        p0, p1 = mpmath.matrix(ps[0].tolist()), mpmath.matrix(ps[2].tolist())
        lengths = (
            np.linalg.norm(ps[0]) + np.linalg.norm(ps[2]) + np.linalg.norm(arrays.moves[0, 4:])
        )
        for t in (0.25, 0.5, 0.8125):
            assert put_state(motion._handle, t)
            R, p = exact(R0, p0, R1, p1, kind, mpmath.mpf(t))
            off = mpmath.matrix(world.R_WFs[1].tolist()) - R
            assert mpmath.norm(list(off)) <= INTERPOLATED_ROTATION
            away = mpmath.matrix(world.p_WFs[1].tolist()) - p
            assert mpmath.norm(away) <= INTERPOLATED_POSITION * lengths


def test_a_half_turn_goes_about_the_axis_that_is_told(loops):
    _, motion = loops
    arrays = motion._arrays
    arrays.starts[:] = arrays.ends[:] = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]
    for numbers in ([-1, 0, 0, 0, -1, 0, 0, 0, 1], [0, 1, 0, 1, 0, 0, 0, 0, -1]):
        arrays.ends[0, :9] = numbers
        arrays.flags[0] = SLERP
        prepare(motion._handle)
        assert put_state(motion._handle, 0.5)
        axis = arrays.moves[0, :3]
        assert axis[np.flatnonzero(np.abs(axis) > 1e-12)[0]] > 0.0
        assert abs(arrays.moves[0, 3] - math.pi) < 1e-15
