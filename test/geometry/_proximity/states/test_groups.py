"""Bounds and groups of many states: never above the truth, and no near pair is missed."""

import math

import numpy as np
import pytest
from numba import njit
from oracles.engine_calls import signed_distances

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from drake_geom_ros.geometry._proximity.states.groups import (
    BoundedBodies,
    Groups,
    collect,
    groups_of,
    least_possible,
    plainly_apart,
    put_boxes,
)
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.world import FrameTable, GeometryTable, World
from truth.bodies.random_bodies import random_rotations

SIZES = {SPHERE: 1, BOX: 3, CAPSULE: 2, CYLINDER: 2, ELLIPSOID: 3}


@njit
def _bound(i, j, world):
    places = world_of(world)
    bodies = BoundedBodies(
        places.types,
        places.R_WGs,
        places.p_WGs,
        places.roundings,
        places.half_extents,
        places.outer,
    )
    return least_possible(i, j, bodies)


@njit
def _collected(groups, most, pairs, world, order, bounds):
    places = world_of(world)
    put_boxes(groups, places)
    return collect(groups, (0, groups.separations.size, -1), most, pairs, places, order, bounds)


@njit
def _plainly(groups, most, world, plain):
    groups = Groups(*groups)
    put_boxes(groups, world_of(world))
    for m in range(groups.separations.size):
        plain[m] = plainly_apart(groups, m, most)


@pytest.fixture(scope='module')
def crowd():
    """Return a world of thirty bodies that overlap, its pairs, and their exact distances."""
    rng = np.random.default_rng(9)
    types = np.array([*SIZES] * 6, dtype=np.int64)
    n = len(types)
    shapes = [rng.uniform(0.2, 1.0, SIZES[kind]) for kind in types.tolist()]
    frames = FrameTable(np.arange(n + 1), np.zeros(n + 1, dtype=np.int64))
    table = GeometryTable(
        ids=np.arange(n),
        frames=np.arange(1, n + 1),
        R_FGs=np.tile(np.eye(3), (n, 1, 1)),
        p_FGs=np.zeros((n, 3)),
        roundings=np.zeros((n, 2)),
        types=types,
        starts=np.cumsum([0, *map(len, shapes)], dtype=np.int64),
        pool=np.concatenate(shapes),
    )
    world, filters = World(frames, table), FilterState()
    for key in range(n):
        filters.add(key, key + 1, False)
    world.set_poses(np.arange(1, n + 1), random_rotations(rng, n), rng.uniform(-2, 2, (n, 3)))
    batch = signed_distances(Engine(), world, filters, 'exact', math.inf)
    return world, batch.ids, batch.rows[:, 0] + batch.rows[:, 10]


def test_the_bound_is_never_above_the_distance(crowd):
    world, pairs, most = crowd
    bounds = np.array([_bound(i, j, world.handle) for i, j in pairs.tolist()])
    assert (bounds <= most).all()
    deep = most < -0.1
    assert deep.sum() > 10
    # It tells something of bodies that overlap, too.
    assert (bounds[deep] > -2.0).all()


@pytest.mark.parametrize('most', [-0.2, 0.0, 0.5, math.inf])
def test_no_pair_within_reach_is_missed(crowd, most):
    world, pairs, largest = crowd
    some = np.random.default_rng(1).integers(0, 9, world.geometry_count)
    groups = groups_of(some, pairs)
    assert isinstance(groups, Groups)
    order, bounds = np.empty(len(pairs), dtype=np.int64), np.empty(len(pairs))
    count = _collected(groups, most, pairs, world.handle, order, bounds)
    assert len(set(order[:count].tolist())) == count
    wanted = np.flatnonzero(largest <= most)
    assert set(wanted.tolist()) <= set(order[:count].tolist())
    assert most < 1.0 or count == len(pairs)
    by_bound = [k for k in range(len(pairs)) if _bound(*pairs[k], world.handle) <= most]
    # Groups leave out pairs by their boxes only: none that its own bound leaves in.
    assert sorted(order[:count].tolist()) == by_bound


@pytest.mark.parametrize('most', [-0.2, 0.0, 0.5])
def test_what_is_plainly_apart_has_a_gap_that_says_so(crowd, most):
    world, pairs, _ = crowd
    groups = groups_of(np.arange(world.geometry_count), pairs)
    plain = np.zeros(len(groups.separations), dtype=np.bool_)
    _plainly(tuple(groups), most, world.handle, plain)
    assert (groups.separations[plain] > max(most, 0.0)).all()
    assert plain.any()
    assert not plain[groups.separations == 0.0].any()
