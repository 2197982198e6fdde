"""The hashed grids against all pairs: what overlaps is found, and nothing else."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry._proximity.near.grid_pairs import (
    _overlap,
    pairs_between,
    pairs_within,
)
from drake_geom_ros.geometry._proximity.near.grids import (
    BODIES,
    GRIDS,
    Boxes,
    put_in,
    room_for,
    rows_of,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS

NOBODY = np.zeros(0, dtype=np.bool_)


def filled(rows, p, half, paddings=None):
    """Return the boxes of some rows."""
    boxes, rows = room_for(len(p)), np.asarray(rows, dtype=np.int64)
    put_in(boxes, rows, p, half, np.zeros(len(p)) if paddings is None else paddings)
    return boxes


def found(search):
    """Return the pairs that a search appends, the smaller first, and how many are there twice."""
    count = search(np.zeros(1, dtype=np.int64))
    codes = np.full(count + 1, -1)  # the last place is none
    assert search(codes) == count
    pairs = {rows_of(code) for code in codes[:count].tolist()}
    assert all(i < j for i, j in pairs)
    return pairs, count - len(pairs)


def within(boxes):
    return found(lambda codes: pairs_within(boxes, NOBODY, codes, 0))


def between(some, others, skipped=NOBODY):
    return found(lambda codes: pairs_between(some, others, skipped, codes, 0))


def overlapping(rows_a, rows_b, p, half, slack=0.0):
    """Return the pairs of rows whose boxes overlap, the slow way, with a slack [-] of rounding."""
    pairs = set()
    for i in rows_a:
        for j in rows_b:
            reach = half[i] + half[j]
            noise = slack * EPS * (np.abs(p[i]) + np.abs(p[j]) + reach)
            if i != j and (np.abs(p[i] - p[j]) <= reach + noise).all():
                pairs.add((min(i, j), max(i, j)))
    return pairs


def is_all_that_overlaps(pairs, *bodies):
    return overlapping(*bodies) <= pairs <= overlapping(*bodies, slack=16.0)


scenes = st.tuples(
    st.integers(0, 2**32 - 1),
    st.integers(0, 60),
    st.sampled_from([0.0, 1.0, 4.0, 12.0]),  # decades of sizes
    st.sampled_from([1e-6, 0.3, 3.0, 1e5]),  # spread in mean widths
    st.sampled_from([0.0, 1.0, 1e9]),  # offset in mean widths
    st.sampled_from([1e-12, 1.0, 1e12]),  # scale [m]
)


@given(scenes)
@settings(max_examples=150)
def test_all_that_overlaps_is_found_whatever_the_sizes(scene):
    seed, count, decades, spread, offset, scale = scene
    rng = np.random.default_rng(seed)
    half = scale * 10.0 ** rng.uniform(-decades, 0.0, (count, 1)) * rng.uniform(0.1, 1, (count, 3))
    p = scale * (offset + spread * rng.normal(size=(count, 3)))
    rows = range(count)
    some, others = [*rows][::3], [k for k in rows if k % 3]
    pairs, _ = within(filled(some, p, half))
    assert is_all_that_overlaps(pairs, some, some, p, half)
    for a, b in ((some, others), (others, some)):
        pairs, _ = between(filled(a, p, half), filled(b, p, half))
        assert is_all_that_overlaps(pairs, a, b, p, half)


@pytest.mark.parametrize('touching', [True, False])
@pytest.mark.parametrize('place', [-3.0, -0.25, 0.0, 0.5, 1024.0])
def test_neighbours_along_every_direction_are_found(touching, place):
    """27 cubes in a block, on and off the borders of cells; each touches all of its neighbours."""
    side = np.array(list(np.ndindex(3, 3, 3)), dtype=float)
    half = np.full((27, 3), 0.5 if touching else 0.4375)
    pairs, _ = within(filled(range(27), side + place, half))
    assert pairs == overlapping(range(27), range(27), side, half)
    assert bool(pairs) == touching


@pytest.mark.parametrize('padding', [1e290, 1e300, 8.5e307])
def test_padded_by_any_number_all_are_found(padding):
    rng = np.random.default_rng(5)
    p, half, paddings = rng.normal(size=(9, 3)), np.ones((9, 3)), np.full(9, padding)
    some, others = filled(range(4), p, half, paddings), filled(range(4, 9), p, half, paddings)
    assert len(within(some)[0]) == 6
    assert len(between(some, others)[0]) == 20


def test_who_is_skipped_is_not_found():
    rng = np.random.default_rng(2)
    p, half = rng.uniform(-1, 1, (40, 3)), np.full((40, 3), 0.3)
    skipped = np.arange(40) >= 30
    pairs, _ = between(filled(range(20), p, half), filled(range(20, 40), p, half), skipped)
    assert pairs == overlapping(range(20), range(20, 30), p, half)


def test_a_body_that_is_in_both_is_no_pair():
    p, half = np.zeros((2, 3)), np.ones((2, 3))
    both = filled([0, 1], p, half)
    assert between(both, both) == ({(0, 1)}, 1)


def test_beyond_the_room_pairs_are_counted_only():
    p, half = np.zeros((30, 3)), np.ones((30, 3))
    codes = np.full(10, -1)
    assert pairs_within(filled(range(30), p, half), NOBODY, codes, 0) == 435
    assert (codes >= 0).all()
    assert len(set(codes[:-1].tolist())) == 9


@pytest.mark.parametrize('far', [0.0, 1e3, 1e7])
def test_cells_stand_in_order_where_all_of_the_room_fits(far):
    """A body that is far away does without that, and costs no pair."""
    rng = np.random.default_rng(7)
    p, half = rng.uniform(-1.5, 1.5, (60, 3)), np.full((60, 3), 0.4)
    p[9, 1] += far
    boxes = filled(range(60), p, half)
    _, _, mask, step_y, step_z = boxes.counts
    cells = np.floor(p / boxes.width[0]).astype(int)
    extent = cells.max(axis=0) - cells.min(axis=0) + 2
    in_order = [extent[0], extent[0] * extent[1]]
    assert ([step_y, step_z] == in_order) == (far == 0.0)
    assert (extent.prod() <= mask + 1) == (far == 0.0)
    pairs, twice = within(boxes)
    assert pairs == overlapping(range(60), range(60), p, half)
    assert far > 0.0 or not twice


def test_boxes_are_used_again_and_forget():
    rng = np.random.default_rng(3)
    boxes = room_for(50)
    for count in (50, 3, 0, 20):
        p, half = rng.uniform(-1, 1, (50, 3)), rng.uniform(0.01, 0.3, (50, 3))
        put_in(boxes, np.arange(count), p, half, np.zeros(50))
        assert Boxes(*boxes).counts[BODIES] == count
        assert within(boxes)[0] == overlapping(range(count), range(count), p, half)


def test_ordinary_sizes_share_a_grid_and_a_floor_has_its_own():
    p, half = np.zeros((40, 3)), np.full((40, 3), 0.1)
    half[::2] *= 2.0
    half[7] = 50.0
    boxes = Boxes(*filled(range(40), p, half))
    assert boxes.counts[GRIDS] == 2
    assert boxes.width[0] < 0.5


@pytest.mark.parametrize('axis', [0, 1, 2])
@pytest.mark.parametrize('side', [-1.0, 1.0])
def test_boxes_that_share_a_face_share_a_point(axis, side):
    """Asked without the padding of ``put_in``; a gap on any one axis is enough."""
    bounds = np.repeat([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]], 2, axis=0)
    bounds[1, [axis, 3 + axis]] += side
    assert _overlap(bounds, 0, bounds, 1)
    bounds[1, [axis, 3 + axis]] += side * EPS
    assert not _overlap(bounds, 0, bounds, 1)


@pytest.mark.parametrize('size', [1e-3, 1.0, 1e6])
def test_no_box_is_smaller_than_it_is_without_rounding(size):
    rng = np.random.default_rng(4)
    p, half, paddings = size * rng.normal(size=(20, 3)), rng.uniform(0, 1, (20, 3)), np.ones(20)
    boxes = Boxes(*filled(range(20), p, half, paddings))
    assert sorted(boxes.rows.tolist()) == [*range(20)]
    for k, g in enumerate(boxes.rows):
        for c in range(3):
            middle, reach = Fraction(p[g, c]), Fraction(half[g, c]) + 1
            lower, upper = Fraction(boxes.bounds[k, c]), Fraction(boxes.bounds[k, 3 + c])
            assert lower < middle - reach
            assert upper > middle + reach
            assert upper - lower <= 2 * reach + 32 * Fraction(EPS) * (abs(middle) + reach)
