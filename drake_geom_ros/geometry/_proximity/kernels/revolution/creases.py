"""Depth of a box or capsule in a cylinder, by a complete search of all possible normals.

The support function h of the Minkowski difference D of two overlapping cores (see ``sums``) has a
local minimum at n only where no radius of curvature of D is below h(n): a radius rho along some
great circle through n makes ``h'' = rho - h`` there. If n is normal to no segment and not along
the axis of the disk, only the disk is curved, and only along one direction: across it rho is 0 and
h is positive, so n is no minimum. The remaining normals are on

- a *crease*: n normal to a segment. The whole circle of each segment is searched (see
  ``circles``), including its crossings with other circles, which are the faces of two segments;
- a *face of a disk*: n along its axis, where h is known (``likely_normal``).

The least of these is the depth. Rounding cannot exclude a candidate: the comparisons in
``circles`` retain doubtful ones.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.normals import NOTHING
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Least, Minimum
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    SEGMENT,
    likely_normal,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import (
    ARC_WIDTH,
    KINK_WIDTH,
    MOST_ARCS,
    MOST_KINKS,
    Best,
    chord_of_cap,
    improved,
    least_on_circle,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot, scale, unit, vector_in
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION


@compiled
def reach_across(terms: Floats, first: int, last: int, axes: int, i: int) -> float:
    """Return a lower bound of the reach [m] of a core normal to its segment i.

    It holds from the core's centre along any such direction; its segments start at ``first``.
    """
    if terms[axes, LENGTH] > 0.0:
        radius = terms[axes, LENGTH]
        return radius if i == first else min(radius, terms[first, LENGTH])
    if last - first < 3:
        return 0.0
    least = math.inf
    for k in range(first, last):
        least = min(least, terms[k, LENGTH] if k != i else math.inf)
    return least


@compiled
def best_of_starts(difference: Difference, newton: Minimum, enough: float, noise: float) -> Best:
    """Return the ``Best`` among Newton's minimum, the line of centres, faces and axes."""
    terms, _, last, r_A, r_B = difference
    radius = r_A + r_B
    least = width(terms, last, radius, newton.n)
    line, n = unit(vector_in(terms, 0)), newton.n
    if dot(line, line) > 0.5 and width(terms, last, radius, line) < least:
        n = line
    n = likely_normal(difference, n)
    if newton.kind == NOTHING or n != newton.n:
        n, h, chord = improved(difference, n, width(terms, last, radius, n), enough, noise)
    else:
        h, chord = newton.h, chord_of_cap(difference, newton, enough)
    return Best(n, h, chord, True, h)


@allocating
def least_on_creases(
    difference: Difference, newton: Minimum, enough: float, noise: float
) -> Least:
    """Return the least h over all faces and creases.

    ``newton`` is the result of ``nearby_minimum`` for the difference, or any direction to start
    from. The search is not complete if the splitting of arcs was ended. If the cores overlap, h is
    positive and is the depth. No plane examined by ``depths.guarded`` is below it.
    """
    terms, first, last, r_A, r_B = difference
    best = best_of_starts(difference, newton, enough, noise)
    arcs, kinks = np.empty((MOST_ARCS, ARC_WIDTH)), np.empty((MOST_KINKS, KINK_WIDTH))
    complete = True
    for i in range(SEGMENT, last):
        e = scale(1.0 / terms[i, LENGTH], vector_in(terms, i))
        inner = reach_across(terms, SEGMENT, first, AXES_A, i)
        inner += reach_across(terms, first, last, AXES_B, i)
        done, best = least_on_circle(difference, e, best, inner, enough, noise, arcs, kinks)
        complete = complete and done
    n, h, _, unique, floor = best
    axes = AXES_A if terms[AXES_A, LENGTH] > 0.0 else AXES_B
    axis = unit(cross(vector_in(terms, axes), vector_in(terms, axes + 1)))
    for side in (-1.0, 1.0):
        m = scale(side, axis)
        if dot(m, n) < SAME_DIRECTION and width(terms, last, r_A + r_B, m) <= h + 2.0 * enough:
            unique = False
    return Least(complete, h, min(floor, h), n, unique)
