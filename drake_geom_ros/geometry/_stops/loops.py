"""Compiled preparation of a check of the pairs of a stop, and its results."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.motion.arrays import (
    ACCELERATION,
    CLEAR,
    CONTACT,
    EDGE,
    EVALUATIONS,
    IGNORES,
    LOWER_BOUND,
    MIN_DISTANCE,
    MOST,
    MOST_APPROACH,
    MOST_APPROACHED,
    PAIR,
    QUICK,
    ROUNDING,
    SEEN_EDGE,
    SEEN_PAIR,
    SEEN_TIME,
    SIZE,
    SPEED,
    T0,
    T1,
    TIME_TOLERANCE,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.rates import prepare, rates_against
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Flags,
    Handle,
    Reals,
    Rows,
    taker,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS, LEAST_TIME_TOLERANCE, ROUNDED_UP
from drake_geom_ros.geometry._stops.compiled import compiled, inlined
from drake_geom_ros.geometry._stops.edges import (
    AT_END,
    EACH,
    IN_BOX,
    IN_TIME,
    Way,
    put_path_over_shares,
    put_path_over_time,
    put_rest,
)
from drake_geom_ros.geometry._stops.profiles import (
    AGE,
    REACTION,
    VELOCITY,
    ProfileArrays,
    duration_at,
    time_at,
)

_Curves: TypeAlias = Annotated[NDArray[np.float64], np.float64, (None, None)]
_FlagRows: TypeAlias = Annotated[NDArray[np.bool_], np.bool_, (None,)]

# Places of ``StopArrays.out``: the share up to which all is proved; certified clearance [m], -inf
# where not all is; the numbers of pairs that kernels answered, and of pairs beyond boxes; the pair
# that is not proved, or nearest, -1 for none, and the edge and the time where it is so.
SCALE, CLEARANCE, ANSWERED, LOOKED, PAIR_AT, EDGE_AT, TIME_AT = 0, 1, 2, 3, 4, 5, 6
OUT_WIDTH = 7
# Places of the measures of a stop: see ``measure_stop``.
TIME, DISTANCE, POINT_SPEED, TURN_SPEED = 0, 1, 2, 3
MEASURES = 4


class StopArrays(NamedTuple):
    """Arrays of looks at the pairs (m,) of a world with geometries (n,), moved by columns (c,)."""

    # The path along which pairs are checked, as in ``Way``.
    rows: Rows
    curves: _Curves
    times: Reals
    reached: Reals
    relative: _FlagRows  # (m, c) columns that move the bodies of a pair relative to each other
    # Results.
    near: Flags  # (n,) geometries of pairs beyond boxes
    busy: Flags  # (c,) columns that move them
    out: Reals  # (OUT_WIDTH,)


_stops_of = taker(StopArrays)


@inlined
def _choose(motion: MotionArrays, places: Indices, speeds: Floats, ages: Floats) -> None:
    """Choose the pairs at some places; geometries (n,) approach by themselves.

    They do so at ``speeds`` [m/s], and did for ``ages`` [s] already.
    """
    for k in range(motion.skipped.size):
        motion.skipped[k], motion.examined[k] = True, False
    most, most_before = 0.0, 0.0
    for r in range(places.size):
        k = places[r]
        speed, before = 0.0, 0.0
        for side in range(2):
            body = motion.pairs[k, side]
            if speeds[body] > 0.0:
                speed += speeds[body]
                before += speeds[body] * ages[body]
        motion.skipped[k] = False
        motion.approaches[k], motion.approached[k] = speed, before
        most, most_before = max(most, speed), max(most_before, before)
    motion.parameters[MOST_APPROACH], motion.parameters[MOST_APPROACHED] = most, most_before


@inlined
def _count_looked(motion: MotionArrays, places: Indices, arrays: StopArrays) -> int:
    """Flag the bodies of pairs beyond boxes, and the columns that move them; return how many."""
    for g in range(arrays.near.size):
        arrays.near[g] = False
    for c in range(arrays.busy.size):
        arrays.busy[c] = False
    count = 0
    for r in range(places.size):
        k = places[r]
        if not motion.examined[k]:
            continue
        count += 1
        for side in range(2):
            arrays.near[motion.pairs[k, side]] = True
        for c in range(arrays.busy.size):
            arrays.busy[c] = arrays.busy[c] or arrays.relative[k, c]
    return count


@compiled
def begin_look(
    handle: Handle,
    arrays_handle: Handle,
    path: tuple[int, float, float, int],
    values: Floats,
    profile: tuple[Floats, Floats, Floats],
    question: tuple[float, float, int],
    chosen: tuple[Indices, Floats, Floats],
) -> int:
    """Prepare a check of chosen pairs on a path; return the number of its edges.

    ``path`` is its kind, the first and the last share, and the number of parts between them; one
    at rest has the last share. ``values`` (c,) are those of columns, ``profile`` has the arrays of
    ``ProfileArrays``, ``question`` the margin [m], the resolution of shares and the most pairs
    that kernels may answer, 0 for any number. ``chosen`` are the places of the pairs, the speeds
    (n,) [m/s] of geometries by themselves, and the ages (n,) [s] of their poses.
    """
    motion, arrays = motions_of(handle), _stops_of(arrays_handle)
    brakes = ProfileArrays(profile[0], profile[1], profile[2])
    way = Way(arrays.rows, arrays.curves, arrays.times, arrays.reached)
    margin, resolution, most = question
    kind, first, last, parts = path
    places, speeds, ages = chosen
    _choose(motion, places, speeds, ages)
    motion.parameters[MIN_DISTANCE] = margin
    motion.flags[MOST], motion.flags[IGNORES], motion.flags[QUICK] = most, 0, 1
    if kind == IN_TIME:
        edges = put_path_over_time(way, values, brakes)
    elif kind == AT_END or kind == IN_BOX:
        edges = put_rest(way, kind == IN_BOX, values, brakes, last)
    else:
        edges = put_path_over_shares(way, kind == EACH, values, brakes, (first, last), parts)
    widest = 0.0
    for e in range(edges):
        widest = max(widest, way.reached[e + 1] - way.reached[e])
    tolerance = 0.5 * resolution / (widest if widest > 0.0 else 1.0)
    motion.parameters[TIME_TOLERANCE] = max(tolerance, LEAST_TIME_TOLERANCE)
    return edges


@compiled
def end_look(
    handle: Handle, arrays_handle: Handle, edges: int, verdict: int, places: Indices
) -> None:
    """Write the results of a check to ``out``, and what it looked at; see ``begin_look``."""
    motion, arrays = motions_of(handle), _stops_of(arrays_handle)
    reached, out = arrays.reached, arrays.out
    out[PAIR_AT], out[EDGE_AT] = motion.counts[SEEN_PAIR], motion.counts[SEEN_EDGE]
    out[TIME_AT], out[SCALE] = motion.outcome[SEEN_TIME], reached[edges]
    out[CLEARANCE] = motion.outcome[LOWER_BOUND]
    if verdict != CLEAR:
        edge, t = motion.counts[EDGE], motion.outcome[T0]
        out[PAIR_AT], out[EDGE_AT] = motion.counts[PAIR], edge
        out[TIME_AT] = motion.outcome[T1] if verdict == CONTACT else t
        out[SCALE], out[CLEARANCE] = reached[edge], -math.inf
        if t > 0.0:
            scale = reached[edge] + (reached[edge + 1] - reached[edge]) * t
            out[SCALE] = max(reached[edge], scale * (1.0 - EPS))  # rounded down
    out[ANSWERED] = motion.counts[EVALUATIONS]
    out[LOOKED] = _count_looked(motion, places, arrays)


@inlined
def _way_of(motion: MotionArrays, g: int) -> float:
    """Return how far [m] all points of a geometry go at most, by the rates that were prepared."""
    rates, reach = rates_against(motion, motion.on[g], 0), motion.reaches[g]
    way: float = (rates.speed + rates.speed_r * reach) * ROUNDED_UP
    if reach == 0.0 and rates.speed_r > 0.0:
        way = math.inf
    return way


@compiled
def ways_of_bodies(handle: Handle, sizes: Floats, ways: Floats, out: Floats) -> None:
    """Write how far [m] all points of geometries (n,) go at most while columns go ``ways`` (c,).

    Values of columns are no larger than ``sizes`` (c,) meanwhile. A half space that turns has
    points that go any way: infinity.
    """
    motion = motions_of(handle)
    for c in range(ways.size):
        motion.values[SPEED, c], motion.values[SIZE, c] = ways[c], sizes[c]
        motion.values[ACCELERATION, c] = motion.values[ROUNDING, c] = 0.0
    prepare(handle)
    for g in range(motion.on.size):
        out[g] = _way_of(motion, g)


@compiled
def measure_stop(
    handle: Handle,
    values: Floats,
    profile: tuple[Floats, Floats, Floats],
    share: float,
    moving: Booleans,
    turns: Floats,
    out: Floats,
) -> None:
    """Write the measures of a stop to ``out`` (MEASURES,).

    These are the time [s] and the way [m] of the longest stop that is known, and the fastest point
    [m/s] and turn [rad/s] at a share of the present speed. Ways and points are those of the
    geometries that ``moving`` (n,) flags, ``turns`` (c,) are as in ``turns_of``.
    """
    motion, brakes = motions_of(handle), ProfileArrays(profile[0], profile[1], profile[2])
    fastest, columns = brakes.shares[brakes.shares.size - 1], brakes.columns
    for place in range(out.size):
        out[place] = 0.0
    out[TIME] = duration_at(brakes, fastest)
    for c in range(values.size):
        v, size = columns[VELOCITY, c], abs(values[c])
        on = columns[REACTION, c] + 0.5 * time_at(brakes, fastest, c)
        way = abs(v * (columns[AGE, c] + fastest * on))
        # Values of columns that matter are known: those that are not, count as 0.
        motion.values[SIZE, c] = way if math.isnan(size) else size + way
        motion.values[SPEED, c] = way
        motion.values[ACCELERATION, c] = motion.values[ROUNDING, c] = 0.0
        out[TURN_SPEED] = max(out[TURN_SPEED], share * abs(v) * turns[c])
    prepare(handle)
    for g in range(moving.size):
        if moving[g]:
            out[DISTANCE] = max(out[DISTANCE], _way_of(motion, g))
    for c in range(values.size):
        motion.values[SPEED, c] = share * abs(columns[VELOCITY, c])
    prepare(handle)
    for g in range(moving.size):
        if moving[g]:
            out[POINT_SPEED] = max(out[POINT_SPEED], _way_of(motion, g))
