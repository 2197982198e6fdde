"""Solids to an accuracy that is wanted: coins hold their triangles, and bounds hold the truth."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.accuracies import ACCURACIES, at_gap, check_parts, check_rows, row_to
from oracles.solids import solid

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
)
from drake_geom_ros.geometry._proximity.kernels.solids.coarse import class_of
from drake_geom_ros.geometry._proximity.kernels.solids.coins import (
    COIN_WIDTH,
    Coin,
    put_coins,
    separation_of_coins,
)
from drake_geom_ros.geometry._proximity.kernels.solids.packing import leaf_bounds
from drake_geom_ros.geometry._proximity.tolerances import COARSE
from truth.bodies.mesh_bodies import mesh_body
from truth.bodies.random_bodies import random_directions, random_rotation
from truth.references.meshes import parts_of

EXAMPLES = 5 if config.DISABLE_JIT else 60
NAMES = ('L', 'U', 'ring')


@settings(max_examples=EXAMPLES)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 40),
    flat=st.sampled_from([1.0, 1e-3, 1e-9, 0.0]),
    size=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_coins_hold_their_triangles(seed, count, flat, size):
    rng = np.random.default_rng(seed)
    leaves = 1
    while 4 * leaves < count:
        leaves *= 2
    corners = size * rng.normal(size=(count, 3, 3)) * [1.0, 1.0, flat]
    starts = leaf_bounds(count, leaves)
    coins = np.empty((2 * leaves - 1, COIN_WIDTH))
    put_coins(coins, corners, starts)
    for k in range(2 * leaves - 1):
        first = last = k
        while first < leaves - 1:
            first, last = 2 * first + 1, 2 * last + 2
        points = corners[starts[first - leaves + 1] : starts[last - leaves + 2]].reshape(-1, 3)
        middle, n, half, radius = coins[k, :3], coins[k, 3:6], coins[k, 6], coins[k, 7]
        assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-12)
        heights = (points - middle) @ n
        assert np.abs(heights).max() <= half
        across = np.linalg.norm(points - middle - heights[:, None] * n, axis=1)
        assert across.max() <= radius


@settings(max_examples=EXAMPLES)
@given(seed=st.integers(0, 2**32 - 1), flat=st.sampled_from([1.0, 1e-2, 0.0]))
def test_no_points_of_coins_are_nearer_than_their_separation(seed, flat):
    rng = np.random.default_rng(seed)
    coins, clouds = [], []
    for _ in range(2):
        n, middle = random_directions(rng, 1)[0], rng.normal(size=3)
        half, radius = flat * rng.uniform(0.0, 1.0), rng.uniform(0.01, 1.0)
        coins.append(Coin(tuple(middle), tuple(n), half, radius))
        across = rng.normal(size=(400, 3))
        across -= (across @ n)[:, None] * n
        across *= radius / np.linalg.norm(across, axis=1)[:, None]
        clouds.append(middle + across + np.outer(rng.choice([-half, half], 400), n))
    separation = separation_of_coins(*coins)
    apart = np.linalg.norm(clouds[0][:, None] - clouds[1][None], axis=2).min()
    assert separation <= apart + 1e-12
    assert separation_of_coins(*coins[::-1]) == pytest.approx(separation, abs=1e-12)


def test_coins_that_face_each_other_are_as_far_as_they_are():
    below = Coin((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.001, 1.0)
    above = Coin((0.9, 0.0, 0.05), (0.0, 0.0, -1.0), 0.002, 1.0)
    assert separation_of_coins(below, above) == pytest.approx(0.047, abs=1e-7)
    beside = Coin((5.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.001, 1.0)
    assert separation_of_coins(below, beside) == pytest.approx(3.0, abs=1e-7)


@pytest.mark.parametrize('length', [1e-3, 0.25, 0.3, 1.0, 3.7e-9])
def test_a_class_is_the_power_of_two_below(length):
    assert class_of(length) <= length < 2.0 * class_of(length)
    assert math.log2(class_of(length)).is_integer()


@settings(max_examples=EXAMPLES)
@given(
    seed=st.integers(0, 2**32 - 1),
    names=st.tuples(st.sampled_from(NAMES), st.sampled_from(NAMES)),
    cuts=st.sampled_from([1, 4]),
    gap=st.sampled_from([None, 1e-12, 1e-7, 1e-4, 2e-3, 0.05]),
    size=st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
)
def test_bounds_hold_the_distance_of_unions_of_boxes(seed, names, cuts, gap, size):
    rng = np.random.default_rng(seed)
    a = solid(names[0], size, cuts).placed(random_rotation(rng), np.zeros(3))
    R = random_rotation(rng) if rng.random() < 0.7 else a.R
    b = solid(names[1], size, cuts).placed(R, size * rng.uniform(-4.0, 4.0, 3))
    if gap is not None:
        b = at_gap(a, b, gap * size)
    check_parts(a, b, size)
    assert len(parts_of(a)) > 1


@settings(max_examples=EXAMPLES // 3)
@given(
    seed=st.integers(0, 2**32 - 1),
    gap=st.sampled_from([None, 1e-6, 1e-3, 0.03]),
    size=st.sampled_from([1e-3, 1.0, 1e3]),
    names=st.sampled_from([('Ball', 'Ball'), ('Ball', 'L'), ('pin', 'Ball'), ('wall', 'pin')]),
)
def test_bounds_hold_the_distance_of_dents_pins_and_thin_walls(seed, gap, size, names):
    rng = np.random.default_rng(seed)
    a, b = (ADVERSE[name]().scaled(size) for name in names)
    a = a.placed(random_rotation(rng), np.zeros(3))
    direction = random_directions(rng, 1)[0]
    b = b.placed(random_rotation(rng), size * rng.uniform(0.0, 0.4) * direction)
    if gap is not None:
        b = at_gap(a, b, gap * size)
    check_rows(a, b, size)


def pair_of_balls(apart):
    """Return two balls with dents, of radius 0.1 m, as one solid of two surfaces."""
    ball = ADVERSE['Ball']()
    shifts = np.array([[-0.5 * apart, 0.0, 0.0], [0.5 * apart, 0.0, 0.0]])
    vertices = np.vstack([ball.size + shift for shift in shifts])
    triangles = np.vstack([ball.triangles, ball.triangles + len(ball.size)])
    return Body('Solid', vertices, triangles=triangles)


@settings(max_examples=EXAMPLES // 3)
@given(
    seed=st.integers(0, 2**32 - 1),
    gap=st.sampled_from([None, 1e-6, 1e-3, 0.03]),
    apart=st.sampled_from([0.4, 0.6]),
)
def test_bounds_hold_the_distance_of_several_surfaces(seed, gap, apart):
    """Some of these are between the two others, where a slab between hulls decides nothing."""
    rng = np.random.default_rng(seed)
    a = pair_of_balls(apart).placed(random_rotation(rng), np.zeros(3))
    b = ADVERSE[rng.choice(['Ball', 'L', 'pin'])]()
    b = b.placed(random_rotation(rng), rng.uniform(0.0, 0.4) * random_directions(rng, 1)[0])
    if gap is not None:
        b = at_gap(a, b, gap)
    check_rows(a, b, 1.0)


def test_a_solid_of_two_surfaces_takes_less_than_exact_where_nothing_is_between_them():
    a, b = pair_of_balls(0.5), ADVERSE['Ball']()
    beside = row_to(a, b.at(np.array([0.25, 0.0, 0.4])), 0.03)
    assert beside[ERROR_BOUND] > 1e-3
    between = b.scaled(0.3).at(np.array([0.0, 0.02, 0.0]))
    exact = row_to(a, between, 0.0)
    assert exact[DISTANCE] > 0.03
    assert (row_to(a, between, 0.03) == exact).all()
    overlapping = b.at(np.array([0.0, 0.02, 0.0]))
    assert check_rows(a, overlapping, 1.0)[DISTANCE] < 0.0


def test_a_surface_within_the_other_body_is_an_overlap_at_every_accuracy():
    """The nearest points are of another surface, which is outside: no two surfaces cross."""
    a = pair_of_balls(4.5).scaled(0.2).at(np.array([0.45, 0.0, 0.0]))
    b = mesh_body('Ball', 1300).scaled(5.0)
    for one, other in ((a, b), (b, a)):
        for accuracy in (0.0, *ACCURACIES):
            out = row_to(one, other, accuracy)
            assert out[DISTANCE] + out[ERROR_BOUND] < 0.0, accuracy


def pin():
    """Return a plate with a spike 0.1 m long and 10 um thick: its faces are needles."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    bottom = np.column_stack((0.1 * square, np.full(4, -0.01)))
    top = np.column_stack((0.1 * square, np.zeros(4)))
    foot = np.column_stack((5e-6 * square, np.zeros(4)))
    vertices = np.vstack((bottom, top, foot, [[0.0, 0.0, 0.1]]))
    triangles = [(0, 2, 1), (0, 3, 2)]
    for k in range(4):
        m = (k + 1) % 4
        triangles += [(k, m, 4 + m), (k, 4 + m, 4 + k)]
        triangles += [(4 + k, 4 + m, 8 + m), (4 + k, 8 + m, 8 + k), (8 + k, 8 + m, 12)]
    return Body('Solid', vertices, triangles=np.array(triangles))


