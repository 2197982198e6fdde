"""The sweeps against all pairs: nothing that overlaps is missed, nothing is twice."""

from fractions import Fraction

import numpy as np
import pytest
from oracles.worlds import geometry_table, random_world

from drake_geom_ros.geometry._proximity.broadphase import (
    Boxes,
    _overlap,
    box_gap,
    pairs_between,
    pairs_within,
    plane_gap,
    sorted_boxes,
    split_wide,
    widest_axis,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry._proximity.world import FrameTable, World


def overlapping(world, rows_a, rows_b, paddings):
    """Return the pairs of two sets of rows whose padded boxes overlap, the slow way."""
    pairs = set()
    for i in rows_a.tolist():
        for j in rows_b.tolist():
            reach = world.half_extents[i] + world.half_extents[j] + paddings[i] + paddings[j]
            if i != j and (np.abs(world.p_WGs[i] - world.p_WGs[j]) <= reach).all():
                pairs.add((min(i, j), max(i, j)))
    return pairs


def boxes_of(world, rows, paddings, axis=0):
    return sorted_boxes(axis, rows, world.p_WGs, world.half_extents, paddings)


def as_set(pairs):
    """Return pairs (k, 2) as a set, none of them twice, the smaller first."""
    found = {tuple(pair) for pair in pairs.tolist()}
    assert len(found) == len(pairs)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    return found


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_sweeps_find_what_overlaps(axis):
    for seed in range(10):
        rng = np.random.default_rng(seed)
        world = random_world(rng, 60)
        paddings = rng.uniform(0.0, 0.1, 60)
        some, others = np.arange(0, 60, 3), np.setdiff1d(np.arange(60), np.arange(0, 60, 3))
        a, b = boxes_of(world, some, paddings, axis), boxes_of(world, others, paddings, axis)
        assert as_set(pairs_within(a)) == overlapping(world, some, some, paddings)
        skipped = np.zeros(60, dtype=bool)
        assert as_set(pairs_between(a, b, skipped)) == overlapping(world, some, others, paddings)
        skipped[others[:10]] = True
        expected = overlapping(world, some, others[10:], paddings)
        assert as_set(pairs_between(a, b, skipped)) == expected


def test_many_overlapping_bodies_outgrow_the_first_guess_of_room():
    world = random_world(np.random.default_rng(0), 60, spread=0.01)
    rows, nothing = np.arange(60), np.zeros(60)
    found = as_set(pairs_within(boxes_of(world, rows, nothing)))
    assert len(found) > 1000
    assert found == overlapping(world, rows, rows, nothing)


def test_one_wide_body_among_others_is_set_apart():
    world = random_world(np.random.default_rng(0), 30)
    world.half_extents[7] = 50.0
    ordinary, wide = split_wide(np.arange(30), world.half_extents, 1)
    assert wide.tolist() == [7]
    assert len(ordinary) == 29
    assert [len(rows) for rows in split_wide(ordinary[:0], world.half_extents, 1)] == [0, 0]


def test_the_axis_of_the_sweep_is_the_longest():
    points = np.random.default_rng(0).normal(size=(20, 3)) * [1.0, 1.0, 30.0]
    assert widest_axis(points) == 2
    assert widest_axis(points[:0]) == 0


def test_touching_boxes_far_away_overlap():
    # 0.1 + 0.2 is not 0.3: rounding must not lose a pair that touches.
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [1, 1], [[0.1], [0.2]]))
    offset = 1e6
    ps = np.array([[offset, offset, 0.0], [offset + 0.3, offset, 0.0]])
    world.set_poses(np.array([1, 2]), np.tile(np.eye(3), (2, 1, 1)), ps)
    world.update()
    assert pairs_within(boxes_of(world, np.arange(2), np.zeros(2))).tolist() == [[0, 1]]
    assert box_gap(world.p_WGs, world.half_extents, 0, 1) == 0.0


