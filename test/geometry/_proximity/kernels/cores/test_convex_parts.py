"""Steps of the iterative kernel whose outcome is known."""

import math

import numpy as np
import pytest
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    CLOSED,
    CLOSED_ASIDE,
    OVERLAP,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Depth, Separation
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER
from truth.bodies.random_bodies import random_rotation

CUBE = np.array([1.0, 1.0, 1.0])
HULL = np.concatenate(([8.0], np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).ravel()))  # the same


@pytest.mark.parametrize(
    ('hint', 'p', 'n', 'hinted'),
    [
        ((0.0, -0.6, -0.8), (5.0, 0.0, 0.0), (0.0, 0.6, 0.8), True),
        ((0.0, 0.0, -1e-300), (5.0, 0.0, 0.0), (0.0, 0.0, 1.0), True),
        ((0.0, 0.0, 0.0), (0.0, -5.0, 0.0), (0.0, -1.0, 0.0), False),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), False),
        ((np.nan, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.0), False),
    ],
)
def test_a_hint_of_any_length_is_taken_else_the_way_to_the_other(hint, p, n, hinted):
    out = np.zeros(PAIR_WIDTH)
    out[NORMAL : NORMAL + 3] = hint
    found, is_hinted = convex.hint_of(out, p)
    assert tuple(found) == pytest.approx(n, abs=1e-15)
    assert is_hinted == hinted


def test_points_are_drawn_to_their_distance_by_as_little_as_can_be():
    n, a, b = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.5, 0.0, 2.0)
    a, b, miss = convex.drawn_to(1.5, n, a, b)
    assert (tuple(a), tuple(b)) == ((0.25, 0.0, 0.25), (0.25, 0.0, 1.75))
    assert miss == pytest.approx(np.hypot(0.25, 0.25))


@pytest.mark.parametrize('in_A', [0.0, 0.125, -0.25])
@pytest.mark.parametrize('in_B', [0.0, 0.125, -0.25])
@pytest.mark.parametrize('miss', [0.0625, 1.0])
@pytest.mark.parametrize(('kind', 'radius'), [(CYLINDER, 0.0), (CAPSULE, 0.5)])
def test_points_are_off_their_surfaces_by_the_worse_but_no_more_than_they_were_moved(
    in_A, in_B, miss, kind, radius
):
    """Seen from a face of a cube, and from the side of a turned rod; a core's point is given."""
    R, p, n = random_rotation(np.random.default_rng(1)), np.array([1.0, 2.0, 3.0]), np.eye(3)[0]
    pair = CorePair(BOX, CUBE, np.eye(3), kind, np.array([0.5, 2.0]), R, tuple(p))
    on_B = p + R @ [0.3 / 0.5 * (0.5 - in_B), 0.4 / 0.5 * (0.5 - in_B), 0.25]
    a, b = (1.0 - in_A, 0.25, 0.25), on_B + radius * n
    found = convex.off_surfaces(pair, tuple(n), a, tuple(b), miss)
    assert found == pytest.approx(max(min(abs(in_A), miss), min(abs(in_B), miss)), abs=1e-14)


def test_polytopes_have_vertices():
    kinds = [BOX, CAPSULE, CYLINDER, CONVEX]
    assert [convex.is_polytope(kind) for kind in kinds] == [True, True, False, True]


def test_the_gap_along_a_direction_is_that_of_the_planes():
    pair = CorePair(BOX, CUBE, np.eye(3), BOX, CUBE, np.eye(3), (3.0, 4.0, 0.0))
    assert convex.separation_along(pair, (1.0, 0.0, 0.0)) == 1.0
    assert convex.separation_along(pair, (0.6, 0.8, 0.0)) == pytest.approx(5.0 - 2.0 * 1.4)


Y = (0.0, 1.0, 0.0)
NOT_CLOSED = Separation(OVERLAP, 0.0, 0.0, Y, Y, Y, Y)


def _bounds_python(monkeypatch, p, walked, depth, sharper=NOT_CLOSED, miss=0.0):
    """Return the bounds of two cubes at p, where GJK told ``walked`` and what is else asked."""
    asked = []

    def told(found):
        return lambda *_: asked.append(found) or found

    pair = CorePair(CONVEX, HULL, np.eye(3), BOX, CUBE, np.eye(3), p)
    asked_for = pair, (1.0, 0.0, 0.0), False, 6.0, 1e-9, math.inf, np.zeros(0)
    # What calls something replaced cannot be compiled, whatever was compiled before.
    for name in ('beside_an_axis', 'bounds_of_both'):
        step = getattr(convex, name)
        monkeypatch.setattr(convex, name, getattr(step, 'py_func', step))
    monkeypatch.setattr(convex, 'distance_of_cores', told(walked))
    monkeypatch.setattr(convex, 'depth_and_bounds', told(depth))
    monkeypatch.setattr(convex, 'sharpened', told(sharper))
    monkeypatch.setattr(
        convex, 'witnesses_of_depth', lambda _, n, depth, *rest: (*rest[1:3], miss)
    )
    search = getattr(convex.bounds_of_cores, 'py_func', convex.bounds_of_cores)
    found = search(*asked_for)
    return found, [each for each in asked if each is not sharper]


