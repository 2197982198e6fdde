"""The engine: which kernels it compiles, the order of A and B, levels, what it leaves out."""

import math

import numpy as np
import pytest
from oracles.engine_calls import has_overlap, signed_distances
from oracles.worlds import filters_of, geometry_table, random_rotations, random_world, shuffle

from drake_geom_ros.geometry._proximity.engine import engine as engines
from drake_geom_ros.geometry._proximity.engine import prepared
from drake_geom_ros.geometry._proximity.engine.engine import ACCURACY_LEVELS, Effects, Engine
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.kernels import addresses as kernel_table
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_DISTANCE
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import P_ACA, P_BCB
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World


def test_only_the_kernels_of_a_scene_are_compiled(monkeypatch):
    asked = []
    nothing = np.zeros_like(kernel_table.COMPILED_ROWS)
    monkeypatch.setattr(kernel_table, 'COMPILED_ROWS', nothing)
    monkeypatch.setattr(
        kernel_table, 'compiled_address', lambda kernel: asked.append(kernel.__name__) or 0
    )
    monkeypatch.setattr(kernel_table, 'ADDRESSES', kernel_table.ADDRESSES.copy())
    spheres = random_world(np.random.default_rng(0), 5, types=(SPHERE,))
    assert Engine().prepare(spheres) == ['closed_forms.spheres.sphere_sphere']
    assert asked == ['sphere_sphere']
    mixed = random_world(np.random.default_rng(1), 30, types=(1, 4))
    assert len(Engine().prepare(mixed)) == 2
    assert asked[1:] == ['sphere_cylinder', 'signed_distance_of_cores']


def test_kernels_are_asked_for_once_for_a_world_and_its_filters_and_bounds_need_none(monkeypatch):
    asked = []
    # As if none were there, so those that are compiled by now are asked for, too.
    nothing = np.zeros_like(kernel_table.COMPILED_ROWS)
    monkeypatch.setattr(kernel_table, 'COMPILED_ROWS', nothing)
    monkeypatch.setattr(prepared, 'COMPILED_ROWS', nothing)

    def compile_rows(rows):
        asked.append(1)
        names = kernel_table.compile_rows(rows)
        nothing[:] = False
        return names

    monkeypatch.setattr(prepared, 'compile_rows', compile_rows)
    world = random_world(np.random.default_rng(4), 6, types=(SPHERE,))
    engine, filters = Engine(), filters_of(world)
    for level, count in (('bound', 0), ('exact', 1), ('exact', 1), ('bound', 1), ('fast', 1)):
        signed_distances(engine, world, filters, level, math.inf)
        assert len(asked) == count


def test_who_has_all_kernels_asks_for_none(monkeypatch):
    world = random_world(np.random.default_rng(4), 6, types=(SPHERE,))
    filters = filters_of(world)
    signed_distances(Engine(), world, filters, 'exact', math.inf)
    for module in (engines, prepared):
        monkeypatch.setattr(module, 'compile_rows', lambda rows: pytest.fail('asked for kernels'))
    assert len(signed_distances(Engine(), world, filters, 'exact', math.inf).ids) == 15


def test_a_pair_in_either_order_is_the_same_with_roles_exchanged():
    rng = np.random.default_rng(2)
    for _ in range(20):
        kinds = rng.choice([1, 2, 3, 4, 5], 2)
        world = random_world(rng, 2, types=kinds, spread=0.3)
        engine = Engine()
        ((one,), (two,)) = (
            engine.distance_of_pair(world, np.array([pair]), 1e-9).rows
            for pair in ([0, 1], [1, 0])
        )
        assert one[DISTANCE] == pytest.approx(two[DISTANCE], abs=1e-9)
        for row in (one, two):
            gap = row[WITNESS_A : WITNESS_A + 3] - row[WITNESS_B : WITNESS_B + 3]
            np.testing.assert_allclose(
                gap, row[DISTANCE] * row[NORMAL : NORMAL + 3], rtol=0, atol=1e-12
            )
        if world.geometries.types[0] != world.geometries.types[1]:
            # Different types: the very same kernel call, so the same to rounding.
            np.testing.assert_array_equal(one[NORMAL : NORMAL + 3], -two[NORMAL : NORMAL + 3])
            np.testing.assert_allclose(
                one[WITNESS_A : WITNESS_A + 3], two[WITNESS_B : WITNESS_B + 3], rtol=0, atol=1e-15
            )


def test_witness_points_in_world_and_in_the_bodies_are_the_same_points():
    world = random_world(np.random.default_rng(8), 12)
    batch = signed_distances(Engine(), world, filters_of(world), 'exact', math.inf)
    for (id_A, id_B), row in zip(batch.ids, batch.rows, strict=True):
        for key, in_world, in_body in ((id_A, WITNESS_A, P_ACA), (id_B, WITNESS_B, P_BCB)):
            g = np.searchsorted(world.geometries.ids, key)
            p_W = world.p_WGs[g] + world.R_WGs[g] @ row[in_body : in_body + 3]
            np.testing.assert_allclose(p_W, row[in_world : in_world + 3], rtol=0, atol=1e-14)


