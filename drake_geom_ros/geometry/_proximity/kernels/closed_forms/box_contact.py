"""Witness points of two boxes: closest edges of separated boxes, a common point of touching ones.

Both boxes are given in the frame of the first, which has half sizes h along the axes. The second
has half sizes g, axes ``b = (b_x, b_y, b_z)`` and centre c. ``seen_from_other`` swaps the roles.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import along, excess
from drake_geom_ros.geometry._proximity.kernels.closed_forms.segments import (
    nearest_parameter,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    scale,
    sub,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE


@compiled
def to_first(b: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    """Return v in the axes of the first box, given in those of the second."""
    return (
        b[0][0] * v[0] + b[1][0] * v[1] + b[2][0] * v[2],
        b[0][1] * v[0] + b[1][1] * v[1] + b[2][1] * v[2],
        b[0][2] * v[0] + b[1][2] * v[1] + b[2][2] * v[2],
    )


@compiled
def to_second(b: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    """Return v in the axes of the second box, given in those of the first."""
    return dot(b[0], v), dot(b[1], v), dot(b[2], v)


@compiled
def seen_from_other(
    b: tuple[Vector, Vector, Vector], c: Vector
) -> tuple[tuple[Vector, Vector, Vector], Vector]:
    """Return the axes and the centre of the first box in the frame of the second."""
    a = (
        (b[0][0], b[1][0], b[2][0]),
        (b[0][1], b[1][1], b[2][1]),
        (b[0][2], b[1][2], b[2][2]),
    )
    return a, scale(-1.0, to_second(b, c))


@compiled
def _closest_edge(
    h: Vector, g: Vector, b: tuple[Vector, Vector, Vector], c: Vector, enough: float
) -> tuple[float, Vector, Vector]:
    """Return the distance, p_CaCb and edge point of the second box's edge nearest to the first.

    The search ends early once the distance is at most ``enough`` [m].
    """
    best, p_CaCb, p = math.inf, (0.0, 0.0, 0.0), c
    for j in range(3):
        k, m = (j + 1) % 3, (j + 2) % 3
        # Edges facing the first box come first.
        u = scale(-g[k] if dot(c, b[k]) > 0.0 else g[k], b[k])
        v = scale(-g[m] if dot(c, b[m]) > 0.0 else g[m], b[m])
        half = (g[j] * abs(b[j][0]), g[j] * abs(b[j][1]), g[j] * abs(b[j][2]))
        around = add(h, half)
        for corner in range(4):
            middle = add_scaled(c, -1.0 if corner & 1 else 1.0, u)
            middle = add_scaled(middle, -1.0 if corner & 2 else 1.0, v)
            nearest = excess(around, middle)
            if dot(nearest, nearest) >= best * best:
                continue
            t = nearest_parameter(h, middle, b[j], g[j])
            point = add_scaled(middle, t, b[j])
            vector = excess(h, point)
            if abs(t) < g[j] and min(abs(vector[0]), abs(vector[1]), abs(vector[2])) > 0.0:
                # Inside an edge, over a vertex: a short vector has few digits, so make it normal.
                vector = add_scaled(vector, -dot(vector, b[j]), b[j])
            distance = norm(vector)
            if distance < best:
                best, p_CaCb, p = distance, vector, point
                if best <= enough:
                    return best, p_CaCb, p
    return best, p_CaCb, p


@compiled
def closest_points(
    h: Vector, g: Vector, b: tuple[Vector, Vector, Vector], c: Vector, enough: float
) -> tuple[Vector, Vector]:
    """Return p_CaCb from the first box to the second, and its starting point.

    They are the closest points of separated boxes, or any two at most ``enough`` [m] apart.
    """
    distance, p_CaCb, p = _closest_edge(h, g, b, c, enough)
    if distance <= enough:
        return p_CaCb, sub(p, p_CaCb)
    a, p_from_second = seen_from_other(b, c)
    other, p_CbCa, q = _closest_edge(g, h, a, p_from_second, enough)
    if other >= distance:
        return p_CaCb, sub(p, p_CaCb)
    return scale(-1.0, to_first(b, p_CbCa)), add(c, to_first(b, q))


@compiled
def _clip(
    c: tuple[float, float], d: tuple[float, float], h: tuple[float, float], half_length: float
) -> tuple[float, float]:
    """Return the interval of t, |t| <= half_length, with c + t d in the rectangle h, in 2D.

    Empty intervals end before they begin.
    """
    low, high = -half_length, half_length
    for k in range(2):
        if abs(d[k]) > RIGHT_ANGLE:
            t, u = (-h[k] - c[k]) / d[k], (h[k] - c[k]) / d[k]
            low, high = max(low, min(t, u)), min(high, max(t, u))
        elif abs(c[k]) > h[k]:
            high = low - 1.0
    return low, high


@compiled
def _outline(
    h: tuple[float, float],
    g: tuple[float, float],
    u: tuple[float, float],
    v: tuple[float, float],
    c: tuple[float, float],
) -> tuple[float, float, float]:
    """Return the length and moment of the edges of rectangle g (axes u, v, centre c) in h, 2D."""
    length, x, y = 0.0, 0.0, 0.0
    for side in (-1.0, 1.0):
        for turn in range(2):
            d, e = (u, v) if turn == 0 else (v, u)
            along_d, along_e = (g[0], g[1]) if turn == 0 else (g[1], g[0])
            middle = (c[0] + side * along_e * e[0], c[1] + side * along_e * e[1])
            low, high = _clip(middle, d, h, along_d)
            if high > low:
                t = 0.5 * (low + high)
                length += high - low
                x += (high - low) * (middle[0] + t * d[0])
                y += (high - low) * (middle[1] + t * d[1])
    return length, x, y


@compiled
def _patch_centre(
    h: tuple[float, float],
    g: tuple[float, float],
    u: tuple[float, float],
    v: tuple[float, float],
    c: tuple[float, float],
    slack: float,
) -> tuple[bool, tuple[float, float]]:
    """Return whether two rectangles in a plane overlap, and the centre of the overlap's outline.

    The outline consists of the parts of each rectangle's edges within the other, so its centroid
    lies in the overlap, which is convex. With ``slack`` [m], touching rectangles count, too.
    """
    inner = (h[0] + slack, h[1] + slack)
    length, x, y = _outline(inner, g, u, v, c)
    outer = (g[0] + slack, g[1] + slack)
    origin = (-(c[0] * u[0] + c[1] * u[1]), -(c[0] * v[0] + c[1] * v[1]))
    other, s, t = _outline(outer, h, (u[0], v[0]), (u[1], v[1]), origin)
    total = length + other
    if total == 0.0:
        return False, c
    # The second moments are along u and v, from c.
    return True, (
        (x + other * c[0] + s * u[0] + t * v[0]) / total,
        (y + other * c[1] + s * u[1] + t * v[1]) / total,
    )


@compiled
def common_point(
    h: Vector,
    g: Vector,
    b: tuple[Vector, Vector, Vector],
    c: Vector,
    n: Vector,
    is_face: bool,
    slack: float,
) -> tuple[Vector, float]:
    """Return a common point of two touching boxes, and its distance [m] from the second box.

    The unit n points out of the first box at the contact; ``is_face``: it is normal to a face. The
    point is the centre of that part of the second box's lowest vertex, edge or face along n that
    lies on the first box; otherwise it is a point where edges meet.
    """
    feature, flats, first, second = c, 0, 0, 0
    for k in range(3):
        cosine = dot(b[k], n)
        if abs(cosine) <= RIGHT_ANGLE:
            first, second = second, k
            flats += 1
        else:
            feature = add_scaled(feature, -g[k] if cosine > 0.0 else g[k], b[k])
    p = feature
    on_first = flats < 2
    if flats == 1:
        t = nearest_parameter(h, feature, b[second], g[second])
        p = add_scaled(feature, t, b[second])
    elif flats == 2 and is_face:
        k = 0 if abs(n[0]) > 0.5 else (1 if abs(n[1]) > 0.5 else 2)
        i, j = (k + 1) % 3, (k + 2) % 3
        u, v = (b[first][i], b[first][j]), (b[second][i], b[second][j])
        sizes, middle = (g[first], g[second]), (feature[i], feature[j])
        on_first, centre = _patch_centre((h[i], h[j]), sizes, u, v, middle, slack)
        p = add(along(i, centre[0]), add(along(j, centre[1]), along(k, feature[k])))
    p_CaCb = excess(h, p)
    if on_first and norm(p_CaCb) <= 4.0 * slack:
        return sub(p, p_CaCb), norm(p_CaCb)
    p_CaCb, p = closest_points(h, g, b, c, slack)
    return p, norm(p_CaCb)
