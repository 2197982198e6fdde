"""Whatever two hulls remember, the answer is the certified one of hulls that remember nothing."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.core_pairs import core_pair, turned
from oracles.forms import signed_distance
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.geometry import Convex, MeshData
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    MEMORY_WIDTH,
    NORMAL,
    PAIR_WIDTH,
    SLOT_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kernels.cores import (
    ball_caps,
    memory,
    remembered,
    small_polytope,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import Overlap
from drake_geom_ros.geometry._proximity.kernels.cores.starts import separation_along
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import hull_parameters
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import bounding_radius
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from truth.bodies.random_bodies import random_directions, random_rotation

COUNT = 3 if config.DISABLE_JIT else 60
X = (1.0, 0.0, 0.0)


def _hull(rng, count=24):
    vertices = random_directions(rng, count) * rng.uniform(0.08, 0.15, 3)
    return hull_parameters(*Convex.FromMeshData(MeshData(vertices)).hull_surface())


def _overlapping(rng):
    """Return a pair of hulls with a depth of some centimetres."""
    shapes = _hull(rng), _hull(rng, int(rng.integers(8, 60)))
    p = random_directions(rng, 1)[0] * rng.uniform(0.02, 0.14)
    return core_pair(
        CONVEX, shapes[0], random_rotation(rng), CONVEX, shapes[1], random_rotation(rng), p
    )


def _moved(rng, pair, step):
    """Return the pair with B moved by about ``step`` [m] and as many tenths of a radian."""
    R = turned(rng.normal(size=3), 10.0 * step * rng.normal()) @ pair.R_WB
    p = np.array(pair.p_AB) + step * rng.normal(size=3)
    return core_pair(*pair[:5], R, p)


def _answer(pair, row):
    """Have the kernel answer in a row, which holds what is known of last time; return the row."""
    call_for_pair(convex.signed_distance_of_cores, *pair, 1e-9, math.inf, row)
    assert np.isfinite(row[:PAIR_WIDTH]).all()
    return row


def _wide():
    return np.zeros(SLOT_WIDTH + MEMORY_WIDTH)


def _size(pair):
    radii = [bounding_radius(*pair[k : k + 2]) for k in (0, 3)]
    return sum(radii) + float(np.linalg.norm(pair.p_AB))


def _assert_same(row, alone):
    """Both are certified, so they are as near as their bounds; the normal is the same too."""
    bound = row[ERROR_BOUND] + alone[ERROR_BOUND]
    assert row[ERROR_BOUND] <= 1e-14
    assert row[DISTANCE] == pytest.approx(alone[DISTANCE], abs=bound)
    span = row[DISTANCE] * row[NORMAL : NORMAL + 3]
    apart = row[WITNESS_A : WITNESS_A + 3] - row[WITNESS_B : WITNESS_B + 3]
    np.testing.assert_allclose(apart, span, rtol=0, atol=bound)


@pytest.mark.parametrize('step', [0.0, 1e-4, 1e-3, 1e-2, 0.1])
def test_the_answer_of_hulls_that_move_is_that_of_each_pose_alone(step):
    rng = np.random.default_rng([5, int(1e6 * step)])
    kept = 0
    for _ in range(max(COUNT, 12)):  # of hulls that leap, few are remembered
        pair, row = _overlapping(rng), _wide()
        for _ in range(6):
            _assert_same(_answer(pair, row), _answer(pair, np.zeros(PAIR_WIDTH)))
            kept += row[SLOT_WIDTH] > 0.0
            pair = _moved(rng, pair, step)
    assert kept > 0  # otherwise nothing was tested


def test_hulls_that_do_not_move_need_no_more_than_what_is_remembered():
    rng = np.random.default_rng(2)
    pair, row = _overlapping(rng), _wide()
    for _ in range(3):  # the first tells where they are, the second keeps
        first = _answer(pair, row).copy()
    kept = row[SLOT_WIDTH:].copy()
    assert kept[0] >= 4.0
    for n in (tuple(-first[NORMAL : NORMAL + 3]), X):  # that of last time, and any
        narrow = Overlap(-separation_along(pair, n), n)
        sure, depth = remembered.remembered_depth(pair, narrow, kept, _size(pair), 1e-15)
        assert sure
        assert -first[DISTANCE] == pytest.approx(depth.upper, abs=1e-15)
        np.testing.assert_array_equal(kept, row[SLOT_WIDTH:])


def test_along_a_normal_that_parts_the_hulls_nothing_is_looked_at():
    rng = np.random.default_rng(2)
    pair, kept = _overlapping(rng), np.zeros(MEMORY_WIDTH)
    apart = core_pair(*pair[:6], (0.5, 0.0, 0.0))
    kept[:2] = 4.0
    narrow = Overlap(-separation_along(apart, X), X)
    sure, depth = remembered.remembered_depth(apart, narrow, kept, _size(apart), 1e-15)
    assert not sure
    assert depth.upper == narrow.width < 0.0
    assert kept[0] == 0.0


def test_hulls_that_turn_out_to_be_apart_tell_a_direction_that_parts_them():
    """By a start along which they overlap."""
    rng, told = np.random.default_rng(12), 0
    for _ in range(20 * COUNT):
        pair = _overlapping(rng)
        pair = core_pair(*pair[:6], tuple(1.6 * np.array(pair.p_AB)))
        n = tuple(random_directions(rng, 1)[0])
        narrow = Overlap(-separation_along(pair, n), n)
        sure, depth = remembered.depth_of_hulls(pair, narrow, np.zeros(0), _size(pair), 1e-15)
        assert depth.upper <= narrow.width
        if narrow.width > 0.0 and depth.upper < 0.0:
            told += 1
            assert not sure
            assert separation_along(pair, depth.n) == pytest.approx(-depth.upper, abs=1e-15)
    assert told > 0


def test_the_depth_is_the_true_one():
    rng = np.random.default_rng(3)
    for _ in range(4):
        pair, row = _overlapping(rng), _wide()
        for _ in range(3):
            phi, _ = signed_distance(
                (CONVEX, pair.shape_A),
                (pair.R_WA, np.zeros(3)),
                (CONVEX, pair.shape_B),
                (pair.R_WB, np.array(pair.p_AB)),
            )
            assert _answer(pair, row)[DISTANCE] == pytest.approx(phi, abs=1e-11)
            pair = _moved(rng, pair, 3e-3)


def test_hulls_that_part_forget():
    rng = np.random.default_rng(4)
    pair, row = _overlapping(rng), _wide()
    for _ in range(2):
        _answer(pair, row)
    assert row[SLOT_WIDTH] > 0.0
    _answer(core_pair(*pair[:6], (0.5, 0.0, 0.0)), row)
    assert row[DISTANCE] > 0.0
    assert row[SLOT_WIDTH] == 0.0


_strange = st.floats(allow_nan=True, allow_infinity=True)
_numbers = st.one_of(_strange, st.integers(-2, 300).map(float), st.integers(0, 2**53).map(float))


@settings(max_examples=10 if config.DISABLE_JIT else 300)
@given(seed=st.integers(0, 2**16), data=st.data())
def test_no_numbers_in_the_memory_can_spoil_an_answer(seed, data):
    """Some, or all, of what is remembered is anything; what lies behind the row is left alone."""
    rng = np.random.default_rng(seed)
    pair, room = _overlapping(rng), np.zeros(SLOT_WIDTH + MEMORY_WIDTH + 64)
    row = room[: SLOT_WIDTH + MEMORY_WIDTH]
    for _ in range(2):
        alone = _answer(pair, row)[:PAIR_WIDTH].copy()
    changed = data.draw(st.lists(st.integers(0, MEMORY_WIDTH - 1), max_size=MEMORY_WIDTH))
    for k in changed:
        row[SLOT_WIDTH + k] = data.draw(_numbers)
    if data.draw(st.booleans()):
        row[SLOT_WIDTH + memory.POSITION :][:3] = pair.p_AB
    room[row.size :] = 7.0
    _assert_same(_answer(pair, row), alone)
    assert (room[row.size :] == 7.0).all()


def _closed_surface(rng, count):
    """Return a memory of a closed surface whose vertices are any pairs of vertices."""
    kept = np.zeros(MEMORY_WIDTH)
    # These views do not keep the block alive.
    _block = np.empty(small_polytope.growth_numbers())
    points, corners, _, masks, _, _ = small_polytope.growth_arrays(_block)
    pair = _overlapping(rng)
    remembered.double_pyramid(pair, Overlap(math.inf, X), points, corners)
    memory.keep(kept, points, corners, 2 * remembered.SIDES, masks)
    i, j = rng.integers(1, 8, (2, count))
    kept[memory.FIRST_NAME :][:count] = i + memory.NAMES * j
    return kept


@pytest.mark.parametrize('few', [1, 2, 3, 8])
def test_a_closed_surface_of_any_vertices_leads_to_the_same_answer(few):
    """Flat ones, and such that hold the origin twice or not at all."""
    rng = np.random.default_rng([6, few])
    for _ in range(20 * COUNT):
        pair, row = _overlapping(rng), _wide()
        alone = _answer(pair, row)[:PAIR_WIDTH].copy()
        count = 2 + remembered.SIDES
        kept = _closed_surface(rng, count)
        names = rng.choice(kept[memory.FIRST_NAME :][:count], few)
        kept[memory.FIRST_NAME :][:count] = rng.choice(names, count)
        kept[memory.POSITION :][:3] = pair.p_AB
        row[SLOT_WIDTH:] = kept
        _assert_same(_answer(pair, row), alone)


def test_no_direction_in_the_cap_of_a_ball_is_narrower():
    """Of faces that are told to be nowhere nearer than a rival, by rays through them."""
    rng, told = np.random.default_rng(10), 0
    for _ in range(5 * COUNT):
        ball = ball_caps.Ball((-0.1, 0.0, 0.0), 0.1, float(rng.uniform(0.05, 0.15)))
        points = np.zeros((3, 10))
        points[:, :3] = 0.1 * rng.normal(size=(3, 3))
        faces, planes = np.array([[0, 1, 2]], dtype=np.int32), np.zeros((1, 4))
        n = np.cross(points[1, :3] - points[0, :3], points[2, :3] - points[0, :3])
        n *= np.sign(n @ points[0, :3]) / np.linalg.norm(n)
        planes[0] = [*n, (points[:, :3] @ n).min()]
        rival = float(rng.uniform(0.01, 0.12))
        if ball_caps.is_in_ball_cap(points, faces, planes, 0, ball, rival):
            told += 1
            x = rng.dirichlet(np.ones(3), 400) @ points[:, :3]
            away = np.linalg.norm(x, axis=1)
            widths = x @ ball.centre / away + ball.radius
            assert np.maximum(away, widths).min() >= rival - 1e-12
    assert told > 0
