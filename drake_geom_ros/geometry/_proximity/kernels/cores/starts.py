"""Start directions of the search for the normal of a pair of cores.

The separation of supporting planes is largest along the normal, so of two guesses the one of the
larger separation is better. A hint is the normal of an earlier answer. Since poses may have
changed completely, a hint is used only if it is no worse than the line of centres.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import NORMAL
from drake_geom_ros.geometry._proximity.kernels.cores.ball_caps import ball_in_difference
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import support_points
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Difference, Overlap
from drake_geom_ros.geometry._proximity.kernels.cores.sums import likely_normal, width
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, scale, sub, unit
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined


@compiled
def along_centres(p: Vector) -> Vector:
    """Return the unit vector along p, or +x where p is 0."""
    n = unit(p)
    return n if dot(n, n) > 0.5 else (1.0, 0.0, 0.0)


@compiled
def hint_of(out: Floats, p: Vector) -> tuple[Vector, bool]:
    """Return (n, hinted): a unit vector out of A from the hint in a result row, or along p."""
    n = unit((-out[NORMAL], -out[NORMAL + 1], -out[NORMAL + 2]))
    if dot(n, n) > 0.5:
        return n, True
    return along_centres(p), False


@compiled
def separation_along(pair: CorePair, n: Vector) -> float:
    """Return the separation of the supporting planes along n, at most the signed distance."""
    a, b = support_points(pair, n, 0.0)
    return dot(sub(b, a), n)


@inlined
def start_of_sums(difference: Difference, p: Vector, n: Vector, hinted: bool) -> Vector:
    """Return the start direction for a difference of sums: a good hint n, or a likely normal."""
    terms, _, last, r_A, r_B = difference
    line, radius = along_centres(p), r_A + r_B
    if hinted and width(terms, last, radius, n) <= width(terms, last, radius, line):
        return n
    return likely_normal(difference, line)


@compiled
def narrower(pair: CorePair, n: Vector, narrow: Overlap) -> Overlap:
    """Return the overlap along n, or ``narrow`` if that is no wider or n is 0."""
    width = -separation_along(pair, n)
    return Overlap(width, n) if width < narrow.width and dot(n, n) > 0.5 else narrow


@inlined
def narrower_on_line(pair: CorePair, narrow: Overlap) -> Overlap:
    """Return the overlap along the line of the inner balls, or ``narrow`` if no wider."""
    return narrower(pair, unit(scale(-1.0, ball_in_difference(pair).centre)), narrow)


@inlined
def start_of_hulls(pair: CorePair, n: Vector, hinted: bool, noise: float) -> tuple[Overlap, bool]:
    """Return (narrow, overlap): the start direction for hulls, and whether they seem to overlap.

    EPA is expensive for hulls, so the line of centres is tried first: it may separate them.
    Without a hint this pays only if both bodies are hulls.
    """
    if pair.kind_A == CONVEX and pair.kind_B == CONVEX:
        narrow = Overlap(-separation_along(pair, n), n)
        if narrow.width > noise:
            narrow = narrower_on_line(pair, narrow)
        return narrow, narrow.width > noise
    if not hinted:
        # The width would take a fifth of the time of a point and a hull, and is not used.
        return Overlap(np.inf, n), False
    narrow = Overlap(-separation_along(pair, n), n)
    overlap = narrow.width > noise
    if overlap:
        line = along_centres(pair.p_AB)
        width = -separation_along(pair, line)
        if width < -noise:
            return Overlap(width, line), False
    return narrow, overlap
