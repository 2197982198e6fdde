"""All pairs of bodies, one after another."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    BEGINS,
    COMPLIANT_M,
    COMPLIANT_N,
    CORNERS,
    CORNERS_BEFORE,
    COUNTS,
    DIGEST,
    DONE,
    FACE,
    FACES_BEFORE,
    FOUND,
    FULL,
    HALF_SPACE,
    ID_M,
    ID_N,
    KIND,
    LAST,
    LEFT,
    MEETS,
    MEETS_ANYWAY,
    NOT_BEGUN,
    NOTHING,
    POLYGONS,
    PRESSES,
    RECORD,
    STAGE,
    STEPS,
    SUMS,
    SWALLOWED,
    TOP,
    TURNED,
    UNABLE,
    VOLUME,
    Between,
    Bodies,
    Counts,
    Floats,
    Geometries,
    Hands,
    Indices,
    Scratch,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._contact_surfaces.emitting import sums_in_world
from drake_geom_ros.geometry._contact_surfaces.layout import layout_of
from drake_geom_ros.geometry._contact_surfaces.swallowed import one_is_swallowed
from drake_geom_ros.geometry._contact_surfaces.tolerances import ROUNDING
from drake_geom_ros.geometry._contact_surfaces.walks import meet_bodies, meet_plane
from drake_geom_ros.geometry._proximity.kernels.vectors import sub, unrotate, vector_in
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, taker
from drake_geom_ros.geometry._proximity.runtime.views import part, table, wide_integers

_hands_of, _bodies_of = taker(Hands), taker(Bodies)
_geometries_of, _scratch_of = taker(Geometries), taker(Scratch)


@compiled
def surfaces_of_pairs(
    hands: Handle,
    room: Handle,
    pairs: Indices,
    store: Floats,
    faces: int,
    corners: int,
    begins: int,
    steps: int,
) -> Counts:
    """Put out the surfaces of pairs (k, 2) into ``store``, which ``layout_of`` divides.

    All that there are, or those of about so many steps, or as many as there is room for by
    ``faces`` and ``corners``. The next call goes on where this one ended, unless it ``begins``.
    """
    hands, scratch = _hands_of(hands), _scratch_of(room)
    bodies, geometries = _bodies_of(hands.bodies), _geometries_of(hands.geometries)
    count, counts = len(pairs), scratch.counts
    at = layout_of(count, faces, corners)
    integers = wide_integers(store, 0)
    out = Surfaces(
        points=table(store, at.points, corners, 3),
        pressures=part(store, at.pressures, at.size),
        ends=part(integers, at.ends, at.points),
        faces=table(store, at.faces, faces, FACE),
        sums=table(store, 0, count, SUMS),
        found=table(integers, at.found, count, RECORD),
        states=part(integers, at.states, at.faces),
        counts=counts,
    )
    if begins:
        for k in range(COUNTS):
            counts[k] = 0
    counts[STEPS], counts[FULL] = steps, 0
    while counts[DONE] < count and counts[STEPS] > 0 and counts[FULL] == 0:
        counts[STEPS] -= 1
        if _is_pair_done(bodies, geometries, pairs, scratch, out):
            counts[STAGE] = BEGINS
            counts[DONE] += 1
    return Counts(
        *(counts[POLYGONS], counts[CORNERS], counts[FOUND], counts[LEFT], counts[DONE]),
        counts[FULL] == 1,
    )


@compiled
def _is_pair_done(
    bodies: Bodies, geometries: Geometries, pairs: Indices, scratch: Scratch, out: Surfaces
) -> bool:
    """Go on with the surface of the next pair; return whether it is done.

    The geometry of lower id is M.
    """
    counts = out.counts
    pair, row = counts[DONE], counts[FOUND]
    m, n = min(pairs[pair, 0], pairs[pair, 1]), max(pairs[pair, 0], pairs[pair, 1])
    M, N = geometries.body_of[m], geometries.body_of[n]
    if counts[STAGE] == BEGINS:
        if not _can_press(bodies, M, N):
            out.states[pair] = UNABLE
            counts[LEFT] += 1
            return True
        for column in range(SUMS):
            out.sums[row, column] = 0.0
        counts[FACES_BEFORE], counts[CORNERS_BEFORE] = counts[POLYGONS], counts[CORNERS]
        counts[STAGE], counts[TOP] = MEETS, NOT_BEGUN
    between = _between(bodies, geometries, (m, n), row, scratch.R)
    if counts[STAGE] == MEETS:
        if not _meet(bodies, between, scratch, out):
            return False
        if counts[POLYGONS] > counts[FACES_BEFORE]:
            sums_in_world(out.sums, between)
            out.states[pair] = PRESSES
            counts[FOUND] += 1
            out.found[row, ID_M], out.found[row, ID_N] = geometries.ids[m], geometries.ids[n]
            out.found[row, COMPLIANT_M] = 1 if _is_compliant(bodies, M) else 0
            out.found[row, COMPLIANT_N] = 1 if _is_compliant(bodies, N) else 0
            out.found[row, LAST] = counts[POLYGONS]
            return True
    return _is_known_without_surface(bodies, between, pair, scratch, out)


@compiled
def _meet(bodies: Bodies, between: Between, scratch: Scratch, out: Surfaces) -> bool:
    """Put out the polygons of two bodies; return whether there are no more."""
    if bodies.table[between.b, KIND] == HALF_SPACE:
        return meet_plane(bodies, bodies.numbers[between.b, 1], between, scratch, out)
    return meet_bodies(bodies, between, scratch, out)


@compiled
def _is_known_without_surface(
    bodies: Bodies, between: Between, pair: int, scratch: Scratch, out: Surfaces
) -> bool:
    """Put out whether two bodies without polygons overlap all the same, and how.

    Return whether that is known. Say there is no face where both pressures are equal, or where a
    rigid surface is in the other body, whatever its normal. Compliant bodies are of one piece,
    with pressure all over inside. Of two of them the difference of pressures has then the same
    sign all over each piece of what is in both. On the surface of each, inside the other, its own
    pressure is the lower one: so that piece is bounded by the surface of one of them alone, which
    is all of that body, with its innermost point. A rigid surface that does not enter the other
    body has all of it inside or outside. So the innermost points decide.
    """
    counts, b = out.counts, between
    if counts[STAGE] == MEETS:
        if one_is_swallowed(bodies, between, scratch):
            out.states[pair] = SWALLOWED
            counts[LEFT] += 1
            return True
        counts[STAGE], counts[TOP] = MEETS_ANYWAY, NOT_BEGUN
    again = Between(b.row, b.a, b.b, b.R, b.p, b.R_W, b.p_W, b.rounding, b.flip, True)
    if not _meet(bodies, again, scratch, out):
        return False
    out.states[pair] = NOTHING
    if counts[POLYGONS] > counts[FACES_BEFORE]:
        out.states[pair] = TURNED
        counts[LEFT] += 1
    counts[POLYGONS], counts[CORNERS] = counts[FACES_BEFORE], counts[CORNERS_BEFORE]
    return True


@inlined
def _is_compliant(bodies: Bodies, body: int) -> bool:
    """Return whether there is pressure in a body."""
    kind = bodies.table[body, KIND]
    compliant: bool = kind == VOLUME or (kind == HALF_SPACE and bodies.numbers[body, 1] > 0.0)
    return compliant


@inlined
def _can_press(bodies: Bodies, M: int, N: int) -> bool:
    """Return whether two bodies, -1 for none, can have a surface."""
    if M < 0 or N < 0 or not (_is_compliant(bodies, M) or _is_compliant(bodies, N)):
        return False
    able: bool = bodies.table[M, KIND] != HALF_SPACE or bodies.table[N, KIND] != HALF_SPACE
    return able


@inlined
def _comes_before(bodies: Bodies, geometries: Geometries, a: int, b: int) -> bool:
    """Return whether geometry a comes before b: tetrahedra before a surface before a half space.

    Two with tetrahedra are ordered by their meshes, and equal ones by their poses, not by which is
    M: so M has no effect on the surface, however rounding or ties are decided.
    """
    first, second = geometries.body_of[a], geometries.body_of[b]
    for column in (KIND, DIGEST):
        one, other = bodies.table[first, column], bodies.table[second, column]
        if one != other:
            return bool(one < other)
    for i in range(3):
        if geometries.p_WGs[a, i] != geometries.p_WGs[b, i]:
            return bool(geometries.p_WGs[a, i] < geometries.p_WGs[b, i])
    for i in range(3):
        for j in range(3):
            if geometries.R_WGs[a, i, j] != geometries.R_WGs[b, i, j]:
                return bool(geometries.R_WGs[a, i, j] < geometries.R_WGs[b, i, j])
    return False


@inlined
def _between(
    bodies: Bodies, geometries: Geometries, pair: tuple[int, int], row: int, R: Floats
) -> Between:
    """Return two geometries' bodies, in the order of ``_comes_before``.

    ``R`` is where the orientation of the second in the first is put.
    """
    a, b = pair
    flip = _comes_before(bodies, geometries, b, a)
    if flip:
        a, b = b, a
    first, second = geometries.body_of[a], geometries.body_of[b]
    for i in range(3):
        for j in range(3):
            R[i, j] = 0.0
            for k in range(3):
                R[i, j] += geometries.R_WGs[a, k, i] * geometries.R_WGs[b, k, j]
    p_W = vector_in(geometries.p_WGs, a)
    p = unrotate(geometries.R_WGs[a], sub(vector_in(geometries.p_WGs, b), p_W))
    size = bodies.numbers[first, 0] + bodies.numbers[second, 0]
    if bodies.table[second, KIND] == HALF_SPACE:
        size = bodies.numbers[first, 0] + abs(R[0, 2] * p[0] + R[1, 2] * p[1] + R[2, 2] * p[2])
        # A rigid surface in a soft half space is N.
        flip = flip != (bodies.table[first, KIND] != VOLUME)
    return Between(
        row, first, second, R, p, geometries.R_WGs[a], p_W, ROUNDING * size, flip, False
    )
