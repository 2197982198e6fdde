"""What pairs cost at each level: which are sampled, and that each level answers just these."""

import math

import numpy as np
from oracles.engine_calls import signed_distances
from oracles.worlds import filters_of, random_world

from drake_geom_ros.geometry._proximity.engine.engine import ACCURACY_LEVELS, Engine
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CLOSED_FORM
from drake_geom_ros.geometry._proximity.pairs import level_costs
from drake_geom_ros.geometry._proximity.pairs.level_costs import LAPS, TRIALS, seconds_a_pair
from drake_geom_ros.geometry._proximity.pairs.slots import empty_memory
from drake_geom_ros.geometry._proximity.report import BY_METHOD


def test_every_level_and_one_centimetre_are_measured():
    world = random_world(np.random.default_rng(0), 20)
    costs, samples = seconds_a_pair(world, filters_of(world), math.inf, 64, 0)
    assert set(costs) == {*ACCURACY_LEVELS, '0.01'}
    assert samples == 64
    assert all(math.isfinite(cost) and cost > 0.0 for cost in costs.values())


def test_a_small_scene_is_its_own_sample_and_an_empty_one_has_none():
    world = random_world(np.random.default_rng(1), 4)
    assert seconds_a_pair(world, filters_of(world), math.inf, 64, 0)[1] == 6
    nobody = random_world(np.random.default_rng(1), 1)
    assert seconds_a_pair(nobody, filters_of(nobody), math.inf, 64, 0) == ({}, 0)
    apart = random_world(np.random.default_rng(2), 4, spread=1e3)
    assert seconds_a_pair(apart, filters_of(apart), 0.1, 64, 0) == ({}, 0)


def test_only_unfiltered_pairs_within_reach_are_computed_cold(monkeypatch):
    world = random_world(np.random.default_rng(3), 60, types=(1, 3))
    filters = filters_of(world)
    keys = tuple(world.geometries.ids.tolist())
    filters.apply([(FilterOperation.EXCLUDE_WITHIN, keys[:30], keys[:30])])
    calls = []
    answer = level_costs.answer_pairs

    def watched(addresses, pairs, slots, memory, scene, revision, query, first, *rest):
        np.testing.assert_array_equal(memory, empty_memory(len(pairs)))
        found = answer(addresses, pairs, slots, memory, scene, revision, query, first, *rest)
        calls.append((query, pairs, rest[-1].copy()))
        return found

    monkeypatch.setattr(level_costs, 'answer_pairs', watched)
    _, samples = seconds_a_pair(world, filters, 0.1, 16, 7)
    assert samples == 16
    measured = calls[1:]
    levels = [math.inf, 1e-2, 1e-3, 1e-6, 1e-9]
    assert [query[0] for query, _, _ in measured] == np.repeat(levels, TRIALS).tolist()
    for number, (_, pairs, counts) in enumerate(measured):
        np.testing.assert_array_equal(pairs, measured[0][1])
        assert len(pairs) == 16 * LAPS
        assert not (pairs < 30).all(axis=1).any()
        # Spheres and capsules: each pair was computed, by the kernel that the level has.
        method = BOUND_ONLY if number < TRIALS else CLOSED_FORM
        assert counts[BY_METHOD + method] == 16 * LAPS


def test_the_seed_chooses():
    rng = np.random.default_rng
    pairs = np.argwhere(np.tri(40, k=-1))
    one, two = (level_costs._some(rng(seed), pairs, 10) for seed in (0, 1))
    np.testing.assert_array_equal(one, level_costs._some(rng(0), pairs, 10))
    assert (one != two).any()
    assert len(level_costs._some(rng(0), pairs, 10_000)) == len(pairs)


def test_an_engine_that_answers_the_world_keeps_what_it_knows():
    world = random_world(np.random.default_rng(5), 20)
    engine, filters = Engine(), filters_of(world)
    first = signed_distances(engine, world, filters, 'exact', math.inf)
    seconds_a_pair(world, filters, math.inf, 64, 0)
    assert signed_distances(engine, world, filters, 'exact', math.inf).rows is first.rows


def test_a_pair_costs_its_share_of_the_quickest_trial(monkeypatch):
    world = random_world(np.random.default_rng(6), 4)
    answer, seconds = level_costs._answer, iter(np.arange(1.0, 1000.0)[::-1])
    monkeypatch.setattr(level_costs, '_answer', lambda *a: (next(seconds), answer(*a)[1]))
    costs, samples = seconds_a_pair(world, filters_of(world), math.inf, 64, 0)
    quickest = [999.0 - TRIALS * (k + 1) for k in range(len(costs))]  # the first asks for pairs
    assert list(costs.values()) == [each / (samples * LAPS) for each in quickest]
