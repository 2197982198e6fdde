"""The loop over near pairs: what it reports, what it knows without a kernel, what it forgets."""

import math

import numpy as np
import pytest
from oracles.worlds import geometry_table

from drake_geom_ros.geometry import Convex
from drake_geom_ros.geometry._proximity.kernels import addresses as kernel_table
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    SEEN,
    SLACK,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import hull_parameters
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    BOX,
    CLOSED_FORM,
    CONVEX,
    ELLIPSOID,
    HALF_SPACE,
    ITERATIVE,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.pairs import distance_bounds, narrow_phase
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT, empty_memory
from drake_geom_ros.geometry._proximity.report import BY_METHOD, CACHED, COUNTS, FAR, POSTPONED
from drake_geom_ros.geometry._proximity.tolerances import TOUCHING_DEPTH
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from drake_geom_ros.geometry.meshes.source import MeshData, coarse_hull_of
from truth.bodies.random_bodies import random_directions

AT_ONCE = np.empty(0, dtype=np.int64), np.empty(0)


class Loop:
    """A world of bodies on frames of their own and its memory of all pairs, in rising order."""

    def __init__(self, types, parameters, ps):
        n = len(types)
        frames = FrameTable(np.arange(1, n + 2), np.zeros(n + 1, dtype=np.int64))
        self.world = World(frames, geometry_table(range(1, n + 1), types, parameters))
        self.pose(range(n), ps)
        self.pairs = np.column_stack(np.triu_indices(n, k=1)).astype(np.int64)
        self.slots = np.arange(len(self.pairs))[::-1].copy()  # no number is taken for another
        self.memory = empty_memory(len(self.pairs))
        rows = kernel_table.table_rows(*self.world.geometries.types[self.pairs].T)
        kernel_table.compile_rows(rows)

    def pose(self, bodies, ps):
        frames = np.array(bodies) + 1
        R_WFs = np.tile(np.eye(3), (len(frames), 1, 1))
        self.world.set_poses(frames, R_WFs, np.array(ps, dtype=float))
        self.world.update()

    def answer(
        self, cutoff, level_gap=1e-9, penetrating=False, first=-1, enough=0.0, queue=AT_ONCE
    ):
        """Return the numbers of the hits and {name: count} of what was done."""
        hits, counts = np.empty(len(self.pairs), dtype=np.int64), np.empty(COUNTS, dtype=np.int64)
        search = EVERY_HIT if first < 0 else (first, enough)
        found = narrow_phase.answer_pairs(
            *(kernel_table.ADDRESSES, self.pairs, self.slots, self.memory, self.world.handle),
            *(self.world.revision, (level_gap, cutoff, penetrating), search, queue, hits, counts),
        )
        names = {FAR: 'far', CACHED: 'cached', POSTPONED: 'postponed'}
        names |= {BY_METHOD + CLOSED_FORM: 'closed', BY_METHOD + BOUND_ONLY: 'bound'}
        names[BY_METHOD + ITERATIVE] = 'iterative'
        done = {names[k]: count for k, count in enumerate(counts.tolist()) if count}
        return hits[:found].tolist(), done

    def row(self, k):
        return self.memory[self.slots[k]]


def row_of_balls():
    """Return balls of 0.1 m at 0, 0.3, 0.7 and 1.5 m on a line: pairs 01, 02, 03, 12, 13, 23."""
    return Loop([SPHERE] * 4, [[0.1]] * 4, [[x, 0, 0] for x in (0.0, 0.3, 0.7, 1.5)])


def test_a_row_of_the_table_in_either_order():
    types = np.array([SPHERE, BOX, HALF_SPACE])
    rows = kernel_table.table_rows(types[:, None], types[None, :])
    np.testing.assert_array_equal(rows, rows.T)
    assert rows[2, 2] == -1
    assert len({*rows.ravel().tolist()}) == 6


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
def test_either_order_of_types_is_the_same_pair(order):
    """A box about 0 with half sizes 1, 2, 3 and a ball of 0.5 m that is 1.5 m above its face."""
    types, parameters = [BOX, SPHERE], [[1.0, 2.0, 3.0], [0.5]]
    ps = [[10.0, 20.0, 30.0], [10.25, 20.5, 35.0]]
    for hint in ([0.0, 0.0, 0.0], [0.6, 0.0, 0.8]):
        loop = Loop(*([given[k] for k in order] for given in (types, parameters, ps)))
        loop.row(0)[NORMAL : NORMAL + 3] = hint
        assert loop.answer(9.0) == ([0], {'closed': 1})
        side = 1.0 if order == (0, 1) else -1.0  # A out of B: down from the ball, or up
        row, on_box, on_ball = loop.row(0), [0.25, 0.5, 3.0], [0.0, 0.0, -0.5]
        p_AB = np.subtract(ps[order[1]], ps[order[0]])
        points = [on_box, p_AB + on_ball] if side > 0 else [on_ball, p_AB + on_box]
        assert row[DISTANCE] == 1.5
        assert row[NORMAL : NORMAL + 3].tolist() == [0.0, 0.0, -side]
        np.testing.assert_allclose(row[WITNESS_A : WITNESS_A + 3], points[0], rtol=0, atol=1e-14)
        np.testing.assert_allclose(row[WITNESS_B : WITNESS_B + 3], points[1], rtol=0, atol=1e-14)
        assert (row[UNIQUE], row[METHOD]) == (1.0, CLOSED_FORM)


