"""Which triangles of a surface go through each other: in exact arithmetic, on the numbers given.

Two triangles in different planes cross if a segment of some length lies inside both; two in one
plane if they have an area in common. Those that only touch, wherever and however, do not.
"""

from fractions import Fraction
from itertools import combinations

from truth.references.digits import combine, cross, dot


def sub(a, b):
    return combine(a, -1, b)


def _heights(triangle, a, n):
    return [dot(sub(p, a), n) for p in triangle]


def _part_of_line(triangle, heights, along):
    """Where the plane's line enters and leaves a triangle that has corners on both sides."""
    places = []
    for k in range(3):
        (p, h), (q, g) = ((triangle[i], heights[i]) for i in (k, (k + 1) % 3))
        if h * g < 0 or (h == 0) != (g == 0):
            t = h / (h - g)
            places.append(dot(p, along) + t * (dot(q, along) - dot(p, along)))
    return min(places), max(places)


def _overlap_in_plane(first, second, n):
    """Whether triangles in one plane share an area: no edge has the other beyond it."""
    for mine, its in ((first, second), (second, first)):
        for k in range(3):
            p, q, r = (mine[(k + i) % 3] for i in range(3))
            side = cross(sub(q, p), n)
            turn = 1 if dot(sub(r, p), side) < 0 else -1
            if min(turn * dot(sub(x, p), side) for x in its) >= 0:
                return False
    return True


def do_cross(first, second):
    """Whether two triangles of fractions cross; those without area do not."""
    a, b = first[0], second[0]
    n = cross(sub(first[1], a), sub(first[2], a))
    m = cross(sub(second[1], b), sub(second[2], b))
    if not any(n) or not any(m):
        return False
    over_b, over_a = _heights(first, b, m), _heights(second, a, n)
    if not any(over_a):
        return _overlap_in_plane(first, second, n)
    if min(over_b) >= 0 or max(over_b) <= 0 or min(over_a) >= 0 or max(over_a) <= 0:
        return False
    along = cross(n, m)
    low_a, high_a = _part_of_line(first, over_b, along)
    low_b, high_b = _part_of_line(second, over_a, along)
    return min(high_a, high_b) > max(low_a, low_b)


def crossings(vertices, triangles):
    """Return the pairs of triangles that cross, of vertices (n, 3) and indices (m, 3)."""
    points = [tuple(map(Fraction, p)) for p in vertices.tolist()]
    corners = [tuple(points[i] for i in t) for t in triangles.tolist()]
    low = vertices[triangles].min(axis=1)
    high = vertices[triangles].max(axis=1)
    return [
        (i, j)
        for i, j in combinations(range(len(corners)), 2)
        if (low[i] <= high[j]).all() and (low[j] <= high[i]).all()
        if do_cross(corners[i], corners[j])
    ]