def test_a_cutoff_changes_no_answer_within_it():
    world = random_world(np.random.default_rng(3), 40, types=(2, 4, 5))
    exact = signed_distances(Engine(), world, filters_of(world), 'exact', math.inf)
    cut = signed_distances(Engine(), world, filters_of(world), 'exact', 0.2)
    near = exact.rows[:, DISTANCE] <= 0.2
    assert 20 < near.sum() < len(near) - 20
    np.testing.assert_array_equal(cut.ids, exact.ids[near])
    np.testing.assert_array_equal(cut.rows, exact.rows[near])


def test_penetrating_pairs_are_those_of_negative_distance():
    world = random_world(np.random.default_rng(9), 60)
    engine, filters = Engine(), filters_of(world)
    everything = signed_distances(engine, world, filters, 'exact', math.inf)
    deep = signed_distances(engine, world, filters, 'exact', 0.0, penetrating=True)
    assert len(deep.ids) > 10
    np.testing.assert_array_equal(deep.ids, everything.penetrating().ids)
    assert has_overlap(engine, world, filters, 'exact')
    shuffle(np.random.default_rng(10), world, spread=50.0)
    assert not has_overlap(engine, world, filters, 'exact')


@pytest.mark.parametrize('balls', [True, False])
def test_has_overlap_stops_at_the_first(balls):
    """Where the balls inside the bodies show it no kernel runs at all."""
    world = random_world(np.random.default_rng(11), 60, spread=0.1)
    world.ball_radii[:] *= balls
    engine, filters = Engine(), filters_of(world)
    for _ in range(3):
        assert has_overlap(engine, world, filters, 'exact')
        assert engine.effects.narrowphase_pairs + engine.effects.cached_pairs == 1 - balls
        world.set_poses(np.array([1]), np.eye(3)[None], world.p_PFs[1:2] + 1e-6)


def test_filtered_pairs_reach_no_kernel():
    world = random_world(np.random.default_rng(4), 10)
    engine, filters = Engine(), filters_of(world)
    keys = tuple(world.geometries.ids.tolist())
    filters.apply([(FilterOperation.EXCLUDE_WITHIN, keys[:5], keys[:5])])
    batch = signed_distances(engine, world, filters, 'exact', math.inf)
    effects = engine.effects
    assert (effects.broadphase_pairs, effects.filtered_pairs) == (45, 10)
    assert effects.narrowphase_pairs == len(batch.ids) == 35
    assert not (batch.ids < world.geometries.ids[5]).all(axis=1).any()


def test_the_level_bound_runs_no_kernel():
    world = random_world(np.random.default_rng(5), 10)
    engine = Engine()
    rows = signed_distances(engine, world, filters_of(world), 'bound', math.inf).rows
    assert set(rows[:, METHOD]) == {BOUND_ONLY}
    assert engine.effects.pairs_by_method == {'bound_only': 45}
    assert ACCURACY_LEVELS == ('bound', 'fast', 'balanced', 'exact')


def test_who_rests_is_answered_from_the_last_result():
    world = random_world(np.random.default_rng(6), 20)
    engine, filters = Engine(), filters_of(world)
    first = signed_distances(engine, world, filters, 'exact', math.inf)
    assert engine.effects.narrowphase_pairs == 190
    # The very same arrays, which nobody can write to.
    assert signed_distances(engine, world, filters, 'exact', math.inf).rows is first.rows
    assert engine.effects.cached_pairs == 190
    with pytest.raises(ValueError, match='read-only'):
        first.rows[0, 0] = 1.0
    world.set_poses(np.array([1]), np.eye(3)[None], np.zeros((1, 3)))
    second = signed_distances(engine, world, filters, 'exact', math.inf)
    effects = engine.effects
    assert (effects.cached_pairs, effects.narrowphase_pairs) == (190 - 19, 19)
    still = (second.ids != world.geometries.ids[0]).all(axis=1)
    np.testing.assert_array_equal(second.rows[still], first.rows[still])
    # Another level than the last is not in the memory: no level answers by another's digits.
    coarse = Engine()
    signed_distances(coarse, world, filters, 'fast', math.inf)
    signed_distances(coarse, world, filters, 'exact', math.inf)
    assert coarse.effects.narrowphase_pairs == 190
    signed_distances(coarse, world, filters, 'balanced', math.inf)
    assert coarse.effects.narrowphase_pairs == 190


