"""Paths in joint space that hold every stop from every share of the present speed.

A stop from the share s of the present velocities v goes on at s v through the reaction time r and
brakes evenly within T(s). It covers ``v p(s)`` with ``p(s) = s (r + T(s) / 2)``, within the time
``r + T(s)``. All stops along a path from shares up to s visit its points up to ``v p(s)``. Each
point is visited latest by the stop that ends there: slower ones do not reach it, faster ones have
passed it. So one path over s, with ``r + T(s)`` as its time, holds all of them: where it is clear
up to s, so is each stop from there or slower, whatever approaches at a bounded speed meanwhile.

Where joints stop each by itself, or robots stop independently, joint j may be anywhere between
its value now and ``v_j p_j(s)``. That box is held by its middle and half its size.
"""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._stops.compiled import inlined
from drake_geom_ros.geometry._stops.profiles import (
    AGE,
    RADIUS,
    REACTION,
    VELOCITY,
    ProfileArrays,
    duration_at,
    reaction_of,
    time_at,
)
from drake_geom_ros.math.tolerances import SPLINE_ROUNDING

# Kinds of paths. Over the share: of stops along the path, and of boxes of columns that stop each
# by itself. Of the stop from the whole present speed over time [s]. Of the stop from a share:
# where it ends, and one box of all stops up to it.
ALONG, EACH, IN_TIME, AT_END, IN_BOX = 0, 1, 2, 3, 4
BOXES = 4  # edges of a path of boxes: on each one the largest of its boxes counts
MOST_EDGES = BOXES + 2  # beside one for each share of a profile

# Coefficients and bounds of ``JointPath.curves``.
_FIRST, _SECOND, _SPEED, _ACCELERATION, _SIZE, _ROUNDING = 0, 1, 5, 6, 7, 8


class Way(NamedTuple):
    """A path, as ``JointPath``, and the share, or the time [s], at each of its rows."""

    rows: Floats  # (e + 1, c)
    curves: Floats  # (e, CURVE_WIDTH, c)
    times: Floats  # (e + 1,)
    reached: Floats  # (e + 1,)


@inlined
def _put(
    way: Way, e: int, c: int, start: float, first: float, second: float, radius: float
) -> None:
    """Write ``start + s first + s^2 second`` for s from 0 to 1, within a radius, to an edge."""
    curves, end = way.curves, start + first + second
    speed, bend, size = abs(first), abs(second), abs(start)
    way.rows[e, c], way.rows[e + 1, c] = start, end
    curves[e, _FIRST, c], curves[e, _SECOND, c] = first, second
    curves[e, _SPEED, c] = max(speed, abs(first + 2.0 * second))
    curves[e, _ACCELERATION, c] = 2.0 * bend
    # No value turns back on its way, so that its ends bound it.
    curves[e, _SIZE, c] = max(size, abs(end)) + radius
    # A box around the path counts as rounding does: its values may be that far off.
    curves[e, _ROUNDING, c] = radius + SPLINE_ROUNDING * (size + speed + bend + radius)


@inlined
def _is_aged(profile: ProfileArrays) -> bool:
    """Return whether values of any column were measured before now."""
    columns = profile.columns
    for c in range(columns.shape[1]):
        if columns[AGE, c] != 0.0:
            return True
    return False


@inlined
def _put_shares(
    profile: ProfileArrays, span: tuple[float, float], parts: int, reached: Floats, row: int
) -> int:
    """Write shares from ``row`` on: the ends of equal parts of a span, and where times bend.

    Return the number of rows.
    """
    (first, last), shares, k, n = span, profile.shares, 0, row
    for part in range(parts + 1):
        share = last if part == parts else first + (last - first) * part / parts
        while k < shares.size and shares[k] < share:
            if n > row and shares[k] > reached[n - 1]:
                reached[n] = shares[k]
                n += 1
            k += 1
        reached[n] = share
        n += 1
    return n


