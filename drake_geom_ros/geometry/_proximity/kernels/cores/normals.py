"""Normal of a contact by Newton's method: a local minimum of the support function.

At the distance or depth of two cores, the support function h of their Minkowski difference D (see
``sums``) has a local minimum on the sphere of directions. There the point of D extreme along n is
on the line of n itself. Its deviation from that line is the gradient of h, and ``M - h`` is the
Hessian, where M are the radii of curvature of D. Newton's method doubles the digits of n at each
step. A step that would cross a kink stops on it, and continues along it until the subgradient
shows that the minimum is elsewhere. Where h is not convex, there is no minimum before the next
kink, and the step descends to that. There are three kinds of minima:

- SMOOTH;
- CREASE, with parallel segments held and n on a circle;
- FLAT, on a face of D that contains the foot of the origin.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Minimum
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LEAN_A,
    LEAN_B,
    LENGTH,
    SEGMENT,
    SHARE,
    curvature,
    ellipsoid_support,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    ALMOST_RIGHT_ANGLE,
    LAST_STEP,
    LOOSE_SLOPE,
    RIGHT_ANGLE,
)

# Kinds of minima.
NOTHING = 0
SMOOTH = 1
CREASE = 2
FLAT = 3

STEPS = 16  # 3 to 6 are usual, some more where kinks are met
ZERO = (0.0, 0.0, 0.0)
LONGEST_STEP = 0.5  # tangent of the angle


@inlined
def nowhere(n: Vector) -> Minimum:
    """Return a record without a minimum, with only a direction to start from."""
    return Minimum(NOTHING, n, math.inf, 0.0)


@compiled
def set_shares(terms: Floats, last: int, n: Vector) -> None:
    """Set the shares of the segments at n: 1 or -1 for an end, 0 for segments normal to n."""
    for k in range(SEGMENT, last):
        d = dot(vector_in(terms, k), n)
        terms[k, SHARE] = 0.0
        if abs(d) > RIGHT_ANGLE * terms[k, LENGTH]:
            terms[k, SHARE] = 1.0 if d > 0.0 else -1.0


@compiled
def onto_kink(difference: Difference, n: Vector) -> Vector:
    """Return n, made normal to a segment to which it is almost normal."""
    terms, _, last, _, _ = difference
    for k in range(SEGMENT, last):
        d = dot(vector_in(terms, k), n) / terms[k, LENGTH]
        if abs(d) <= ALMOST_RIGHT_ANGLE:
            return unit(add_scaled(n, -d / terms[k, LENGTH], vector_in(terms, k)))
    return n


@compiled
def held_line(terms: Floats, last: int) -> tuple[Vector, float, bool]:
    """Return (e, reach, flat): direction, half length of held segments; flat if not parallel."""
    e, reach, flat = (0.0, 0.0, 0.0), 0.0, False
    for k in range(SEGMENT, last):
        if terms[k, SHARE] == 0.0:
            d = scale(1.0 / terms[k, LENGTH], vector_in(terms, k))
            if reach == 0.0:
                e = d
            flat = flat or norm(cross(d, e)) > RIGHT_ANGLE
            reach += terms[k, LENGTH]
    return e, reach, flat


@compiled
def free_segments(terms: Floats, last: int, e: Vector, slope: float) -> None:
    """Release held segments to the end that lowers h against a slope along e."""
    for k in range(SEGMENT, last):
        if terms[k, SHARE] == 0.0:
            terms[k, SHARE] = -1.0 if slope * dot(vector_in(terms, k), e) > 0.0 else 1.0


@compiled
def held_sum(terms: Floats, last: int) -> Vector:
    """Return the sum of -p and the segments times their shares."""
    base = scale(-1.0, vector_in(terms, 0))
    for k in range(SEGMENT, last):
        base = add_scaled(base, terms[k, SHARE], vector_in(terms, k))
    return base


@compiled
def part_before_kink(terms: Floats, last: int, n: Vector, step: Vector) -> tuple[float, bool]:
    """Return (part, crossed) of a step up to the first kink, and hold the kink's segments."""
    part, first = 1.0, -1
    for k in range(SEGMENT, last):
        here = max(terms[k, SHARE] * dot(vector_in(terms, k), n), 0.0)
        change = terms[k, SHARE] * dot(vector_in(terms, k), step)
        if terms[k, SHARE] != 0.0 and here + part * change < 0.0:
            part, first = here / -change, k
    if first >= 0:
        terms[first, SHARE] = 0.0
        for k in range(SEGMENT, last):
            there = dot(vector_in(terms, k), add_scaled(n, part, step))
            if abs(there) <= RIGHT_ANGLE * terms[k, LENGTH]:
                terms[k, SHARE] = 0.0
    return part, first >= 0