def wall():
    """Return a U flattened to walls, and an opening between them, of 0.1 mm."""
    body = solid('U', 0.1, 2)
    return Body('Solid', np.array(body.size) * [1e-3, 1.0, 1.0], triangles=body.triangles)


ADVERSE = {
    'Ball': lambda: mesh_body('Ball', 100 if config.DISABLE_JIT else 1300),
    'L': lambda: mesh_body('L', 1300),
    'pin': pin,
    'wall': wall,
}


def test_where_nothing_is_gained_the_kernel_of_exact_answers():
    a = mesh_body('Ball', 100)
    b = mesh_body('L', 100).at(np.array([-0.15, -0.15, 0.0]))
    exact = row_to(a, b, 0.0)
    assert (row_to(a, b, 0.99 * COARSE) == exact).all()
    # The ball is in the dent of the L, whose triangles are larger than a millimetre by far.
    assert (row_to(a, b, 1e-3) == exact).all()
    assert row_to(a, b, 1e-2)[ERROR_BOUND] > 1e-3 > 1e-9 > exact[ERROR_BOUND]


def test_hulls_that_are_apart_decide_whatever_the_size_of_triangles():
    a = mesh_body('Ball', 100)
    b = mesh_body('L', 100).at(np.array([0.4, 0.1, 0.0]))
    for accuracy in (COARSE, 1e-4, 1e-3, 1e-2):
        assert 0.25 * accuracy <= row_to(a, b, accuracy)[ERROR_BOUND] <= accuracy
