"""Witness points on the faces of two cores at a known normal: the shares of held segments.

This is for an n whose h is least, or almost, but where Newton's method found no minimum. On a ring
of almost equal values it lacks curvature, and rounding may miss the narrow face that almost
parallel segments span.
"""

from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import clamp
from drake_geom_ros.geometry._proximity.kernels.cores.normals import (
    at_disk,
    held_line,
    held_sum,
    lean_on_disks,
    on_face,
    set_shares,
    share_out,
    slope_and_curvature,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LEAN_A,
    LEAN_B,
    LENGTH,
    SEGMENT,
    SHARE,
    ellipsoid_support,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS

TURNS = 4  # two suffice for two segments
INNER = 1.0 - EPS  # a share of 1 or -1 means that a segment is not held


@compiled
def settle(difference: Difference, n: Vector) -> None:
    """Set the shares at n that minimise the sideways deviation of the extreme points."""
    terms, _, last, r_A, r_B = difference
    for k in range(3):
        terms[LEAN_A, k] = terms[LEAN_B, k] = 0.0
    set_shares(terms, last, n)
    e, reach, flat = held_line(terms, last)
    if flat or at_disk(terms, n, AXES_A) or at_disk(terms, n, AXES_B):
        on_face(terms, last, r_A + r_B, n, flat)
    elif reach > 0.0:
        f = unit(cross(n, e))
        _, x, _, _, _, _ = slope_and_curvature(terms, last, r_A + r_B, cross(e, f), e, f)
        share_out(terms, last, e, min(max(-x / reach, -1.0), 1.0))


@compiled
def settle_by_turns(difference: Difference, n: Vector, noise: float) -> None:
    """Set the shares as ``settle`` does, for almost parallel segments and where it fails.

    The face that such segments span is narrow, and rounding may put the foot of the origin beside
    it. The two segments that span most are solved together, then each in turn balances the
    remainder, and disks the rest. Segments whose ends are level within ``noise`` [m] are held,
    too.
    """
    terms, _, last, _, _ = difference
    for k in range(3):
        terms[LEAN_A, k] = terms[LEAN_B, k] = 0.0
    set_shares(terms, last, n)
    for k in range(SEGMENT, last):
        if abs(dot(vector_in(terms, k), n)) <= noise:
            terms[k, SHARE] = 0.0
    aside = add(
        held_sum(terms, last),
        add(ellipsoid_support(terms, AXES_A, n), ellipsoid_support(terms, AXES_B, n)),
    )
    aside = add_scaled(aside, -dot(aside, n), n)
    first, second, area = -1, -1, 0.0
    for i in range(SEGMENT, last):
        for j in range(i + 1, last):
            if abs(terms[i, SHARE]) < 1.0 and abs(terms[j, SHARE]) < 1.0:
                c = dot(cross(vector_in(terms, i), vector_in(terms, j)), n)
                if abs(c) > abs(area):
                    first, second, area = i, j, c
    if area != 0.0:
        s, t = vector_in(terms, first), vector_in(terms, second)
        terms[first, SHARE] = clamp(dot(cross(t, aside), n) / area, INNER)
        terms[second, SHARE] = clamp(dot(cross(aside, s), n) / area, INNER)
        aside = add_scaled(aside, terms[first, SHARE], s)
        aside = add_scaled(aside, terms[second, SHARE], t)
    for _ in range(TURNS):
        for k in range(SEGMENT, last):
            if abs(terms[k, SHARE]) < 1.0:
                s, before = vector_in(terms, k), terms[k, SHARE]
                more = -dot(aside, s) / (terms[k, LENGTH] * terms[k, LENGTH])
                terms[k, SHARE] = clamp(before + more, INNER)
                aside = add_scaled(aside, terms[k, SHARE] - before, s)
    lean_on_disks(terms, n, aside)