@pytest.mark.parametrize(
    ('end', 'n', 'attained'),
    [
        (CLOSED, (1.0, 0.0, 0.0), True),
        (CLOSED_ASIDE, (1.0, 0.0, 0.0), True),
        (CLOSED_ASIDE, (0.8, 0.6, 0.0), False),
    ],
)
def test_what_a_walk_ends_with_is_the_answer_if_the_slab_along_its_own_normal_is(
    monkeypatch, end, n, attained
):
    walked = Separation(end, 2.0, 2.0 - 1e-12, n, (1.0, 0.0, 0.0), (3.0, 0.0, 0.0), n)
    depth = Depth(-2.0, -2.0, (1.0, 0.0, 0.0), (1.0, 0.5, 0.0), (3.0, 0.5, 0.0), 0.0, True)
    # Not closed, though told the distance: that is not what is asked of it.
    sharper = Separation(OVERLAP, 2.0, 2.0, Y, Y, Y, Y)
    found, asked = _bounds_python(monkeypatch, (4.0, 0.0, 0.0), walked, depth, sharper)
    assert asked == ([walked] if attained else [walked, depth])
    assert found.n == (1.0, 0.0, 0.0)
    assert (found.distance, found.upper, found.unique) == (2.0, 2.0, True)


@pytest.mark.parametrize(
    ('end', 'lean', 'miss', 'of_walk'),
    [
        (CLOSED_ASIDE, 1e-8, 1e-7, True),
        (CLOSED_ASIDE, 1e-8, 0.0, False),
        (CLOSED_ASIDE, 1e-7, 1e-7, False),
        (OVERLAP, 1e-8, 1e-7, False),
    ],
)
def test_points_that_need_no_move_are_taken_if_their_normal_lacks_less(
    monkeypatch, end, lean, miss, of_walk
):
    """A normal that leans by an angle [rad] lacks twice as much [m]: cubes are 2 m wide."""
    n = (1.0, lean, 0.0)
    walked = Separation(end, 2.0, 2.0 - 1e-12, n, (1.0, 0.0, 0.0), (3.0, 0.0, 0.0), n)
    depth = Depth(-2.0, -2.0, (1.0, 0.0, 0.0), (1.0, 0.5, 0.0), (3.0, 0.5, 0.0), 0.0, True)
    found, _ = _bounds_python(monkeypatch, (4.0, 0.0, 0.0), walked, depth, miss=miss)
    if of_walk:
        assert (found.a, found.b) == (walked.a, walked.b)
    assert found.n == (n if of_walk else (1.0, 0.0, 0.0))
    assert found.miss == (0.0 if of_walk else miss)
    assert found.distance == 2.0


@pytest.mark.parametrize('seed', range(20))
def test_points_of_a_disk_and_a_tiny_rod_just_beside_it_lie_on_both(seed):
    """Their normal is level, for points on both: leaning by 2.4e-8 rad to the rim proves more.

    By up to 4e-10 here, which is in the bound: see ``pairs.proved_by_normal``.
    """
    R = random_rotation(np.random.default_rng(seed))
    disk, rod, p = np.array([1.0, 5e-7]), np.array([1e-9, 3e-8]), R @ [-1.0, -0.0002, 0.8]
    out = np.zeros(PAIR_WIDTH)
    pair = CYLINDER, disk, R, CYLINDER, rod, R, p
    call_for_pair(convex.signed_distance_of_cores, *pair, 1e-12, np.inf, out)
    assert out[DISTANCE] == pytest.approx(0.7999994700000003, abs=1e-15)
    assert out[ERROR_BOUND] < 1e-9
    for shape, q in ((disk, out[WITNESS_A:][:3]), (rod, out[WITNESS_B:][:3] - p)):
        x, y, z = R.T @ q
        assert max(np.hypot(x, y) - shape[0], abs(z) - shape[1]) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize('unique', [False, True])
