"""Gradients against derivatives in 50 digits, for the pairs whose distance has a closed form."""

import numpy as np
import pytest
from mpmath import mp, mpf
from oracles import closed_forms
from oracles.pairs import random_pairs
from oracles.shape_scenes import MovingPair

from drake_geom_ros.math import RigidTransform

KINDS = [(1, b) for b in range(1, 7)] + [(a, 6) for a in (2, 3, 4, 5)] + [(2, 2), (2, 3), (3, 3)]
STEP = mpf(10) ** -15
# Of gradients, in units of EPS times the extent over the gap of the cores: the normal has lost
# that much, and levers are of the size of the pair.
ROUNDING = 64.0 * np.finfo(float).eps


def turned(R, w, t):
    """Return exp(t [w]) R up to the square of t, as an array of numbers of many digits."""
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    exact = np.vectorize(mpf, otypes=[object])
    R, W = exact(R), exact(W)
    return R + t * (W @ R) + t * t / 2 * (W @ W @ R)


def rate(pair, V):
    """Return the derivative of the true distance while A and B move with V (12,)."""
    values = []
    for t in (STEP, -STEP):
        p_AB_W = [mpf(float(p)) + t * mpf(float(b - a)) for p, a, b in
                  zip(pair.b.p, V[3:6], V[9:], strict=True)]  # fmt: skip
        R_WA, R_WB = turned(pair.a.R, V[:3], t), turned(pair.b.R, V[6:9], t)
        values.append(closed_forms.signed_distance(*pair.a.form, R_WA, *pair.b.form, R_WB, p_AB_W))
    return float((values[0] - values[1]) / (2 * STEP))


@pytest.mark.parametrize('kinds', KINDS, ids=str)
def test_it_is_the_derivative_to_rounding(kinds):
    rng = np.random.default_rng(10 * kinds[0] + kinds[1])
    told = 0
    with mp.workdps(closed_forms.DIGITS):
        for pair in random_pairs(rng, kinds, 12):
            moving = MovingPair(pair.a.shape, pair.b.shape, *2 * [RigidTransform()])
            moving.place(pair.a.pose, pair.b.pose)
            found = moving.ask()
            if found.is_gradient_unique[0] and abs(found.distance[0]) > 1e-4:
                told += 1
                V = rng.normal(size=12)
                off = found.gradients[0] @ V - rate(pair, V)
                assert abs(off) <= ROUNDING * pair.extent / 1e-4, pair
    assert told >= 5
