"""What leaves the engine: witness points in each frame, and the pairs that overlap."""

import math

import numpy as np
import pytest
from oracles.engine_calls import signed_distances
from oracles.worlds import filters_of, random_world

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CLOSED_FORM
from drake_geom_ros.geometry._proximity.pairs import answer_rows as batches
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PairBatch


def _three(row, at):
    return row[at : at + 3]


def test_witness_points_are_the_same_in_world_in_their_bodies_and_in_their_frames():
    world = random_world(np.random.default_rng(1), 6, types=(1, 2, 3))
    batch = signed_distances(Engine(), world, filters_of(world), 'exact', math.inf)
    assert len(batch.rows) == 15
    assert (batch.rows[:, UNIQUE] == 1.0).all()
    rows_of = {key: g for g, key in enumerate(world.geometries.ids.tolist())}
    for ids, row in zip(batch.ids, batch.rows, strict=True):
        a, b = (rows_of[key] for key in ids.tolist())
        for g, witness, in_body, in_frame in (
            (a, WITNESS_A, batches.P_ACA, batches.P_FACA),
            (b, WITNESS_B, batches.P_BCB, batches.P_FBCB),
        ):
            p_WC, f = _three(row, witness), world.geometries.frames[g]
            expected = world.R_WGs[g].T @ (p_WC - world.p_WGs[g])
            assert _three(row, in_body) == pytest.approx(expected, abs=1e-14)
            expected = p_WC - world.p_WFs[f]
            assert _three(row, in_frame) == pytest.approx(expected, abs=1e-14)
        apart = _three(row, WITNESS_A) - _three(row, WITNESS_B)
        assert apart == pytest.approx(row[DISTANCE] * _three(row, NORMAL), abs=1e-14)


def test_an_answer_is_one_array_that_nobody_changes_with_the_ids_at_its_end():
    world = random_world(np.random.default_rng(2), 40, types=(1,))
    engine, query = Engine(), (filters_of(world), 1e-9, math.inf, False, ANSWERS)
    for _ in range(2):  # with too little room at first, then with enough
        world.set_poses(np.array([1]), np.eye(3)[None], world.p_PFs[1:2] + 0.1)
        answers = engine.answer_of(engine.prepared(world, *query))
        batch = batches.batch_of(answers)
        assert answers.shape == (40 * 39 // 2, batches.ANSWER_WIDTH)
        keys = world.geometries.ids.tolist()
        assert batch.ids.tolist() == [[a, b] for a in keys for b in keys if a < b]
        assert np.shares_memory(batch.ids, answers)
        for array in (answers, batch.ids):
            with pytest.raises(ValueError, match='read-only'):
                array[0, 0] = 0


def test_only_what_overlaps_penetrates_and_an_interval_becomes_a_depth():
    rows = np.zeros((4, batches.BATCH_WIDTH))
    rows[:, DISTANCE] = -0.25, 0.5, 0.25, -0.5
    rows[:, ERROR_BOUND] = 1e-15, 0.25, 0.5, 0.25
    rows[:, METHOD] = CLOSED_FORM, BOUND_ONLY, BOUND_ONLY, BOUND_ONLY
    rows[:, batches.OVERLAPS] = 1.0, 0.0, 1.0, 1.0
    rows[:, NORMAL] = 1.0
    found = PairBatch(np.arange(8).reshape(4, 2), rows).penetrating()
    np.testing.assert_array_equal(found.ids, [[0, 1], [4, 5], [6, 7]])
    np.testing.assert_array_equal(found.rows[[0, 2]], rows[[0, 3]])
    # From -0.25 to 0.75: half of the largest depth, and as far as to the other end.
    depth = found.rows[1]
    assert depth[DISTANCE] == -0.125
    assert depth[ERROR_BOUND] == pytest.approx(0.875, rel=1e-14)
    assert depth[ERROR_BOUND] >= 0.875
    assert _three(depth, WITNESS_A)[0] - _three(depth, WITNESS_B)[0] == -0.125
