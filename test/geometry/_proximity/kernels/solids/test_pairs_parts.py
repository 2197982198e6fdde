"""What the kernel of solids begins with, and whether its answer is the only one."""

import numpy as np
import pytest
from oracles.forms import HERE, body, row_of
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.solids import pairs
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from truth.bodies.random_bodies import random_rotation


def test_the_first_direction_is_a_hint_of_any_length_else_towards_the_other():
    R, out = random_rotation(np.random.default_rng(2)), np.zeros(13)
    assert pairs.first_direction(out, R, (0.0, 0.0, 0.0)) == (1.0, 0.0, 0.0)
    assert pairs.first_direction(out, R, (0.0, -2.0, 0.0)) == (0.0, 1.0, 0.0)
    out[NORMAL : NORMAL + 3] = -1e-9 * R[:, 2]
    found = pairs.first_direction(out, R, (0.0, -2.0, 0.0))
    assert found == pytest.approx((0.0, 0.0, 1.0), abs=1e-15)


@pytest.mark.parametrize(
    ('p', 'm', 'depth', 'unique'),
    [
        ((0.5, 0.25, 0.5), (0.0, -1.0, 0.0), 0.25, True),
        ((1.5, 0.9375, 0.5), (0.0, 1.0, 0.0), 0.0625, True),
        ((0.25, 0.25, 0.5), None, 0.25, False),  # two walls as near
    ],
)
def test_a_ball_in_a_solid_leaves_through_its_nearest_wall(p, m, depth, unique):
    R = random_rotation(np.random.default_rng(4))
    ball = body((SPHERE, [0.03125]), p=R @ p)
    out = row_of(ball, solid('L').placed(R, HERE))
    assert out[DISTANCE] == pytest.approx(-(depth + 0.03125), abs=1e-12)
    assert out[ERROR_BOUND] <= 1e-9
    assert out[UNIQUE] == unique
    if m is not None:
        assert out[NORMAL : NORMAL + 3] == pytest.approx(R @ m, abs=1e-9)


SIZES = {SPHERE: [0.3], BOX: [0.2, 0.1, 0.3], CAPSULE: [0.1, 0.3], CYLINDER: [0.2, 0.1]}
SIZES |= {ELLIPSOID: [0.1, 0.3, 0.2], None: None}


@pytest.mark.parametrize(
    'p', [(1.2, 0.9, 0.4), (0.3, 1.7, 0.6), (1.5, 1.45, 0.5), (1.4, 2.0, 1.1)]
)
@pytest.mark.parametrize('kind', SIZES)
def test_a_pair_scaled_by_a_power_of_two_has_the_same_digits(kind, p):
    """Deep, by a wall, in the notch, over it: whatever is compared with a length grows with it."""
    R, rows = random_rotation(np.random.default_rng(7)), []
    for scale in (1.0, 2.0**-22, 2.0**14):
        A = solid('U', 0.25)
        if kind is not None:
            A = body((kind, SIZES[kind]))
        A, B = A.placed(R, p).scaled(scale), solid('L').scaled(scale)
        out = row_of(A, B, scale * 1e-9)
        out[[DISTANCE, ERROR_BOUND, *range(WITNESS_A, WITNESS_B + 3)]] /= scale
        rows.append(out)
    np.testing.assert_array_equal(rows[0], rows[1])
    np.testing.assert_array_equal(rows[0], rows[2])
