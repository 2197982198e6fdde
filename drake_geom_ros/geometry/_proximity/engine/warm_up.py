"""Warm-up: compile or load everything that cycles run, except kernels, before the first query.

Numba compiles a function on its first call, and some functions are first called in a second cycle
or when a body has moved far. So all of them are called once on three balls, at the level that
needs no kernel. ``compile_everything`` adds the kernels of all shapes.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from drake_geom_ros.geometry._proximity.derivatives.gradients import compile_derivatives
from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS, CANDIDATES, CONTACT
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.filters.matrix import count_lacking
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import compile_rows
from drake_geom_ros.geometry._proximity.kernels.pair_table import ALL_ROWS, POINT_KERNELS
from drake_geom_ros.geometry._proximity.near.by_grids import compile_by_grids
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import bound_pairs
from drake_geom_ros.geometry._proximity.points.point_phase import compile_point_kernels
from drake_geom_ros.geometry._proximity.points.point_query import are_allowed
from drake_geom_ros.geometry._proximity.points.sharing import shared_point_distances
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell, compilation
from drake_geom_ros.geometry._proximity.world.pose_rounding import shift_of
from drake_geom_ros.geometry._proximity.world.pose_rows import FRAME_POSES, POSE_WIDTH
from drake_geom_ros.geometry._proximity.world.world import FrameTable, GeometryTable, Named, World


def compile_everything(tell: Tell | None = None) -> list[str]:
    """Compile, or load from the cache, all that any scene needs; return the kernels' names."""
    warm_up(tell)
    with compilation(tell, 'points and derivatives of distances', 1, 1):
        world, engine = _warmed_scene()
        points = np.zeros((1, 3))
        are_allowed(points)
        engine.point_distances(world, points, 0.0)
        shared_point_distances(world, points, 0.0)
        compile_derivatives()
    with compilation(tell, 'large scenes', 1, 1):
        compile_by_grids()
        filters = FilterState()
        for key in world.geometries.ids.tolist():
            filters.add(key, key, False)
        count_lacking(*filters.matrix, filters.slots(world.geometries.ids), world.waiting)
    return compile_rows(np.arange(len(ALL_ROWS)), tell) + compile_point_kernels(
        POINT_KERNELS.keys(), tell
    )


def warm_up(tell: Tell | None = None) -> None:
    """Run some cycles on a small world, once per process."""
    with compilation(tell, 'what every query runs', 1, 1):
        _warmed_scene()


@functools.cache
def _warmed_scene() -> tuple[World, Engine]:
    count = 3
    frames = FrameTable(np.arange(1, count + 1), np.zeros(count, dtype=np.int64))
    table = GeometryTable(
        ids=np.arange(1, count + 1),
        frames=np.arange(count),  # the first geometry is anchored
        R_FGs=np.tile(np.eye(3), (count, 1, 1)),
        p_FGs=np.zeros((count, 3)),
        roundings=np.zeros((count, 2)),
        types=np.ones(count, dtype=np.int64),
        starts=np.arange(count + 1),
        pool=np.ones(count),
    )
    world, filters, engine = World(frames, table), FilterState(), Engine()
    for key in range(1, count + 1):
        filters.add(key, key, key == 1)
    for number in range(2):  # one is removed while the other is in the history
        filters.apply_transient([(FilterOperation.EXCLUDE_BETWEEN, (1,), (2,))], number)
    filters.remove_declaration(0)
    filters.filtered_pairs()
    filters.explain(1, 2)
    filters.filtered(1, 2)
    filters.remove_declaration(1)
    named = Named(frames.ids[1:], np.arange(1, count))
    for step in (0.1, 0.2, 0.2, 50.0):
        poses = np.tile([step, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (count - 1, 1))
        X_PFs = np.empty((count - 1, POSE_WIDTH))
        FRAME_POSES.call(named.ids, named.ids, poses, X_PFs)
        world.pose(named, X_PFs)
        world.copy()  # applies pending poses without a query
        world.pose(named, X_PFs)
        query = world, filters, math.inf
        for reach in (0.0, math.inf):
            engine.answer_of(engine.prepared(*query, reach, False, ANSWERS))
        engine.finds_overlap(engine.prepared(*query, 0.0, True, CONTACT))
        engine.candidates_of(engine.prepared(*query, 0.0, False, CANDIDATES))
    world.pose(named, X_PFs)
    world.update_shared()
    _leave_at_bounds(world, filters)
    engine.detailed = True  # so Python calls functions that otherwise only compiled code calls
    engine.answer_of(engine.prepared(world, filters, math.inf, 1.0, False, ANSWERS))
    engine.detailed = False
    shift_of(0.0, 0.0, 0.0, 0.0)
    return world, engine


def _leave_at_bounds(world: World, filters: FilterState) -> None:
    """Compile the step of a query whose time budget is spent, by running it."""
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters, math.inf)
    hits, counts = np.empty(len(near.pairs), dtype=np.int64), np.zeros(COUNTS, dtype=np.int64)
    query = math.inf, math.inf, False
    state = world.handle, world.revision
    bound_pairs(near.pairs, near.slots, near.memory, *state, query, hits, counts)
