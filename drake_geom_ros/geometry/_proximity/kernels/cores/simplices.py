"""Closest point to the origin of a segment, triangle or tetrahedron.

Each function returns the barycentric weights of that point. Weights of an interior point come from
signed areas and volumes (Montanari, Petrinic, Barbieri, *Improving the GJK algorithm for faster
and more reliable distance queries between convex objects*, ACM Transactions on Graphics 36 (3),
2017). If a sign says that the point is not interior, all candidate faces are tried and the nearest
is used. So a wrong sign on a sliver costs only rounding, and never a wrong region.
"""

from drake_geom_ros.geometry._proximity.kernels.vectors import add_scaled, cross, dot, scale, sub
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined


@inlined
def weighted(a: Vector, b: Vector, c: Vector, weights: Vector) -> Vector:
    """Return the sum of three vectors times their weights."""
    return add_scaled(add_scaled(scale(weights[0], a), weights[1], b), weights[2], c)


@compiled
def closest_on_segment(a: Vector, b: Vector) -> tuple[float, float]:
    """Return the weights of a and b at the closest point of their segment."""
    d = sub(b, a)
    length2 = dot(d, d)
    t = -dot(a, d)
    if t <= 0.0 or length2 == 0.0:
        return 1.0, 0.0
    if t >= length2:
        return 0.0, 1.0
    return 1.0 - t / length2, t / length2


@compiled
def closest_on_triangle(a: Vector, b: Vector, c: Vector) -> tuple[float, float, float]:
    """Return the weights of a, b and c at the closest point of their triangle."""
    ab, ac = sub(b, a), sub(c, a)
    n = cross(ab, ac)
    area2 = dot(n, n)
    if area2 > 0.0:
        weight_b = -dot(cross(a, ac), n) / area2
        weight_c = -dot(cross(ab, a), n) / area2
        weight_a = 1.0 - weight_b - weight_c
        if weight_a > 0.0 and weight_b > 0.0 and weight_c > 0.0:
            return weight_a, weight_b, weight_c
    s = closest_on_segment(a, b)
    best = (s[0], s[1], 0.0)
    v = weighted(a, b, c, best)
    least = dot(v, v)
    s = closest_on_segment(a, c)
    v = add_scaled(scale(s[0], a), s[1], c)
    if dot(v, v) < least:
        least = dot(v, v)
        best = (s[0], 0.0, s[1])
    s = closest_on_segment(b, c)
    v = add_scaled(scale(s[0], b), s[1], c)
    if dot(v, v) < least:
        best = (0.0, s[0], s[1])
    return best


@compiled
def closest_on_tetrahedron(
    a: Vector, b: Vector, c: Vector, d: Vector
) -> tuple[float, float, float, float]:
    """Return the weights of a, b, c and d; all are positive if the origin is inside."""
    ab, ac, ad = sub(b, a), sub(c, a), sub(d, a)
    volume = dot(ab, cross(ac, ad))
    if volume != 0.0:
        weight_b = -dot(a, cross(ac, ad)) / volume
        weight_c = -dot(a, cross(ad, ab)) / volume
        weight_d = -dot(a, cross(ab, ac)) / volume
        weight_a = 1.0 - weight_b - weight_c - weight_d
        if weight_a > 0.0 and weight_b > 0.0 and weight_c > 0.0 and weight_d > 0.0:
            return weight_a, weight_b, weight_c, weight_d
    t = closest_on_triangle(a, b, c)
    best = (t[0], t[1], t[2], 0.0)
    v = weighted(a, b, c, t)
    least = dot(v, v)
    t = closest_on_triangle(a, b, d)
    v = weighted(a, b, d, t)
    if dot(v, v) < least:
        least = dot(v, v)
        best = (t[0], t[1], 0.0, t[2])
    t = closest_on_triangle(a, c, d)
    v = weighted(a, c, d, t)
    if dot(v, v) < least:
        least = dot(v, v)
        best = (t[0], 0.0, t[1], t[2])
    t = closest_on_triangle(b, c, d)
    v = weighted(b, c, d, t)
    if dot(v, v) < least:
        best = (0.0, t[0], t[1], t[2])
    return best
