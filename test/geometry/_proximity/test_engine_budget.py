"""Queries with a time budget: who becomes sharp, who keeps bounds, what is carried over."""

import math

import numpy as np
import pytest
from oracles.engine_calls import has_overlap, signed_distances
from oracles.worlds import filters_of, random_world, shuffle

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY
from drake_geom_ros.geometry._proximity.pairs.budget import LONGEST_BLOCK, SHORTEST_BLOCK
from drake_geom_ros.geometry._proximity.pairs.budgeted import BudgetedAnswers

PLENTY, NOTHING = 1e6, 1e-12  # [s]


def by_ids(batch):
    return {tuple(ids): row for ids, row in zip(batch.ids.tolist(), batch.rows, strict=True)}


def test_with_enough_time_the_answer_is_the_one_without_a_budget():
    rng = np.random.default_rng(0)
    world = random_world(rng, 40, anchored=10)
    free, bound = Engine(), Engine()
    filters = filters_of(world)
    for step in range(6):
        for cutoff, penetrating in ((0.2, False), (0.0, True), (math.inf, False)):
            query = (world, filters, 'exact', cutoff, penetrating)
            expected, answer = (
                signed_distances(free, *query),
                signed_distances(bound, *query, PLENTY),
            )
            np.testing.assert_array_equal(answer.ids, expected.ids)
            np.testing.assert_array_equal(answer.rows, expected.rows)
            ours, theirs = bound.effects, free.effects
            assert ours.unrefined_pairs == 0
            for name in ('broadphase_pairs', 'far_pairs', 'cached_pairs', 'narrowphase_pairs'):
                assert getattr(ours, name) == getattr(theirs, name), (step, name)
        rows = np.arange(1, 16)
        steps = rng.normal(0, 0.01, (15, 3))
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows] + steps)


def test_a_spent_budget_leaves_the_farther_pairs_at_certified_bounds():
    world = random_world(np.random.default_rng(1), 30)
    filters = filters_of(world)
    exact = by_ids(signed_distances(Engine(), world, filters, 'exact', math.inf))
    engine = Engine()
    answer = signed_distances(engine, world, filters, 'exact', math.inf, time_budget=NOTHING)
    assert len(answer.ids) == 435
    left = answer.rows[:, METHOD] == BOUND_ONLY
    assert np.count_nonzero(~left) == SHORTEST_BLOCK
    effects = engine.effects
    assert effects.unrefined_pairs == np.count_nonzero(left)
    assert effects.pairs_by_method['bound_only'] == np.count_nonzero(left)
    assert effects.narrowphase_pairs == effects.broadphase_pairs == 435
    for ids, row in by_ids(answer).items():
        assert abs(row[DISTANCE] - exact[ids][DISTANCE]) <= row[ERROR_BOUND] + 1e-9
        gap = row[WITNESS_A : WITNESS_A + 3] - row[WITNESS_B : WITNESS_B + 3]
        np.testing.assert_allclose(
            gap, row[DISTANCE] * row[NORMAL : NORMAL + 3], rtol=0, atol=1e-12
        )
    # Those that were refined have the least lower bounds of all.
    bounds = signed_distances(Engine(), world, filters, 'bound', math.inf).rows
    lowers = bounds[:, DISTANCE] - bounds[:, ERROR_BOUND]
    assert lowers[~left].max() <= lowers[left].min()