def test_pairs_are_far_new_or_known_and_a_move_wakes_only_its_own():
    loop = row_of_balls()
    assert loop.answer(0.5) == ([0, 1, 3], {'far': 3, 'closed': 3})
    assert loop.answer(0.5) == ([0, 1, 3], {'far': 3, 'cached': 3})
    assert loop.answer(0.15) == ([0], {'far': 5, 'cached': 1})
    loop.pose([3], [[1.45, 0, 0]])
    assert loop.answer(0.5) == ([0, 1, 3], {'far': 3, 'cached': 3})
    loop.pose([3], [[1.25, 0, 0]])  # 23 is 0.35 apart now
    assert loop.answer(0.5) == ([0, 1, 3, 5], {'far': 2, 'cached': 3, 'closed': 1})
    loop.pose([0], [[0.001, 0, 0]])
    assert loop.answer(0.5) == ([0, 1, 3, 5], {'far': 2, 'cached': 2, 'closed': 2})


def test_an_answer_for_one_level_is_not_one_for_another():
    loop = row_of_balls()
    assert loop.answer(0.5, level_gap=1e-3)[1] == {'far': 3, 'closed': 3}
    assert loop.answer(0.5, level_gap=1e-3)[1] == {'far': 3, 'cached': 3}
    assert loop.answer(0.5, level_gap=1e-2)[1] == {'far': 3, 'closed': 3}
    assert loop.answer(0.5, level_gap=1e-6)[1] == {'far': 3, 'closed': 3}


def test_bounds_alone_are_those_of_now_whatever_is_known_from_before():
    loop = row_of_balls()
    hits, done = loop.answer(0.5, level_gap=math.inf)
    rows = [loop.row(k).copy() for k in hits]
    for cutoff in (0.5, math.inf):
        assert loop.answer(cutoff, level_gap=1e-6)[1]['closed'] >= 3
        assert loop.answer(0.5, level_gap=math.inf) == (hits, done)
        np.testing.assert_array_equal([loop.row(k) for k in hits], rows)


def test_bounds_alone_call_no_kernel_and_keep_what_may_be():
    loop = row_of_balls()
    hits, done = loop.answer(0.5, level_gap=math.inf)
    assert (hits, done) == ([0, 1, 3], {'far': 3, 'bound': 3})
    # And what was asked before says nothing: an interval may reach below where boxes are apart.
    assert loop.answer(0.5, level_gap=math.inf)[1] == {'far': 3, 'bound': 3}
    assert loop.answer(0.5)[1] == {'far': 3, 'closed': 3}


def test_one_hit_is_enough_for_who_says_where_to_begin():
    loop = Loop([SPHERE] * 3, [[0.1]] * 3, [[0, 0, 0], [0.15, 0, 0], [0.3, 0, 0]])
    for first, hit in ((0, 0), (1, 2), (2, 2), (3, 0)):
        assert loop.answer(0.0, penetrating=True, first=first)[0] == [hit]


def test_coarse_hulls_are_a_hit_where_they_are_near_enough_for_certain():
    mesh = MeshData(0.2 * random_directions(np.random.default_rng(0), 300))
    surface, coarse = Convex.FromMeshData(mesh).hull_surface(), coarse_hull_of(mesh, np.ones(3))
    hull = hull_parameters(*surface, coarse)
    loop = Loop([CONVEX] * 2, [hull] * 2, [[0, 0, 0], [0.5, 0, 0]])
    assert 0.002 < coarse.reach < 0.02  # they are 0.1 to 0.14 apart
    assert loop.answer(0.3, first=0, enough=0.2) == ([0], {'bound': 1})
    assert loop.row(0)[SEEN] < 0.0
    # The cutoff alone makes no hit.
    assert loop.answer(0.3, first=0, enough=0.05) == ([0], {'iterative': 1})
    assert 0.1 < loop.row(0)[DISTANCE] < 0.14
    loop.pose([1], [[0.3, 0, 0]])
    assert loop.answer(0.0, penetrating=True, first=0) == ([0], {'bound': 1})