@compiled
def at_disk(terms: Floats, n: Vector, axes: int) -> bool:
    """Return whether n is along the axis of the disk in row ``axes``."""
    return (
        terms[axes, LENGTH] > 0.0
        and norm(
            (
                dot(vector_in(terms, axes), n),
                dot(vector_in(terms, axes + 1), n),
                dot(vector_in(terms, axes + 2), n),
            )
        )
        <= RIGHT_ANGLE * terms[axes, LENGTH]
    )


@compiled
def face_normal(terms: Floats, last: int, n: Vector) -> Vector:
    """Return the unit normal, on the side of n, of two held segments or of a disk at its axis.

    It is n itself where segments are parallel within rounding, despite the test that held both.
    """
    best, m = 0.0, n
    for i in range(SEGMENT, last):
        for j in range(i + 1, last):
            if terms[i, SHARE] == 0.0 and terms[j, SHARE] == 0.0:
                c = cross(vector_in(terms, i), vector_in(terms, j))
                area = norm(c)
                sine = area / (terms[i, LENGTH] * terms[j, LENGTH])
                if sine > best:
                    best, m = sine, scale(1.0 / area, c)
    if best <= RIGHT_ANGLE and (at_disk(terms, n, AXES_A) or at_disk(terms, n, AXES_B)):
        axes = AXES_A if at_disk(terms, n, AXES_A) else AXES_B
        m = unit(cross(vector_in(terms, axes), vector_in(terms, axes + 1)))
    return m if dot(m, n) > 0.0 else scale(-1.0, m)


@compiled
def shares_on_face(terms: Floats, last: int, n: Vector, x: Vector) -> float:
    """Choose shares of two held segments that balance x in the face of n; return the margin.

    If they cannot, the margin is -1, and a segment that would have to be longer is released.
    """
    first, second, area = -1, -1, 0.0
    for i in range(SEGMENT, last):
        for j in range(i + 1, last):
            if terms[i, SHARE] == 0.0 and terms[j, SHARE] == 0.0:
                c = dot(cross(vector_in(terms, i), vector_in(terms, j)), n)
                if abs(c) > abs(area):
                    first, second, area = i, j, c
    if area == 0.0:  # at the face's own normal only one of them is held
        return -1.0
    s, t = vector_in(terms, first), vector_in(terms, second)
    u, v = dot(cross(t, x), n) / area, dot(cross(x, s), n) / area
    margin = math.inf
    for k in range(SEGMENT, last):
        if terms[k, SHARE] == 0.0:
            d = scale(1.0 / terms[k, LENGTH], cross(n, vector_in(terms, k)))
            reserve = -abs(dot(x, d))
            for m in range(SEGMENT, last):
                if terms[m, SHARE] == 0.0:
                    reserve += abs(dot(vector_in(terms, m), d))
            margin = min(margin, reserve)
    if abs(u) <= 1.0 and abs(v) <= 1.0:
        terms[first, SHARE], terms[second, SHARE] = u, v
        return max(margin, 0.0)
    if abs(u) > abs(v):
        terms[first, SHARE] = 1.0 if u > 0.0 else -1.0
    else:
        terms[second, SHARE] = 1.0 if v > 0.0 else -1.0
    return -1.0


