"""The promise of a level: what kernels aim for, and what a check of answers allows."""

import math

import numpy as np
import pytest
from oracles.engine_calls import signed_distances
from oracles.worlds import filters_of, geometry_table, random_world

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import DISTANCE, ERROR_BOUND
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PROMISED
from drake_geom_ros.geometry._proximity.pairs.error_bounds import (
    promised_error_bound,
    tolerance_of_pair,
)
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World


@pytest.mark.parametrize(
    ('radii', 'expected'), [((2.0, 3.0), 1e-9), ((0.5, 3.0), 0.5e-9), ((2.0, 0.01), 1e-11)]
)
def test_the_gap_is_relative_below_a_metre(radii, expected):
    assert tolerance_of_pair(1e-9, 0, 1, np.array(radii)) == pytest.approx(expected)
    # A larger error is wanted: it would save no time.
    assert tolerance_of_pair(0.1, 0, 1, np.array(radii)) == pytest.approx(expected)
    assert tolerance_of_pair(1e-12, 0, 1, np.array(radii)) == pytest.approx(1e-3 * expected)


def test_far_from_the_origin_and_far_apart_rounding_is_allowed_for():
    types, outer = np.array([SPHERE, HALF_SPACE, SPHERE]), np.array([1.0, math.inf, 1.0])
    p_WGs = np.array([[0.0, 0, 0], [0, 0, -1], [1e6, 0, 0]])
    roundings = np.array([[1e-15, 0.0], [0.0, 2e-15], [1e-8, 0.0]])  # radius and tilt
    scene = types, outer, p_WGs, roundings
    near = promised_error_bound(1e-9, 0, 1, *scene)
    assert 1e-9 < near < 1.001e-9
    far = promised_error_bound(1e-9, 0, 2, *scene)
    assert 3e-8 < far < 6e-8
    # The farther a body is from the origin of a half space, the more the turn of that counts.
    aside = p_WGs.copy()
    aside[0, 1] = 1e6
    more = promised_error_bound(1e-9, 0, 1, types, outer, aside, roundings)
    less = promised_error_bound(1e-9, 0, 1, types, outer, aside, roundings * [1.0, 0.0])
    assert more - less == pytest.approx(2e-15 * 1e6, rel=1e-5)
    # A length is promised as it is, to small bodies, too.
    small = promised_error_bound(1e-3, 0, 1, types, 0.01 * outer, p_WGs, roundings)
    assert small == pytest.approx(1e-3)


@pytest.mark.parametrize('level', LEVEL_GAPS)
@pytest.mark.parametrize('scale', [1e-3, 1.0, 1e3])
@pytest.mark.parametrize('offset', [0.0, 1e5])
def test_random_pairs_keep_it(level, scale, offset):
    world = random_world(np.random.default_rng(0), 30, types=(1, 2, 3, 4, 5), spread=0.5)
    table = world.geometries
    parameters = [scale * part for part in np.split(table.pool, table.starts[1:-1])]
    scaled = World(
        world.frames,
        geometry_table(table.frames, table.types, parameters, table.R_FGs, scale * table.p_FGs),
    )
    rows = np.arange(1, 31)
    scaled.set_poses(rows, world.R_PFs[rows], scale * world.p_PFs[rows] + offset)
    scaled.update()
    batch = signed_distances(Engine(), scaled, filters_of(scaled), level, math.inf)
    assert len(batch.rows) == 435
    assert not batch.broken().any()
    # The check is not idle: bounding volumes would not do, unless all is as small as the promise.
    loose = signed_distances(Engine(), scaled, filters_of(scaled), 'bound', math.inf)
    is_small = LEVEL_GAPS[level] > 0.1 * scale
    assert is_small or np.mean(loose.rows[:, ERROR_BOUND] > batch.rows[:, PROMISED]) > 0.7


def test_a_broken_promise_is_seen():
    world = random_world(np.random.default_rng(1), 4)
    batch = signed_distances(Engine(), world, filters_of(world), 'exact', math.inf)
    rows = batch.rows.copy()
    rows[0, ERROR_BOUND] = 2e-9
    rows[1, DISTANCE] = math.nan
    rows[2, ERROR_BOUND] = math.nan
    rows[3, DISTANCE] = math.inf
    assert batch._replace(rows=rows).broken().tolist() == [True] * 4 + [False] * 2


def test_bounds_alone_promise_nothing():
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [4, 4], [[0.1, 0.2], [0.1, 0.2]]))
    world.set_poses(np.array([1, 2]), np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 3)))
    batch = signed_distances(Engine(), world, filters_of(world), 'bound', math.inf)
    assert batch.rows[0, PROMISED] == math.inf
    assert not batch.broken().any()
