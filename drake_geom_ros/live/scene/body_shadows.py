"""Shadows of bodies: places that a sensor cannot see because a body is before them.

A ray from the sensor to a place is traced by spheres (J. C. Hart, *Sphere tracing*, 1996): no
surface is nearer than the distance from the bodies, so the ray may go on by as much.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats, Indices

_STRIDE = 0.25  # [m] of a ray at once at most; bodies farther away are not looked at
_FINEST = 0.002  # [m] nearness to a body at which a ray counts as blocked, at least
_MOST_STEPS = 200  # of a ray; one that is not through by then counts as blocked
# How far [of the nearness that blocks] a ray may come nearer between two steps, unnoticed.
_UNNOTICED = 0.05

# Returns, for points (n, 3) [m] within a threshold [m] of bodies, the rows of the points and of
# the bodies, and lower bounds of the distances [m].
Distances = Callable[[Floats, float], Iterator[tuple[Indices, Indices, Floats]]]


class Balls(NamedTuple):
    """Balls around bodies (b,)."""

    centres: Floats  # (b, 3) [m]
    radii: Floats  # (b,) [m]


def are_in_shadow(
    distances: Distances, balls: Balls, origin: Floats, places: Floats, reach: float, noise: float
) -> Flags:
    """Return which places (n, 3) [m] a sensor at ``origin`` (3,) [m] cannot see.

    A place is in the shadow if the straight way to it, up to ``reach`` [m] before it, comes within
    ``noise`` [m] of a body. A body at the sensor itself, such as its housing, has no shadow.
    """
    near = max(noise, _FINEST)
    in_shadow = np.zeros(len(places), dtype=np.bool_)
    has_shadow = np.ones(len(balls.radii), dtype=np.bool_)
    for _, bodies, lower in distances(origin[np.newaxis], near):
        has_shadow[bodies[lower <= near]] = False
    ways = places - origin
    lengths = np.linalg.norm(ways, axis=1) - reach
    rays = np.flatnonzero(lengths > 0.0)
    directions = ways[rays] / np.linalg.norm(ways[rays], axis=1)[:, np.newaxis]
    starts, ends = _ball_spans(balls, has_shadow, origin, directions, near)
    ends = np.minimum(ends, lengths[rays])
    some = np.flatnonzero(starts < ends)
    rays, directions, done, ends = rays[some], directions[some], starts[some], ends[some]
    for _ in range(_MOST_STEPS):
        if not len(rays):
            return in_shadow
        gaps = np.full(len(rays), _STRIDE)
        points = origin + directions * done[:, np.newaxis]
        for rows, bodies, lower in distances(points, _STRIDE):
            counts = has_shadow[bodies]
            np.minimum.at(gaps, rows[counts], lower[counts])
        in_shadow[rays[gaps <= near]] = True
        done = done + gaps - (1.0 - _UNNOTICED) * near
        goes_on = (gaps > near) & (done < ends)
        rays, directions, done, ends = (
            rays[goes_on],
            directions[goes_on],
            done[goes_on],
            ends[goes_on],
        )
    in_shadow[rays] = True
    return in_shadow


def _ball_spans(
    balls: Balls, has_shadow: Flags, origin: Floats, directions: Floats, near: float
) -> tuple[Floats, Floats]:
    """Return where [m] rays (n,) come near a ball first and last; inf and 0: they do not."""
    starts, ends = np.full(len(directions), np.inf), np.zeros(len(directions))
    for k in np.flatnonzero(has_shadow):
        radius = balls.radii[k] + near
        if not np.isfinite(radius):
            return np.zeros(len(directions)), np.full(len(directions), np.inf)
        p_OC = balls.centres[k] - origin
        middle = directions @ p_OC
        inside = radius * radius - (p_OC @ p_OC - middle * middle)
        half = np.sqrt(np.maximum(inside, 0.0))
        meets = (inside >= 0.0) & (middle + half >= 0.0)
        first = np.maximum(middle - half, 0.0)
        starts = np.where(meets, np.minimum(starts, first), starts)
        ends = np.where(meets, np.maximum(ends, middle + half), ends)
    return starts, ends