def test_who_cannot_have_come_near_is_not_looked_at():
    rng = np.random.default_rng(7)
    world = random_world(rng, 40)
    engine, filters = Engine(), filters_of(world)
    signed_distances(engine, world, filters, 'exact', 0.1)
    for _ in range(5):
        rows = np.arange(1, 41)
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows] + rng.normal(0, 1e-4, (40, 3)))
        signed_distances(engine, world, filters, 'exact', 0.1)
    effects = engine.effects
    assert effects.far_pairs > 20
    total = effects.far_pairs + effects.cached_pairs + effects.narrowphase_pairs
    assert effects.broadphase_pairs == effects.filtered_pairs + total


def test_points_meet_what_is_within_reach():
    rng = np.random.default_rng(6)
    world = random_world(rng, 30)
    points = rng.uniform(-1, 1, (20, 3))
    batch = Engine().point_distances(world, points, 0.3)
    everything = Engine().point_distances(world, points, math.inf)
    assert len(everything.rows) == 600
    near = everything.rows[:, POINT_DISTANCE] <= 0.3
    np.testing.assert_array_equal(batch.rows, everything.rows[near])
    np.testing.assert_array_equal(batch.points, everything.points[near])
    np.testing.assert_array_equal(batch.ids, everything.ids[near])


def test_an_answer_that_stands_tells_its_own_pairs_after_points_were_asked():
    world = random_world(np.random.default_rng(6), 20)
    engine, filters = Engine(), filters_of(world)
    signed_distances(engine, world, filters, 'exact', math.inf)
    engine.point_distances(world, np.zeros((3, 3)), math.inf)
    effects = engine.effects
    assert (effects.broadphase_pairs, effects.near_list_made) == (3 * 20, False)
    assert effects.seconds['filter'] == effects.seconds['cache'] == 0.0
    signed_distances(engine, world, filters, 'exact', math.inf)
    effects = engine.effects
    assert (effects.broadphase_pairs, effects.cached_pairs) == (190, 190)


def test_pairs_see_the_poses_that_points_were_asked_in():
    rng = np.random.default_rng(9)
    world = random_world(rng, 20)
    engine, filters = Engine(), filters_of(world)
    for _ in range(3):
        found = signed_distances(engine, world, filters, 'exact', 0.2)
        expected = signed_distances(Engine(), world, filters, 'exact', 0.2)
        np.testing.assert_array_equal(found.ids, expected.ids)
        before = world.revision
        world.set_poses(np.array([1]), random_rotations(rng, 1), rng.uniform(-0.5, 0.5, (1, 3)))
        engine.point_distances(world, np.zeros((1, 3)), 0.1)
        assert world.revision == before + 1


def test_points_see_the_poses_of_now_in_whatever_world_they_are_asked():
    """Of two worlds in turn, and of more points, whose room is larger, before fewer."""
    rng = np.random.default_rng(8)
    worlds, engine = [random_world(rng, count) for count in (30, 5)], Engine()
    for count in (40, 2, 3):
        for world in worlds:
            frames = np.arange(1, world.geometry_count + 1)
            world.set_poses(
                frames, random_rotations(rng, len(frames)), rng.uniform(-1, 1, (len(frames), 3))
            )
            points = rng.uniform(-1, 1, (count, 3))
            batch = engine.point_distances(world, points, 0.5)
            assert engine.effects.geometries_updated == world.geometry_count
            fresh = Engine().point_distances(world, points, 0.5)
            for array, expected in zip(batch, fresh, strict=True):
                np.testing.assert_array_equal(array, expected)
            assert engine.effects.far_pairs == count * world.geometry_count - len(batch.ids)


def test_two_half_spaces_are_left_out():
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [HALF_SPACE, HALF_SPACE], [[], []]))
    world.set_poses(np.array([1, 2]), random_rotations(np.random.default_rng(7), 2), np.eye(2, 3))
    for distance in (0.1, math.inf):
        batch = signed_distances(Engine(), world, filters_of(world), 'exact', distance)
        assert len(batch.ids) == 0
    assert len(Engine().distance_of_pair(world, np.array([[0, 1]]), 1e-9).ids) == 0


def test_a_query_that_was_not_asked_has_no_effects():
    for name, value in vars(Effects()).items():
        assert not value, name


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_a_wider_question_before_leaves_no_trace(accuracy):
    """Who asked for more of the same poses gets what one gets who asks for the first time."""
    world = random_world(np.random.default_rng(0), 120, types=(1, 2, 3, 4), spread=0.6)
    filters, engine = filters_of(world), Engine()
    for cutoff in (math.inf, 0.3, 0.11, 0.1, 0.0, 0.1):
        found = signed_distances(engine, world, filters, accuracy, cutoff)
        alone = signed_distances(Engine(), world, filters, accuracy, cutoff)
        np.testing.assert_array_equal(found.ids, alone.ids)
        np.testing.assert_array_equal(found.rows, alone.rows)
