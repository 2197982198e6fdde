"""The closed forms of stops are the integrals of their speeds, in 30 digits."""

import mpmath
import numpy as np
import pytest

from truth.references.braking import base_poses, progress


@pytest.mark.parametrize('seed', range(8))
def test_progress_is_the_integral_of_the_speed(seed):
    share, reaction, braking = np.random.default_rng(seed).uniform(0.05, 1.0, 3)
    times = np.linspace(0.0, reaction + braking, 7)
    with mpmath.workdps(30):
        r, T = mpmath.mpf(reaction), mpmath.mpf(braking)

        def speed(t):
            return share if t <= r else share * (1 - (t - r) / T)

        parts = [[0, *([r] if r < t else []), mpmath.mpf(t)] for t in times]
        integrals = [float(mpmath.quad(speed, part)) for part in parts]
    np.testing.assert_allclose(
        progress(times, share, reaction, braking), integrals, rtol=0, atol=1e-14
    )


@pytest.mark.parametrize('theta', [0.0, 1e-7, -0.3, 2.0])
def test_a_base_follows_the_exponential_of_its_twist(theta):
    twist, seconds = (0.7, -0.2, theta), np.array([0.0, 0.4, 1.5])
    with mpmath.workdps(30):
        rate = mpmath.matrix([[0, -theta, twist[0]], [theta, 0, twist[1]], [0, 0, 0]])
        ends = [mpmath.expm(rate * mpmath.mpf(t)) for t in seconds]
    each = base_poses(np.eye(4), twist, seconds)
    for X, end in zip(each, ends, strict=True):
        rows = np.array([[float(end[i, j]) for j in range(3)] for i in range(3)])
        np.testing.assert_allclose(X[np.ix_([0, 1, 3], [0, 1, 3])], rows, rtol=0, atol=1e-14)
