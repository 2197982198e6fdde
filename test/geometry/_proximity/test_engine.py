"""The engine: which kernels it compiles, the order of A and B, levels, what it leaves out."""

import math

import numpy as np
import pytest
from oracles.worlds import geometry_table, random_rotations, random_world

from drake_geom_ros.geometry._proximity import narrow_phase
from drake_geom_ros.geometry._proximity.engine import ACCURACY_LEVELS, Engine
from drake_geom_ros.geometry._proximity.filter_state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling import (
    BOUND_ONLY,
    DISTANCE,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.pair_table import HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.world import FrameTable, World


def filters_of(world):
    """Return filters that know the world's geometries, each on a frame of its own."""
    filters = FilterState()
    table = world.geometries
    for key, frame, anchored in zip(table.ids, table.frames, world.anchored, strict=True):
        filters.add(int(key), int(frame) + 100, bool(anchored))
    return filters


def test_only_the_kernels_of_a_scene_are_compiled(monkeypatch):
    asked = []
    nothing = np.zeros_like(narrow_phase._COMPILED)
    monkeypatch.setattr(narrow_phase, '_COMPILED', nothing)
    monkeypatch.setattr(
        narrow_phase, 'compiled_address', lambda kernel: asked.append(kernel.__name__) or 0
    )
    monkeypatch.setattr(narrow_phase, 'ADDRESSES', narrow_phase.ADDRESSES.copy())
    spheres = random_world(np.random.default_rng(0), 5, types=(SPHERE,))
    assert Engine().prepare(spheres) == ['spheres.sphere_sphere']
    assert asked == ['sphere_sphere']
    mixed = random_world(np.random.default_rng(1), 30, types=(1, 4))
    assert len(Engine().prepare(mixed)) == 2
    assert asked[1:] == ['sphere_cylinder', 'signed_distance_of_cores']


def test_a_pair_in_either_order_is_the_same_with_roles_exchanged():
    rng = np.random.default_rng(2)
    for _ in range(20):
        kinds = rng.choice([1, 2, 3, 4, 5], 2)
        world = random_world(rng, 2, types=kinds, spread=0.3)
        engine = Engine()
        ((one,), (two,)) = (
            engine.signed_distances(world, np.array([pair]), 'exact', math.inf).rows
            for pair in ([0, 1], [1, 0])
        )
        assert one[DISTANCE] == pytest.approx(two[DISTANCE], abs=1e-9)
        p_AB = world.p_WGs[1] - world.p_WGs[0]
        for row in (one, two):
            gap = row[WITNESS_A : WITNESS_A + 3] - row[WITNESS_B : WITNESS_B + 3]
            np.testing.assert_allclose(gap, row[DISTANCE] * row[NORMAL : NORMAL + 3], atol=1e-12)
        if world.geometries.types[0] != world.geometries.types[1]:
            # Different types: the very same kernel call, so the same to rounding.
            np.testing.assert_array_equal(one[NORMAL : NORMAL + 3], -two[NORMAL : NORMAL + 3])
            np.testing.assert_allclose(
                one[WITNESS_A : WITNESS_A + 3] - p_AB, two[WITNESS_B : WITNESS_B + 3], atol=1e-15
            )


def test_a_cutoff_changes_no_answer_within_it():
    world = random_world(np.random.default_rng(3), 40, types=(2, 4, 5))
    engine, filters = Engine(), filters_of(world)
    pairs = engine.candidates(world, filters, math.inf)
    exact = engine.signed_distances(world, pairs, 'exact', math.inf).rows
    cut = engine.signed_distances(world, pairs, 'exact', 0.2).rows
    near = exact[:, DISTANCE] <= 0.2
    assert 20 < near.sum() < len(pairs) - 20
    np.testing.assert_array_equal(cut[near], exact[near])
    assert (cut[~near, DISTANCE] > 0.2).all()


def test_filtered_pairs_reach_no_kernel():
    world = random_world(np.random.default_rng(4), 10)
    engine, filters = Engine(), filters_of(world)
    keys = tuple(world.geometries.ids.tolist())
    filters.apply([(1, keys[:5], keys[:5])])
    pairs = engine.candidates(world, filters, math.inf)
    assert len(pairs) == 45 - 10
    assert engine.effects.filtered_pairs == 10
    assert not ((pairs[:, 0] < 5) & (pairs[:, 1] < 5)).any()


def test_the_level_bound_runs_no_kernel():
    world = random_world(np.random.default_rng(5), 10)
    engine, filters = Engine(), filters_of(world)
    pairs = engine.candidates(world, filters, math.inf)
    rows = engine.signed_distances(world, pairs, 'bound', math.inf).rows
    assert set(rows[:, METHOD]) == {BOUND_ONLY}
    assert engine.effects.pairs_by_method == {'bound_only': 45}
    assert ACCURACY_LEVELS == ('bound', 'fast', 'balanced', 'exact')


def test_points_meet_what_is_within_reach():
    rng = np.random.default_rng(6)
    world = random_world(rng, 30)
    points = rng.uniform(-1, 1, (20, 3))
    batch = Engine().point_distances(world, points, 0.3)
    everything = Engine().point_distances(world, points, math.inf)
    assert len(everything.rows) == 600
    near = everything.rows[:, DISTANCE] <= 0.3
    np.testing.assert_array_equal(batch.rows, everything.rows[near])
    np.testing.assert_array_equal(batch.points, everything.points[near])
    np.testing.assert_array_equal(batch.geometries, everything.geometries[near])


def test_two_half_spaces_are_left_out():
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [HALF_SPACE, HALF_SPACE], [[], []]))
    world.set_poses(np.array([1, 2]), random_rotations(np.random.default_rng(7), 2), np.eye(2, 3))
    engine = Engine()
    pairs = engine.candidates(world, filters_of(world), math.inf)
    assert len(engine.signed_distances(world, pairs, 'exact', math.inf).pairs) == 0