def test_a_scene_that_rests_becomes_sharp_and_then_costs_nothing():
    world = random_world(np.random.default_rng(2), 12)
    filters, engine = filters_of(world), Engine()
    expected = signed_distances(Engine(), world, filters, 'exact', math.inf)
    computed = 66  # the first time, from bounds or by a kernel
    for cycle in range(1, 20):
        answer = signed_distances(engine, world, filters, 'exact', math.inf, time_budget=NOTHING)
        effects = engine.effects
        sharp = min(66, cycle * SHORTEST_BLOCK)
        assert effects.unrefined_pairs == 66 - sharp
        # Who was refined before is not computed again.
        assert (effects.cached_pairs, effects.narrowphase_pairs) == (66 - computed, computed)
        if not effects.unrefined_pairs:
            break
        computed = min(SHORTEST_BLOCK, effects.unrefined_pairs)
    assert cycle == math.ceil(66 / SHORTEST_BLOCK)
    np.testing.assert_array_equal(answer.ids, expected.ids)
    np.testing.assert_allclose(
        answer.rows[:, DISTANCE], expected.rows[:, DISTANCE], rtol=0, atol=1e-9
    )
    assert (
        signed_distances(engine, world, filters, 'exact', math.inf, time_budget=NOTHING).rows
        is answer.rows
    )
    assert engine.effects.cached_pairs == 66


def test_a_pair_left_at_bounds_is_sharp_in_a_query_that_has_time():
    world = random_world(np.random.default_rng(3), 30)
    filters, engine = filters_of(world), Engine()
    for _ in range(3):
        shuffle(np.random.default_rng(4), world)
        signed_distances(engine, world, filters, 'exact', 0.3, time_budget=NOTHING)
        answer = signed_distances(engine, world, filters, 'exact', 0.3)
        expected = signed_distances(Engine(), world, filters, 'exact', 0.3)
        np.testing.assert_array_equal(answer.ids, expected.ids)
        np.testing.assert_allclose(
            answer.rows[:, DISTANCE], expected.rows[:, DISTANCE], rtol=0, atol=1e-9
        )
        assert BOUND_ONLY not in answer.rows[:, METHOD]


@pytest.mark.parametrize('cutoff', [0.0, 0.05, 0.3])
def test_no_pair_within_reach_is_missing(cutoff):
    world = random_world(np.random.default_rng(5), 60)
    filters = filters_of(world)
    within = signed_distances(Engine(), world, filters, 'exact', cutoff)
    for answer in (
        signed_distances(Engine(), world, filters, 'exact', cutoff, time_budget=NOTHING),
        signed_distances(Engine(), world, filters, 'bound', cutoff),
    ):
        assert by_ids(within).keys() <= by_ids(answer).keys()
        assert (answer.ids == np.unique(answer.ids, axis=0)).all()
        lowers = answer.rows[:, DISTANCE] - answer.rows[:, ERROR_BOUND]
        assert lowers.max() <= cutoff
        # And those that only may be within reach are few enough to be of use.
        assert len(answer.ids) < 3 * len(within.ids) + 20


@pytest.mark.parametrize(('level', 'seconds'), [('exact', NOTHING), ('bound', 0.0)])
def test_whoever_may_penetrate_is_reported_with_a_certified_depth(level, seconds):
    world = random_world(np.random.default_rng(6), 60)
    filters = filters_of(world)
    signed = by_ids(signed_distances(Engine(), world, filters, 'exact', math.inf))
    deep = signed_distances(Engine(), world, filters, 'exact', 0.0, penetrating=True)
    query = (world, filters, level)
    answers = [
        signed_distances(Engine(), *query, 0.0, True, seconds).penetrating(),
        signed_distances(Engine(), *query, 0.3, False, seconds).penetrating(),
    ]
    # Boxes prove some apart of whom nothing else is known; with a longer reach they are not asked.
    assert by_ids(deep).keys() <= by_ids(answers[0]).keys() <= by_ids(answers[1]).keys()
    apart = 0
    for answer in answers:
        for ids, row in by_ids(answer).items():
            depth, true = -row[DISTANCE], max(0.0, -signed[ids][DISTANCE])
            apart += true == 0.0
            assert depth > 0.0
            assert abs(depth - true) <= row[ERROR_BOUND] + 1e-9
            span = row[WITNESS_B : WITNESS_B + 3] - row[WITNESS_A : WITNESS_A + 3]
            assert span @ row[NORMAL : NORMAL + 3] == pytest.approx(depth, abs=1e-12)
    assert apart > 0  # it was a test of those too
    assert has_overlap(Engine(), world, filters, 'bound')