@pytest.mark.parametrize('apart', [-0.5, 0.5])
def test_a_normal_is_alone_if_the_depth_says_so_or_the_bodies_are_apart(
    monkeypatch, unique, apart
):
    n = (1.0, 0.0, 0.0)
    a, b = (1.0, 0.0, 0.0), (1.0 + apart, 0.0, 0.0)
    walked = Separation(OVERLAP, 0.5, apart - 0.125, n, a, b, n)
    depth = Depth(-apart, -apart, n, a, b, 0.0, unique)
    found, _ = _bounds_python(monkeypatch, (2.0 + apart, 0.0, 0.0), walked, depth)
    assert (found.distance, found.lower) == (apart, apart)
    assert found.unique == (unique or apart > 0.0)


@pytest.mark.parametrize('is_hull', [True, False])
def test_the_last_digits_come_from_the_edge_next_to_the_normal(is_hull):
    """The upright edge of a cube and a rod that lies across it, from a normal that is off."""
    c = math.sqrt(0.5)
    R = np.array([[0.0, c, c], [0.0, c, -c], [-1.0, 0.0, 0.0]])
    cube = (CONVEX, HULL) if is_hull else (BOX, CUBE)
    rod = CYLINDER, np.array([0.5, 2.0]), R, (3.0, 3.0, 0.0)
    pair = CorePair(*cube, np.eye(3), *rod)
    n = np.array([c, c, 1e-3]) / np.hypot(1.0, 1e-3)
    end, distance, lower, m, a, b, _ = convex.sharpened(
        pair, convex.difference_of(pair), tuple(n), 1e-6, 1e-14, 1e-12
    )
    assert end == CLOSED
    assert distance == pytest.approx(math.sqrt(8.0) - 0.5, abs=1e-14)
    assert lower == pytest.approx(distance, abs=1e-12)
    assert m == pytest.approx((c, c, 0.0), abs=1e-8)
    assert a == pytest.approx((1.0, 1.0, 0.0), abs=1e-7)
    assert b == pytest.approx((3.0 - 0.5 * c, 3.0 - 0.5 * c, 0.0), abs=1e-7)


@pytest.mark.parametrize(
    ('hinted', 'widths', 'starts', 'kept'),
    [
        (False, [1e-9], ['x'], 0),
        (False, [1e-3, 1e-9], ['x', 'found 0'], 1),
        (True, [1e-3, 1e-9], ['x', 'centres'], 1),
        (True, [1e-3, 1e-2, 1e-9], ['x', 'centres', 'found 0'], 2),
        (False, [1e-3, 1e-2, 1e-2], ['x', 'found 0', 'found 0'], 0),
    ],
)
def test_bounds_that_stay_loose_are_sought_from_elsewhere(
    monkeypatch, hinted, widths, starts, kept
):
    """From the line of centres after a bad hint, then from the best normal so far."""
    names = {(1.0, 0.0, 0.0): 'x', Y: 'centres'}
    seen = []

    def bounds_of_cores(_, n, is_hint, *rest):
        k = len(seen)
        seen.append(names[n])
        assert is_hint == (hinted if k == 0 else names[n] != 'centres')
        names[0.0, float(k), 1.0] = f'found {k}'
        zero = 0.0, 0.0, 0.0
        m = 0.0, float(k), 1.0
        return convex.Bounds(CLOSED, 1.0, 1.0, 1.0 - widths[k], m, zero, zero, 0.0, True, m)

    monkeypatch.setattr(convex, 'bounds_of_cores', bounds_of_cores)
    pair = CorePair(BOX, CUBE, np.eye(3), BOX, CUBE, np.eye(3), (0.0, 4.0, 0.0))
    search = getattr(convex.bounds_of_best_start, 'py_func', convex.bounds_of_best_start)
    found = search(pair, (1.0, 0.0, 0.0), 1.0, hinted, 6.0, 1e-9, math.inf, np.zeros(0))
    assert seen == starts
    assert found.n == (0.0, float(kept), 1.0)


@pytest.mark.parametrize('hint', [(-1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.6, 0.0, -0.8)])
def test_a_hint_of_poses_long_past_costs_hulls_that_are_apart_no_search_for_a_depth(
    monkeypatch, hint
):
    def search_for_depth(*_):
        raise AssertionError

    pair = CorePair(CONVEX, HULL, np.eye(3), CONVEX, HULL, np.eye(3), (2.5, 0.5, 0.0))
    convex.bounds_of_cores(pair, hint, True, 6.0, 1e-9, math.inf, np.zeros(0))  # compiles the rest
    for name in ('depth_and_bounds', 'bounds_of_both'):
        monkeypatch.setattr(convex, name, search_for_depth)
    search = getattr(convex.bounds_of_cores, 'py_func', convex.bounds_of_cores)
    found = search(pair, hint, True, 6.0, 1e-9, math.inf, np.zeros(0))
    assert found.distance == pytest.approx(0.5, abs=1e-15)
    assert found.n == pytest.approx((1.0, 0.0, 0.0), abs=1e-15)