@pytest.mark.parametrize('axis', [0, 1, 2])
@pytest.mark.parametrize('side', [-1.0, 1.0])
def test_boxes_that_share_a_face_share_a_point(axis, side):
    """Asked without the padding of ``sorted_boxes``; a gap on any one axis is enough."""
    lowers, uppers = np.zeros((2, 3)), np.ones((2, 3))
    lowers[1, axis] += side
    uppers[1, axis] += side
    assert _overlap(lowers, uppers, 0, lowers, uppers, 1)
    lowers[1, axis] += side * EPS
    uppers[1, axis] += side * EPS
    assert not _overlap(lowers, uppers, 0, lowers, uppers, 1)


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_sweeps_do_not_end_before_boxes_that_touch(axis):
    """Three cubes in a row, each touching the next, without the padding of ``sorted_boxes``."""
    lowers = np.zeros((3, 3))
    lowers[:, axis] = [0.0, 1.0, 2.0]
    row = Boxes(axis, np.array([5, 3, 4]), lowers, lowers + 1.0, 1.0)
    assert as_set(pairs_within(row)) == {(3, 5), (3, 4)}
    nobody = np.zeros(6, dtype=bool)
    for k, expected in enumerate(({(3, 5)}, {(3, 5), (3, 4)}, {(3, 4)})):
        one = Boxes(axis, row.bodies[[k]], lowers[[k]], lowers[[k]] + 1.0, 1.0)
        others = [m for m in range(3) if m != k]
        two = Boxes(axis, row.bodies[others], lowers[others], lowers[others] + 1.0, 1.0)
        assert as_set(pairs_between(one, two, nobody)) == expected
        assert as_set(pairs_between(two, one, nobody)) == expected


def test_gaps_are_lower_bounds_and_tight():
    rng = np.random.default_rng(1)
    world = random_world(rng, 40)
    for i in range(39):
        apart = np.abs(world.p_WGs[i] - world.p_WGs[i + 1])
        gap = apart - world.half_extents[i] - world.half_extents[i + 1]
        expected = np.linalg.norm(np.maximum(gap, 0.0))
        found = box_gap(world.p_WGs, world.half_extents, i, i + 1)
        assert expected - 1e-14 <= found <= expected


def test_the_gap_above_a_plane():
    # A floor at z = 1, and a box whose lowest point is at z = 1.4.
    frames = FrameTable(np.arange(1, 3), np.zeros(2, dtype=np.int64))
    p_FGs = np.array([[5.0, 5.0, 1.0], [0.0, 0.0, 0.0]])
    table = geometry_table([0, 1], [6, 2], [[], [0.3, 0.2, 0.1]], None, p_FGs)
    world = World(frames, table)
    world.set_poses(np.array([1]), np.eye(3)[None], np.array([[0.0, 0.0, 1.5]]))
    world.update()
    posed = world.R_WGs, world.p_WGs, world.roundings
    gap = plane_gap(*posed, world.half_extents, 0, 1)
    assert 0.4 - 1e-13 <= gap <= 0.4


@pytest.mark.parametrize('size', [1e-3, 1.0, 1e6])
def test_no_box_is_smaller_than_it_is_without_rounding(size):
    rng = np.random.default_rng(4)
    p, half, paddings = size * rng.normal(size=(20, 3)), rng.uniform(0, 1, (20, 3)), np.ones(20)
    boxes = sorted_boxes(0, np.arange(20), p, half, paddings)
    for k, g in enumerate(boxes.bodies):
        for c in range(3):
            middle, reach = Fraction(p[g, c]), Fraction(half[g, c]) + 1
            lower, upper = Fraction(boxes.lowers[k, c]), Fraction(boxes.uppers[k, c])
            assert lower < middle - reach
            assert upper > middle + reach
            assert upper - lower <= 2 * reach + 32 * Fraction(EPS) * (abs(middle) + reach)