@pytest.mark.parametrize(('depth', 'hits'), [(1e-15, []), (4e-15, [0]), (-1e-15, [])])
def test_touching_is_not_penetrating(depth, hits):
    """What counts is the depth in units of the pair's size, 0.2 m here: 2e-15 m."""
    loop = Loop([SPHERE] * 2, [[0.1]] * 2, [[0, 0, 0], [0.2 - depth, 0, 0]])
    assert pytest.approx(2e-15) == TOUCHING_DEPTH * 0.2
    assert loop.answer(0.0, penetrating=True)[0] == hits


def test_a_queue_takes_who_needs_a_kernel_with_the_least_distance_known():
    loop = row_of_balls()
    waiting, distances = np.empty(6, dtype=np.int64), np.empty(6)
    assert loop.answer(0.5, queue=(waiting, distances)) == ([], {'far': 3, 'postponed': 3})
    assert waiting[:3].tolist() == [0, 1, 3]
    np.testing.assert_allclose(distances[:3], [0.1, 0.5, 0.2], rtol=0, atol=1e-14)
    loop.answer(0.5)
    loop.pose([0], [[-0.02, 0, 0]])
    hits, done = loop.answer(0.6, queue=(waiting, distances))
    assert (hits, done) == ([3], {'far': 2, 'cached': 1, 'postponed': 3})
    assert waiting[:3].tolist() == [0, 1, 5]
    # Balls are their own bounds: what is known is as good as it gets.
    np.testing.assert_allclose(distances[:3], [0.12, 0.52, 0.6], rtol=0, atol=1e-14)


def test_what_waits_is_no_nearer_than_bounds_say():
    """A ball beyond a cube's corner: bounding volumes leave room below the distance and above."""
    loop = Loop([BOX, SPHERE], [[1.0] * 3, [0.5]], [[0, 0, 0], [2, 2, 1.5]])
    waiting, distances = np.empty(1, dtype=np.int64), np.empty(1)
    assert loop.answer(9.0, queue=(waiting, distances)) == ([], {'postponed': 1})
    assert 0.5 < distances[0] <= 1.0


@pytest.mark.parametrize('exponent', [-700, -200, 200, 700])
@pytest.mark.parametrize('types', [(SPHERE, BOX), (ELLIPSOID, BOX), (BOX, ELLIPSOID)])
def test_pairs_out_of_the_range_of_products_have_the_digits_of_those_within(types, exponent):
    sizes = {SPHERE: [1.0], BOX: [1.0, 0.75, 0.5], ELLIPSOID: [0.5, 1.0, 0.25]}
    found = []
    for e in (0, exponent):
        parameters = [np.ldexp(sizes[kind], e) for kind in types]
        loop = Loop(types, parameters, np.ldexp([[0, 0, 0], [0.5, 3.0, 0.25]], e))
        assert loop.answer(math.inf, level_gap=math.ldexp(1e-9, e))[0] == [0]
        found.append(loop.row(0)[:PAIR_WIDTH])
    lengths = [DISTANCE, ERROR_BOUND, *range(WITNESS_A, WITNESS_B + 3)]
    found[1][lengths] = np.ldexp(found[1][lengths], -exponent)
    assert 1.0 < found[0][DISTANCE] < 2.0
    np.testing.assert_array_equal(found[1], found[0])


