"""EPA: the depth of two overlapping cores, between certified bounds.

Van den Bergh (*Proximity queries and penetration depth computation on 3D game objects*, Game
Developers Conference 2001) grows a polytope P of points of the Minkowski difference D = A - B at
the face nearest to the origin. Two things are done differently here.

*The polytope need not start around the origin.* Faces have signed offsets and the most negative
one is expanded first, so no enclosing simplex is asked of GJK, and touching shapes, whose
difference has the origin on its surface, are the normal case.

*The bounds do not trust the planes.* Above: ``h_D(n)``, the width of the overlap along the unit n,
holds for any n. Below: a triangle with vertices v_i is no nearer to the origin than
``min_i (n . v_i)``, for any unit n, be the triangle a sliver or not. The triangles form a closed
surface in D by the way they are linked. When all these offsets are positive, all triangles are
seen from inside, so their solid angles add up to 4 pi or more, the surface winds around the
origin, and the ball of the least offset lies within D. Neither convexity of P nor an exact
visibility test is needed for that. D must have a volume: see ``revolution`` for the pairs of cores
that have none.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.gjk import put, row, support_points
from drake_geom_ros.geometry._proximity.kernels.polytope import (
    ALIVE,
    FACE_WIDTH,
    OFFSET,
    PLANE_WIDTH,
    add_faces,
    expand,
    is_corner,
    link_tetrahedron,
    pop_living,
)
from drake_geom_ros.geometry._proximity.kernels.simplices import closest_on_triangle, weighted
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    cross,
    dot,
    norm,
    scale,
    sub,
    unit,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS, FOLD, ROUNDING, SAME_DIRECTION


@compiled
def first_points(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB, points):
    """Fill in four support points that span a volume.

    Directions are taken from the axes of B, so that the answer turns with the pair where it is not
    unique.
    """
    x, y = column(R_WB, 0), column(R_WB, 1)
    n = scale(-1.0, x)
    along = y
    for k in range(4):
        best = -1.0
        for turn in range(2 if k > 0 else 1):
            m = scale(1.0 - 2.0 * turn, n) if k != 1 else scale(-1.0, n)
            a, b = support_points(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB, m, 0.0)
            rise = 0.0 if k == 0 else abs(dot(sub(sub(a, b), row(points, 0, 0)), n))
            if rise > best:
                best = rise
                put(points, k, a, b)
        if k == 1:
            along = unit(sub(row(points, 1, 0), row(points, 0, 0)))
            n = cross(along, x)
            n = unit(n if norm(n) > 0.5 else cross(along, y))
        if k == 2:
            n = unit(cross(along, sub(row(points, 2, 0), row(points, 0, 0))))


@compiled
def witness(points, faces, planes, total, n, upper, rival, s_A, s_B):
    """Return (a, b, aside): points on the supporting planes of A and B with a - b = upper n.

    They come from the point of the polytope nearest to upper n, moved out to the planes. On a flat
    of the difference it may be in any face, and not in the one that was expanded. ``aside`` is how
    far that point is from upper n: as far, at most, a and b were put off their surfaces.
    """
    foot = scale(upper, n)
    a, b, least = s_A, s_B, np.inf
    for f in range(total):
        if faces[f, ALIVE] == 0 or planes[f, OFFSET] > rival:
            continue
        if dot((planes[f, 0], planes[f, 1], planes[f, 2]), n) < SAME_DIRECTION:
            continue
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x = sub(row(points, i, 0), foot)
        y, z = sub(row(points, j, 0), foot), sub(row(points, k, 0), foot)
        t = closest_on_triangle(x, y, z)
        away = norm(weighted(x, y, z, t))
        if away < least:
            least = away
            a = weighted(row(points, i, 3), row(points, j, 3), row(points, k, 3), t)
            b = weighted(row(points, i, 6), row(points, j, 6), row(points, k, 6), t)
    rise = dot(sub(s_A, a), n) + dot(sub(s_B, b), n)
    centre = scale(0.5, add_scaled(add(a, b), rise, n))
    return add_scaled(centre, 0.5 * upper, n), add_scaled(centre, -0.5 * upper, n), least


@compiled
def depth_of_cores(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB, size, tolerance, most_vertices
):
    """Return (upper, lower, n, a, b, aside, unique) of two overlapping or touching cores.

    ``upper`` is the width of the overlap along the unit n (from A to B). ``lower`` is the radius
    of a ball around the origin in the Minkowski difference, or minus a length within which the
    difference has a point. Points a and b, from Ao, have ``a - b = upper n``; ``aside`` is of
    ``witness``. ``unique`` tells that the bounds exclude every clearly different direction: once
    they have met, faces turned elsewhere go on growing until none is as near.
    """
    rows = 8 * most_vertices
    points, planes = np.empty((most_vertices, 9)), np.empty((rows, PLANE_WIDTH))
    faces, rim = np.empty((rows, FACE_WIDTH), dtype=np.int32), np.empty((rows, 3), dtype=np.int32)
    heap, stack = np.empty(rows, dtype=np.int32), np.empty(rows, dtype=np.int32)
    starting_at = np.full(most_vertices, -1, dtype=np.int32)
    enough = max(tolerance, ROUNDING * EPS * size)
    first_points(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB, points)
    link_tetrahedron(points, faces)
    count, total, waiting, settled = 4, 4, 0, False
    waiting = add_faces(points, faces, planes, heap, 0, total, waiting, size)
    best, lower, unique = np.inf, -np.inf, False
    n, a, b = column(R_WB, 0), row(points, 0, 3), row(points, 0, 6)
    while waiting > 0:
        f, waiting = pop_living(faces, planes, heap, waiting)
        if f < 0 or (settled and planes[f, OFFSET] > best + enough):
            unique = settled
            break
        m = planes[f, 0], planes[f, 1], planes[f, 2]
        if settled and dot(m, n) >= SAME_DIRECTION:
            continue
        if not settled and lower > 0.0 and planes[f, OFFSET] < lower - FOLD * size:
            break
        lower = lower if settled else max(lower, planes[f, OFFSET])
        s_A, s_B = support_points(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB, m, 0.0)
        w = sub(s_A, s_B)
        width = dot(w, m)
        if settled and width <= best + 2.0 * enough:
            break
        closed = not settled and width - lower <= enough
        if closed or (width < best and not settled):
            best, n, a, b = width, m, s_A, s_B
        if closed:
            settled = True
            continue
        # A corner again: rounding has nothing more to offer here.
        known = count == most_vertices or is_corner(points, faces, f, w)
        grown = total
        if not known:
            grown = expand(
                points, faces, planes, rim, stack, starting_at, f, s_A, s_B, count, total, size
            )
            waiting = add_faces(points, faces, planes, heap, total, grown, waiting, size)
        if grown == total:
            break
        count, total = count + 1, grown
    a, b, aside = witness(points, faces, planes, total, n, best, best + enough, a, b)
    if lower <= 0.0:
        lower = -(abs(best) + aside)
    return best, lower, n, a, b, aside, unique
