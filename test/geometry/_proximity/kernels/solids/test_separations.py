"""The least translation that parts boxes: by all places of a lattice, and by random directions."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.solids.separations import (
    directions_of,
    least_parting,
    longest_foot,
    widths_of,
)
from truth.bodies.random_bodies import random_rotation

CASES = 40
NOISE = 1e-13


def random_boxes(rng, count):
    low = rng.integers(0, 4, (count, 3)).astype(float)
    return np.hstack((low, low + rng.integers(1, 3, (count, 3))))


def least_on_axes(mine, its, p):
    """The least of all places where a box ends at another: there the least translation ends."""
    low = (its[None, :, :3] - mine[:, None, 3:]).reshape(-1, 3)
    high = (its[None, :, 3:] - mine[:, None, :3]).reshape(-1, 3)
    lines = [np.unique(np.concatenate((low[:, k], high[:, k], [p[k]]))) for k in range(3)]
    places = np.stack(np.meshgrid(*lines, indexing='ij'), -1).reshape(-1, 3)
    inside = ((low < places[:, None]) & (places[:, None] < high)).all(axis=2).any(axis=1)
    return float(np.linalg.norm(places[~inside] - p, axis=1).min())


def test_boxes_along_the_same_axes():
    rng, moved = np.random.default_rng(1), 0
    for _ in range(CASES):
        mine, its = random_boxes(rng, rng.integers(1, 6)), random_boxes(rng, rng.integers(1, 6))
        p = rng.integers(-8, 9, 3) / 4.0
        truth = least_on_axes(mine, its, p)
        found = least_parting((mine, its), np.eye(3), tuple(p), (20.0, 0.0), NOISE)
        assert found.separates
        assert found.lower == pytest.approx(truth, abs=1e-11)
        assert np.linalg.norm(found.t) == pytest.approx(truth, abs=1e-11)
        assert least_on_axes(mine, its, p + found.t) < 1e-11
        moved += truth > 0.0
    assert moved > CASES // 4


def test_turned_boxes():
    """What is found parts them, and nothing shorter does in thousands of directions."""
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        mine, its = random_boxes(rng, rng.integers(1, 4)), random_boxes(rng, rng.integers(1, 4))
        R, p = random_rotation(rng), rng.uniform(-1.0, 1.0, 3)
        found = least_parting((mine, its), R, tuple(p), (20.0, 0.0), NOISE)
        ways, slack = directions_of(R)
        width = widths_of((mine, its), R, tuple(p), ways, slack, (1e9, 0.0))
        depth = (width[:, :, None] - (ways @ np.array(found.t))[None, :, None]).min(axis=1).max()
        assert found.separates
        assert depth <= 1e-9
        if found.lower < 1e-6:
            continue
        units = rng.normal(size=(4000, 3))
        units /= np.linalg.norm(units, axis=1, keepdims=True)
        for t in 0.99 * found.lower * units:
            assert (width - ways @ t).min(axis=1).max() > 0.0


def test_a_bound_that_nothing_reaches_is_no_more_than_the_one_that_is_known():
    box = np.array([[0.0, 0.0, 0.0, 4.0, 4.0, 4.0]])
    found = least_parting((box, box), np.eye(3), (0.0, 0.0, 0.0), (1.5, 0.0), NOISE)
    assert 1.5 - 1e-12 <= found.lower <= 1.5
    assert not found.separates
    nothing = least_parting((np.empty((0, 6)), box), np.eye(3), (0.0, 0.0, 0.0), (1.5, 0.0), NOISE)
    assert nothing.lower == 0.0
    assert not nothing.separates


def test_axes_that_are_parallel_but_for_a_hair_leave_a_margin():
    turn = 1e-8
    R = np.array([[1.0, -turn, 0.0], [turn, 1.0, 0.0], [0.0, 0.0, 1.0]])
    ways, slack = directions_of(R)
    assert slack > 0.0
    assert len(ways) >= 12
    boxes = np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]])
    found = least_parting((boxes, boxes), R, (0.25, 0.0, 0.0), (5.0, 0.0), NOISE)
    assert 0.75 - 1e-4 <= found.lower <= 0.75 + 1e-7


def test_the_foot_of_bounds_is_the_shortest_within_them():
    ways = np.vstack((np.eye(3), np.array([[1.0, 1.0, 0.0]]) / np.sqrt(2.0)))
    none = -np.inf
    for bounds, expected in (
        ([1.0, none, none, none], (1, 0, 0)),
        ([1.0, 2.0, none, none], (1, 2, 0)),
        ([1.0, 2.0, -3.0, none], (1, 2, 0)),
        ([0.0, 0.0, 0.0, np.sqrt(2.0)], (1, 1, 0)),
        ([1.5, 0.0, 0.0, np.sqrt(2.0)], (1.5, 0.5, 0)),
        ([-1.0, none, none, none], (0, 0, 0)),
    ):
        assert longest_foot(ways, np.array(bounds)) == pytest.approx(expected, abs=1e-12)