def test_pairs_that_wait_are_answered_by_the_narrower_of_bounds_and_memory():
    loop = Loop([BOX, SPHERE], [[1.0, 1.0, 1.0], [0.5]], [[0, 0, 0], [2, 2, 2]])
    loop.answer(9.0)
    first = loop.row(0)[DISTANCE]  # from the corner
    assert first == pytest.approx(math.sqrt(3.0) - 0.5, abs=1e-14)
    hits, counts = np.empty(1, dtype=np.int64), np.empty(COUNTS, dtype=np.int64)

    def bound(cutoff=9.0):
        query = 1e-9, cutoff, False
        arguments = loop.pairs, loop.slots, loop.memory, loop.world.handle, loop.world.revision
        return narrow_phase.bound_pairs(*arguments, query, hits, counts)

    for p_WB, moved in (([2.01, 2, 2], 0.01), ([2.01, 2, 2.02], 0.03)):
        loop.pose([1], [p_WB])
        assert bound(first - moved - 1e-3) == 0
        assert (counts[CACHED], counts[BY_METHOD + BOUND_ONLY]) == (0, 1)
        assert bound(first - moved + 1e-3) == 1
        assert (counts[CACHED], counts[BY_METHOD + BOUND_ONLY]) == (1, 0)
        row = loop.row(0)
        assert (row[DISTANCE], row[METHOD], row[UNIQUE]) == (first, BOUND_ONLY, 0.0)
        assert row[ERROR_BOUND] == pytest.approx(moved, abs=1e-13)
    loop.pose([1], [[0, 0, 8.0]])  # bounding volumes are wrong by less than the move
    assert bound() == 1
    row = loop.row(0)
    assert row[DISTANCE] - row[ERROR_BOUND] <= 6.5 <= row[DISTANCE] + row[ERROR_BOUND]
    assert row[ERROR_BOUND] < 1.0


def test_a_slack_is_what_the_answer_certifies_and_a_cut_off_one_is_far_from_then_on():
    """Two slats of 2 m side by side, turned by 45 degrees, so that their boxes and balls meet."""
    slats = Loop([ELLIPSOID] * 2, [[1.0, 0.1, 0.2]] * 2, [[0, 0, 0]] * 2)
    c = math.sqrt(0.5)
    turned = np.tile([[c, -c, 0.0], [c, c, 0.0], [0.0, 0.0, 1.0]], (2, 1, 1))
    slats.world.set_poses(np.array([1, 2]), turned, np.array([[0, 0, 0], [-0.5 * c, 0.5 * c, 0]]))
    slats.world.update()
    travelled = slats.world.travels.sum()
    for level_gap in (1e-3, 1e-9):
        assert slats.answer(1.0, level_gap)[0] == [0]
        row, slack = slats.row(0), slats.memory[0, SLACK] - travelled
        assert abs(row[DISTANCE] - 0.3) <= row[ERROR_BOUND] <= level_gap
        assert slack == pytest.approx(row[DISTANCE] - row[ERROR_BOUND], abs=1e-14)
    slats.memory[:, SLACK], slats.memory[:, SEEN] = -math.inf, -1
    assert slats.answer(0.1) == ([], {'bound': 1})
    bound, slack = slats.row(0)[DISTANCE], slats.memory[0, SLACK] - travelled
    assert 0.1 < bound - 1e-13 <= slack <= bound <= 0.3 + 1e-14
    assert slats.answer(0.1) == ([], {'far': 1})


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
@pytest.mark.parametrize('level_gap', [1e-9, math.inf])
def test_a_plane_that_turned_knows_nothing_of_before(order, level_gap):
    """However far a body is, a turn of the plane may bury it: no travel of its origin tells."""
    types, parameters, ps = [HALF_SPACE, SPHERE], [[], [0.1]], [[0, 0, 0], [-100, 0, 10]]
    loop = Loop(*([given[k] for k in order] for given in (types, parameters, ps)))
    assert loop.answer(0.5, level_gap) == ([], {'far': 1})
    assert loop.answer(20.0, level_gap)[0] == [0]
    upright = np.array([[[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]])
    loop.world.set_poses(np.array([1 + order.index(0)]), upright, np.zeros((1, 3)))
    loop.world.update()
    assert loop.answer(0.5, level_gap)[0] == [0]
    assert loop.row(0)[DISTANCE] == pytest.approx(-100.1, rel=1e-12)


def test_near_pairs_are_those_whose_boxes_are_and_planes_have_their_own_gap():
    types, parameters = [HALF_SPACE, BOX, SPHERE], [[], [0.1, 0.2, 0.3], [0.25]]
    loop = Loop(types, parameters, [[9, 9, 1.0], [0, 0, 2.0], [0, 0, 3.0]])
    world = loop.world
    for distance, expected in ((0.4, []), (0.5, [2]), (0.75, [0, 2]), (1.8, [0, 1, 2])):
        for pairs in (loop.pairs, loop.pairs[:, ::-1].copy()):
            hits = np.empty(3, dtype=np.int64)
            count = distance_bounds.near_pairs(pairs, world.handle, distance, hits)
            assert hits[:count].tolist() == expected