@inlined
def _put_past(way: Way, values: Floats, profile: ProfileArrays) -> None:
    """Write the way that columns went since their values were measured, as the first edge."""
    columns = profile.columns
    for c in range(columns.shape[1]):
        begun = columns[VELOCITY, c] * columns[AGE, c]
        _put(way, 0, c, values[c], begun, 0.0, columns[RADIUS, c])


@inlined
def _put_stops(
    way: Way, each: bool, values: Floats, profile: ProfileArrays, first: int, last: int
) -> None:
    """Write the edges between rows, over their shares; ``each``: of boxes."""
    columns, reached = profile.columns, way.reached
    for e in range(first, last):
        s, width = reached[e], reached[e + 1] - reached[e]
        for c in range(columns.shape[1]):
            v, radius = columns[VELOCITY, c], columns[RADIUS, c]
            time = time_at(profile, s, c)
            longer = time_at(profile, reached[e + 1], c) - time
            on = columns[REACTION, c] + 0.5 * time
            start = v * columns[AGE, c] + v * (s * on)
            rise = v * (width * on + 0.5 * s * longer)
            bend = v * (0.5 * width * longer)
            if each:
                radius += 0.5 * abs(start + rise + bend)
                start, rise, bend = 0.5 * start, 0.5 * rise, 0.5 * bend
            _put(way, e, c, values[c] + start, rise, bend, radius)


@inlined
def put_path_over_shares(
    way: Way,
    each: bool,
    values: Floats,
    profile: ProfileArrays,
    span: tuple[float, float],
    parts: int,
) -> int:
    """Write the path of all stops over a span of shares; return its number of edges.

    ``each``: columns stop each by itself; the span is divided into ``parts``.
    """
    past = 0
    if not each and _is_aged(profile):
        past = 1
        _put_past(way, values, profile)
        way.reached[0] = 0.0
    count = _put_shares(profile, span, parts, way.reached, past)
    _put_stops(way, each, values, profile, past, count - 1)
    for r in range(past, count):
        way.times[r] = duration_at(profile, way.reached[r])
    if past:  # by now: those who approach have the reaction time
        way.times[0] = way.times[1]
    return count - 1


@inlined
def put_path_over_time(way: Way, values: Floats, profile: ProfileArrays) -> int:
    """Write the path of the stop from the whole present speed over time [s] from now on.

    Return its number of edges. All columns that move have one reaction time and one time to brake.
    """
    columns, reaction = profile.columns, reaction_of(profile)
    braking, e = duration_at(profile, 1.0) - reaction, 0
    way.times[0] = 0.0
    if _is_aged(profile):
        _put_past(way, values, profile)
        e = 1
        way.times[e] = 0.0
    if reaction > 0.0:
        for c in range(columns.shape[1]):
            v = columns[VELOCITY, c]
            now = values[c] + v * columns[AGE, c]
            _put(way, e, c, now, v * reaction, 0.0, columns[RADIUS, c])
        e += 1
        way.times[e] = reaction
    for c in range(columns.shape[1]):
        v = columns[VELOCITY, c]
        start = values[c] + v * (columns[AGE, c] + reaction)
        _put(way, e, c, start, v * braking, -0.5 * v * braking, columns[RADIUS, c])
    way.times[e + 1] = reaction + braking
    for r in range(e + 2):
        way.reached[r] = way.times[r]
    return e + 1


@inlined
def put_rest(way: Way, is_box: bool, values: Floats, profile: ProfileArrays, share: float) -> int:
    """Write the path that rests where the stop from a share ends, by then; return 1, its edges.

    ``is_box``: it is the box of all places on the way there, of each column by itself.
    """
    columns = profile.columns
    for c in range(columns.shape[1]):
        on = columns[REACTION, c] + 0.5 * time_at(profile, share, c)
        goes, radius = columns[VELOCITY, c] * (columns[AGE, c] + share * on), columns[RADIUS, c]
        if is_box:
            goes *= 0.5
            radius += abs(goes)
        _put(way, 0, c, values[c] + goes, 0.0, 0.0, radius)
    for r in range(2):
        way.times[r], way.reached[r] = duration_at(profile, share), share
    return 1