@compiled
def lean_on_disks(terms: Floats, n: Vector, x: Vector) -> float:
    """Choose points of disks with axes along n that balance x; return the margin, or below 0."""
    on_A, on_B = at_disk(terms, n, AXES_A), at_disk(terms, n, AXES_B)
    r_A, r_B = (
        (terms[AXES_A, LENGTH] if on_A else 0.0),
        (terms[AXES_B, LENGTH] if on_B else 0.0),
    )
    margin = r_A + r_B - norm(x)
    if margin >= 0.0 and r_A + r_B > 0.0:
        for i in range(3):
            terms[LEAN_A, i] = -x[i] * (r_A / (r_A + r_B))
            terms[LEAN_B, i] = -x[i] * (r_B / (r_A + r_B))
    return margin


@compiled
def on_face(
    terms: Floats, last: int, radius: float, n: Vector, flat: bool
) -> tuple[Vector, float, float, Vector]:
    """Return (n, h, margin, step) at the face normal next to n.

    The margin is negative if the face does not contain the foot of the origin. Then a segment was
    released, or ``step`` leads away from the axis of a disk.
    """
    n = face_normal(terms, last, n)
    set_shares(terms, last, n)
    point = add(
        held_sum(terms, last),
        add(ellipsoid_support(terms, AXES_A, n), ellipsoid_support(terms, AXES_B, n)),
    )
    along = dot(point, n)
    x = add_scaled(point, -along, n)
    h = along - radius
    disks = at_disk(terms, n, AXES_A) or at_disk(terms, n, AXES_B)
    if flat:
        margin = shares_on_face(terms, last, n, x)
        if margin >= 0.0:
            return n, h, margin, ZERO
    margin = lean_on_disks(terms, n, x)
    if margin >= 0.0 or not disks:
        return n, h, (margin if disks else -1.0), ZERO
    tangent = -margin / -h if h < 0.0 else LONGEST_STEP
    return n, h, -1.0, scale(-min(tangent, LONGEST_STEP) / norm(x), x)


@compiled
def slope_and_curvature(
    terms: Floats, last: int, radius: float, n: Vector, e: Vector, f: Vector
) -> tuple[float, float, float, float, float, float]:
    """Return h at n, its slopes along e and f, and its three second derivatives."""
    base = held_sum(terms, last)
    y, x_A, z_A, m11, m12, m22 = curvature(terms, AXES_A, n, e, f)
    y_B, x_B, z_B, k11, k12, k22 = curvature(terms, AXES_B, n, e, f)
    h = dot(base, n) + y + y_B - radius
    x, z = dot(base, e) + x_A + x_B, dot(base, f) + z_A + z_B
    return h, x, z, m11 + k11 - radius - h, m12 + k12, m22 + k22 - radius - h


@inlined
def newton_step(
    x: float, z: float, m11: float, m12: float, m22: float, e: Vector, f: Vector, held: bool
) -> Vector:
    """Return the step to zero slopes x along e and z along f; if held, only along f."""
    if held:
        return scale(-z / m22, f)
    det = m11 * m22 - m12 * m12
    return add_scaled(scale((m12 * z - m22 * x) / det, e), (m12 * x - m11 * z) / det, f)


@inlined
def downhill(x: float, z: float, aside: float, e: Vector, f: Vector, held: bool) -> Vector:
    """Return the longest step against the slopes, of norm ``aside``; if held, only along f."""
    return scale(-LONGEST_STEP / aside, add_scaled(scale(0.0 if held else x, e), z, f))


@inlined
def slope_across_kink(x: float, z: float, m12: float, m22: float) -> float:
    """Return the slope across a kink, here or where the step along it ends, the smaller one.

    The minimum may be on the kink at the very end of the held segments. Then the slope here may be
    steeper than they allow for; but a step off the kink would lead back to it, for ever.
    """
    there = x - m12 * z / m22 if m22 > 0.0 else x
    return there if abs(there) < abs(x) else x


@compiled
def lowest_tip(terms: Floats, last: int, radius: float, n: Vector, h: float) -> Vector:
    """Return the disk axis of the least width, if that is below h [m]; else n.

    There h has a tip like that of a cone, to which the slopes around it do not lead.
    """
    for axes in (AXES_A, AXES_B):
        if terms[axes, LENGTH] > 0.0 and terms[axes + 2, LENGTH] == 0.0:
            m = unit(cross(vector_in(terms, axes), vector_in(terms, axes + 1)))
            m = m if dot(m, vector_in(terms, 0)) >= 0.0 else scale(-1.0, m)
            width_there = width(terms, last, radius, m)
            if width_there < h:
                n, h = m, width_there
    return n