def test_what_moves_a_little_keeps_narrow_bounds():
    rng = np.random.default_rng(9)
    world = random_world(rng, 20, types=(1, 2, 3, 4, 5))
    engine, filters = Engine(), filters_of(world)
    query = (world, filters, 'exact', math.inf)
    signed_distances(engine, *query)
    rows, moved = np.arange(1, 21), 0.0
    for _ in range(10):
        steps = rng.uniform(-1e-4, 1e-4, (20, 3))
        moved += np.linalg.norm(steps, axis=1).max()
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows] + steps)
        answer = signed_distances(engine, *query, time_budget=NOTHING)
        truth = signed_distances(Engine(), *query)
        left = answer.rows[:, METHOD] == BOUND_ONLY
        assert np.count_nonzero(~left) == SHORTEST_BLOCK
        # As far as both bodies came, though most were never refined in between.
        assert answer.rows[:, ERROR_BOUND].max() <= 2.0 * moved + 1e-9
        off = abs(answer.rows[:, DISTANCE] - truth.rows[:, DISTANCE])
        assert (off <= answer.rows[:, ERROR_BOUND] + 1e-9).all()
        spans = (
            answer.rows[:, WITNESS_A : WITNESS_A + 3] - answer.rows[:, WITNESS_B : WITNESS_B + 3]
        )
        normals = answer.rows[:, NORMAL : NORMAL + 3]
        np.testing.assert_allclose(spans, answer.rows[:, [DISTANCE]] * normals, rtol=0, atol=1e-12)


def test_who_was_far_in_between_is_not_taken_for_near(monkeypatch):
    world = random_world(np.random.default_rng(10), 2, types=(4,))
    engine, filters = Engine(), filters_of(world)
    rows, home = np.arange(1, 3), world.p_PFs[1:3].copy()
    query = (world, filters)
    # The budget that leaves all pairs.
    monkeypatch.setattr(
        engine._steps.pace, 'spend', lambda distances, *rest: np.arange(len(distances))
    )
    for away, cutoff, seconds in ((0.0, 10.0, 0.0), (2.0, 0.5, 0.0), (0.3, 10.0, NOTHING)):
        world.set_poses(rows, world.R_PFs[rows], np.add(home, [[0, 0, 0], [away, 0, 0]]))
        answer = signed_distances(engine, *query, 'exact', cutoff, time_budget=seconds)
    assert engine.effects.unrefined_pairs == 1
    truth = signed_distances(Engine(), *query, 'exact', 10.0)
    (row,), (true,) = answer.rows, truth.rows
    assert abs(row[DISTANCE] - true[DISTANCE]) <= row[ERROR_BOUND] + 1e-9


def test_a_budget_that_is_ample_costs_nothing(monkeypatch):
    rng = np.random.default_rng(8)
    world = random_world(rng, 30)
    engine, filters = Engine(), filters_of(world)
    signed_distances(engine, world, filters, 'exact', 0.3, time_budget=PLENTY)
    monkeypatch.delattr(BudgetedAnswers, 'answer_within')
    for _ in range(3):
        shuffle(rng, world)
        signed_distances(engine, world, filters, 'exact', 0.3, time_budget=PLENTY)
        assert engine.effects.unrefined_pairs == 0


def test_blocks_grow_with_what_pairs_cost(monkeypatch):
    world = random_world(np.random.default_rng(7), 80, types=(1, 3))
    engine, filters, sizes = Engine(), filters_of(world), []
    answer = engine._steps.answer

    def watched(world, pairs, *rest, **keywords):
        if 'queue' not in keywords:
            sizes.append(len(pairs))
        return answer(world, pairs, *rest, **keywords)

    monkeypatch.setattr(engine._steps, 'answer', watched)
    signed_distances(engine, world, filters, 'exact', math.inf, time_budget=PLENTY)
    assert sizes[0] == SHORTEST_BLOCK
    assert max(sizes) == LONGEST_BLOCK
    assert sum(sizes) == 80 * 79 // 2
