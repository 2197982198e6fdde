"""Closed forms of contact surfaces are those of sums over many small parts."""

import numpy as np
import pytest

from truth.surfaces.closed_forms import DEPTH, MODULUS, RADIUS, SIZE, ball_in_ball, box_on_plane


def test_the_truth_of_two_balls_is_that_of_many_small_faces():
    R, apart = RADIUS, 2.0 * RADIUS - DEPTH
    angles = np.linspace(0.0, np.arccos(apart / (2.0 * R)), 200_001)
    middles = 0.5 * (angles[1:] + angles[:-1])
    areas = 2.0 * np.pi * R**2 * -np.diff(np.cos(angles))
    away = np.hypot(R * np.sin(middles), apart - R * np.cos(middles))
    pressed = areas * MODULUS * (1.0 - away / R)
    truth, cosines = ball_in_ball(), np.cos(middles)
    assert truth.area == pytest.approx(areas.sum(), rel=1e-9)
    assert truth.force == pytest.approx((pressed * cosines).sum(), rel=1e-8)
    assert truth.height == pytest.approx(R * (pressed * cosines).sum() / pressed.sum(), rel=1e-8)


def test_the_truth_of_a_box_is_that_of_many_points():
    xs, ys = (np.linspace(0.0, size, 2001)[1:] - size / 4000.0 for size in SIZE[:2])
    rim = np.minimum(np.minimum(xs, SIZE[0] - xs)[:, None], np.minimum(ys, SIZE[1] - ys)[None])
    volume = np.minimum(rim, DEPTH).mean() * SIZE[0] * SIZE[1]
    assert box_on_plane().force == pytest.approx(MODULUS * volume / (0.5 * SIZE[2]), rel=1e-5)