@compiled
def descend(difference: Difference, n: Vector, noise: float) -> Minimum:
    """Return the minimum of ``nearby_minimum``, with h computed from the shares."""
    terms, _, last, r_A, r_B = difference
    radius = r_A + r_B
    if last == 0:
        return Minimum(NOTHING, n, math.inf, 0.0)
    for k in range(3):
        terms[LEAN_A, k] = terms[LEAN_B, k] = 0.0
    set_shares(terms, last, n)
    length, leapt = math.inf, False
    for _ in range(STEPS):
        e, reach, flat = held_line(terms, last)
        if flat or at_disk(terms, n, AXES_A) or at_disk(terms, n, AXES_B):
            n, h, margin, step = on_face(terms, last, radius, n, flat)
            if margin >= 0.0:
                return Minimum(FLAT, n, h, margin)
            if step == ZERO and not flat:
                return Minimum(NOTHING, n, h, 0.0)
            part, _ = part_before_kink(terms, last, n, step)
            n = unit(add_scaled(n, part, step))
            continue
        if reach > 0.0:
            f = unit(cross(n, e))
            n = cross(e, f)
        else:
            e = perpendicular(n)
            f = cross(n, e)
        h, x, z, m11, m12, m22 = slope_and_curvature(terms, last, radius, n, e, f)
        if reach > 0.0:
            is_convex, aside = m22 > 0.0, abs(z)
            slope = slope_across_kink(x, z, m12, m22)
            if abs(slope) > reach + noise:
                free_segments(terms, last, e, slope)
                continue
        else:
            is_convex, aside = m11 > 0.0 and m11 * m22 - m12 * m12 > 0.0, abs(x) + abs(z)
        if aside <= noise or (length <= LAST_STEP and aside <= LOOSE_SLOPE * noise):
            if not is_convex:
                return Minimum(NOTHING, n, h, 0.0)
            if reach == 0.0:
                return Minimum(SMOOTH, n, h, 0.0)
            share_out(terms, last, e, min(max(-x / reach, -1.0), 1.0))
            return Minimum(CREASE, n, h, max(reach - abs(x), 0.0))
        tip = n if is_convex or leapt else lowest_tip(terms, last, radius, n, h - noise)
        if tip != n:
            n, length, leapt = tip, math.inf, True
            set_shares(terms, last, n)
            continue
        if is_convex:
            step = newton_step(x, z, m11, m12, m22, e, f, reach > 0.0)
        else:
            step = downhill(x, z, aside, e, f, reach > 0.0)
        length = norm(step)
        if length > LONGEST_STEP:
            step = scale(LONGEST_STEP / length, step)
        part, crossed = part_before_kink(terms, last, n, step)
        if not (is_convex or crossed):
            return Minimum(NOTHING, n, h, 0.0)
        n = unit(add_scaled(n, part, step))
        length = math.inf if crossed else length
    return Minimum(NOTHING, n, math.inf, 0.0)


@compiled
def share_out(terms: Floats, last: int, e: Vector, share: float) -> None:
    """Set the support point of held parallel segments to the same share of each."""
    for k in range(SEGMENT, last):
        if terms[k, SHARE] == 0.0:
            terms[k, SHARE] = share if dot(vector_in(terms, k), e) > 0.0 else -share


@compiled
def nearby_minimum(difference: Difference, n: Vector, noise: float) -> Minimum:
    """Return a local minimum near n, and set the shares at it."""
    kind, n, h, margin = descend(difference, n, noise)
    terms, _, last, r_A, r_B = difference
    if kind != NOTHING:
        truth = width(terms, last, r_A + r_B, n)
        if abs(truth - h) > noise:
            return Minimum(NOTHING, n, truth, 0.0)
    return Minimum(kind, n, h, margin)
