"""Signed distance of capsules to capsules and boxes: of a segment to a box, minus the radii.

The core of a capsule is a segment, and a segment is also a box without width and depth. So both
pairs are one problem: a segment ``c + t d, |t| <= half_length`` in the frame of a box with half
sizes h. The square of its distance is a convex, piecewise quadratic function of t alone. Its slope
is piecewise linear, with a break where the segment crosses the plane of a face. The root of the
slope needs no cases for pairs of features, and avoids the determinant with which the textbook
solution for two lines loses digits when they are nearly parallel.

Where segment and box overlap, the least translation is normal to a facet of their Minkowski
difference: a face of the box, or one of its edges crossed with the segment. Among equal ones, a
face precedes a crossed edge, and the lowest axis comes first, towards its positive side. Where
parallels face each other, the witness points are in the middle of the common part.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape, write
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import (
    along,
    clamp,
    excess,
    length_and_direction,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    column,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM, HALF_LENGTH, SHAPE_RADIUS
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    ALONG_AXIS,
    CLEAR_SEPARATION,
    CLOSED_FORM_ROUNDING,
    DISTINCT_NORMALS,
    RIGHT_ANGLE,
    SHORT_SEPARATION,
    TIE,
)


@compiled
def _slope(h: Vector, c: Vector, d: Vector, t: float, on_face: int) -> float:
    """Return half the slope of the squared distance at t, without the axis ``on_face``.

    Axes on a face within rounding contribute nothing either, because their rounding could exceed
    the small slopes of the others.
    """
    slope = 0.0
    for k in range(3):
        if k != on_face and d[k] != 0.0:
            along_d = t * d[k]
            beyond = c[k] + along_d - clamp(c[k] + along_d, h[k])
            if abs(beyond) > TIE * (abs(c[k]) + abs(along_d) + h[k]):
                slope += d[k] * beyond
    return slope


@compiled
def nearest_parameter(h: Vector, c: Vector, d: Vector, half_length: float) -> float:
    """Return the t [m] at which the segment c + t d is nearest to the box with half sizes h.

    If a whole part is equally near, or inside the box, it is the middle of that part.
    """
    d = (
        d[0] if abs(d[0]) > RIGHT_ANGLE else 0.0,
        d[1] if abs(d[1]) > RIGHT_ANGLE else 0.0,
        d[2] if abs(d[2]) > RIGHT_ANGLE else 0.0,
    )
    low, high = -half_length, half_length
    slope_low, slope_high = _slope(h, c, d, low, -1), _slope(h, c, d, high, -1)
    if slope_low > 0.0:
        return low
    if slope_high < 0.0:
        return high
    # The interval of slope 0 so far: empty while first > last.
    first, last = half_length, -half_length
    if slope_low == 0.0:
        first, last = low, low
    if slope_high == 0.0:
        first, last = min(first, high), high
    for k in range(3):
        if d[k] == 0.0:
            continue
        for face in (-h[k], h[k]):
            t = (face - c[k]) / d[k]
            if low < t < high:
                slope = _slope(h, c, d, t, k)
                if slope < 0.0:
                    low, slope_low = t, slope
                elif slope > 0.0:
                    high, slope_high = t, slope
                else:
                    first, last = min(first, t), max(last, t)
    if first <= last:
        return 0.5 * (first + last)
    return low - slope_low * ((high - low) / (slope_high - slope_low))


@compiled
def _axis(d: Vector, m: int) -> Vector:
    """Return candidate m of 6 separating axes: a unit vector, or 0 for none."""
    if m < 3:
        return along(m, 1.0)
    n = cross(along(m - 3, 1.0), d)
    sine = math.sqrt(dot(n, n))
    # Not needed, as for boxes (``boxes._axis``): a segment along an edge is a point in the cross
    # section, and turning it by so little is within CLOSED_FORM_ROUNDING.
    if sine <= RIGHT_ANGLE:
        return 0.0, 0.0, 0.0
    return scale(1.0 / sine, n)


@compiled
def _separation(
    h: Vector, c: Vector, d: Vector, half_length: float, n: Vector, slack: float
) -> tuple[float, float]:
    """Return the larger separation of box and segment along n and -n, and its sign."""
    side = -1.0 if dot(c, n) < -slack else 1.0
    box = h[0] * abs(n[0]) + h[1] * abs(n[1]) + h[2] * abs(n[2])
    return side * dot(c, n) - box - half_length * abs(dot(d, n)), side


@compiled
def _separating_axis(
    h: Vector, c: Vector, d: Vector, half_length: float, slack: float
) -> tuple[float, Vector, bool]:
    """Return the largest separation over 6 axes, its unit normal out of the box, uniqueness."""
    phi, n, tie = -math.inf, (1.0, 0.0, 0.0), False
    for m in range(6):
        axis = _axis(d, m)
        if dot(axis, axis) > 0.0:
            separation, side = _separation(h, c, d, half_length, axis, slack)
            if separation > phi + slack:
                tie = separation <= phi + 2.0 * slack
                phi, n = separation, scale(side, axis)
            elif separation >= phi - slack and norm(cross(axis, n)) > DISTINCT_NORMALS:
                tie = True
    return phi, n, not tie and abs(dot(c, n)) > slack


@compiled
def _turned(p_CaCb: Vector, d: Vector, slack: float) -> Vector:
    """Return p_CaCb made normal to d if that moves it only by rounding, else unchanged."""
    square = dot(d, d)
    if square <= RIGHT_ANGLE * RIGHT_ANGLE:
        return p_CaCb
    error = scale(dot(p_CaCb, d) / square, d)
    if norm(error) > min(4.0 * slack, 0.5 * norm(p_CaCb)):
        return p_CaCb
    return sub(p_CaCb, error)


@compiled
def _across(p_CaCb: Vector, p: Vector, h: Vector, d: Vector, slack: float) -> Vector:
    """Return p_CaCb from a box to p on a segment along d, made normal to d again.

    Rounding of up to ``slack`` [m] has turned a short vector. Coordinates in which p is between
    two faces are 0 and stay so; one in which p is on a face within rounding may leave it outwards.
    """
    free = (
        d[0] if abs(p[0]) >= h[0] - slack else 0.0,
        d[1] if abs(p[1]) >= h[1] - slack else 0.0,
        d[2] if abs(p[2]) >= h[2] - slack else 0.0,
    )
    turned = _turned(p_CaCb, free, slack)
    for k in range(3):
        if h[k] > slack and turned[k] * p[k] < 0.0:
            outside = (
                d[0] if p_CaCb[0] != 0.0 else 0.0,
                d[1] if p_CaCb[1] != 0.0 else 0.0,
                d[2] if p_CaCb[2] != 0.0 else 0.0,
            )
            return _turned(p_CaCb, outside, slack)
    return turned


@compiled
def segment_to_box(
    h: Vector, c: Vector, d: Vector, half_length: float, slack: float
) -> tuple[float, Vector, Vector, bool]:
    """Return (phi, n, p, unique) of a segment c + t d, |t| <= half_length, from a box.

    All in the box's frame; d is unit. phi [m] is the signed distance, n the unit normal out of the
    box, p the segment's witness point; p - phi n is the box's. ``slack`` [m] is the rounding of
    the coordinates.
    """
    t = nearest_parameter(h, c, d, half_length)
    p = add_scaled(c, t, d)
    p_CaCb = excess(h, p)
    distance, n = length_and_direction(p_CaCb)
    if distance > SHORT_SEPARATION * (half_length + norm(h)):
        return distance, n, p, True
    phi, axis, unique = _separating_axis(h, c, d, half_length, slack)
    apart, clear = distance > slack, distance > CLEAR_SEPARATION * slack
    aside = norm(sub(p_CaCb, scale(phi, axis)))
    if apart and aside > 4.0 * slack:
        if abs(t) < half_length or t * dot(p_CaCb, d) > 0.0:
            _, n = length_and_direction(_across(p_CaCb, p, h, d, slack))
        return distance, n, p, clear
    # The segment moved until it touches the box shares the witness point with it.
    moved = add_scaled(c, -phi, axis)
    t = nearest_parameter(h, moved, d, half_length)
    unique = unique and not (apart and aside > ALONG_AXIS * distance)
    return phi, axis, add_scaled(c, t, d), clear or unique


@compiled
def _write(
    out: Floats,
    R_WA: Floats,
    radius_A: float,
    h: Vector,
    radius_B: float,
    R_WB: Floats,
    half_length_B: float,
    p_AB_W: Floats,
) -> None:
    """Write the row of a box with half sizes h and a segment, each grown by its radius."""
    c = unrotate(R_WA, vector_at(p_AB_W, 0))
    d = unrotate(R_WA, column(R_WB, 2))
    extent = norm(h) + half_length_B + norm(c)
    phi, n, p, unique = segment_to_box(h, c, d, half_length_B, TIE * extent)
    p_ACa = add_scaled(p, radius_A - phi, n)
    p_ACb = add_scaled(p, -radius_B, n)
    write(
        out,
        phi - radius_A - radius_B,
        rotate(R_WA, scale(-1.0, n)),
        rotate(R_WA, p_ACa),
        rotate(R_WA, p_ACb),
        CLOSED_FORM_ROUNDING * (extent + radius_A + radius_B),
        unique,
        CLOSED_FORM,
    )


@compiled
def capsule_capsule(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of two capsules."""
    h = (0.0, 0.0, A.shape[HALF_LENGTH])
    radius_A, radius_B = A.shape[SHAPE_RADIUS], B.shape[SHAPE_RADIUS]
    _write(out, A.R_W, radius_A, h, radius_B, B.R_W, B.shape[HALF_LENGTH], p_AB_W)


@compiled
def box_capsule(A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats) -> None:
    """Write the signed distance of a box and a capsule."""
    h = vector_at(A.shape, 0)
    _write(out, A.R_W, 0.0, h, B.shape[SHAPE_RADIUS], B.R_W, B.shape[HALF_LENGTH], p_AB_W)
