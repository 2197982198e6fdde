"""Compiled posing: moved frames, their descendants, and the geometries on these."""

import math
from typing import TypeAlias

from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import box_half_extents
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    ROTATION_DEFECT,
    ROTATION_STEP,
    ROTATION_TAKEN,
)
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.pose_rounding import (
    RADIUS,
    SHIFT,
    TILT,
    TURN,
    is_exact,
    length_of,
    make_orthogonal,
    shift_of,
)
from drake_geom_ros.geometry._proximity.world.pose_rows import POSITION

# Rotations (n, 3, 3) and positions (n, 3) [m].
Poses: TypeAlias = tuple[Floats, Floats]

# Columns of ``body_data``, after TURN and SHIFT of X_FG.
LEVER = 2  # [m] lever arm of a turn: the outer radius; 0 for a ball, which no turn moves
AT_ORIGIN = 3  # 1 where X_FG is the identity
PACE = 4  # [m] recent motion of a point in one update, fading

FADING = 15 / 16  # of the pace per update: a body that stops counts as moving for a while


@compiled
def set_poses(rows: Indices, X_news: Floats, world: Handle) -> bool:
    """Copy the poses (n, POSE_WIDTH) that differ and mark their frames; return whether one did.

    The world is given by its handle, the frames by their rows.
    """
    world = world_of(world)
    R_PFs, p_PFs, moved = world.R_PFs, world.p_PFs, world.moved
    any_moved = False
    for k in range(rows.size):
        f = rows[k]
        same = True
        for i in range(3):
            same &= X_news[k, POSITION + i] == p_PFs[f, i]
            p_PFs[f, i] = X_news[k, POSITION + i]
            for j in range(3):
                same &= X_news[k, 3 * i + j] == R_PFs[f, i, j]
                R_PFs[f, i, j] = X_news[k, 3 * i + j]
        if not same:
            moved[f] = True
            any_moved = True
    return any_moved


@inlined
def _compose(
    X_ABs: Poses, a: int, X_BCs: Poses, b: int, X_ACs: Poses, c: int
) -> tuple[float, float]:
    """Write X_AB X_BC of rows a and b to row c; return the squared changes of R and p.

    They are the squared Frobenius norm [-] and the squared length [m^2] of the differences. Rows
    are passed by number, because a view of a row costs as much as the product; the numbers are
    unsigned, because the test for negative ones costs half as much.
    """
    (R_ABs, p_ABs), (R_BCs, p_BCs), (R_ACs, p_ACs) = X_ABs, X_BCs, X_ACs
    a, b, c = unsigned(a), unsigned(b), unsigned(c)
    turned, moved = 0.0, 0.0
    for i in range(3):
        x, y, z = R_ABs[a, i, 0], R_ABs[a, i, 1], R_ABs[a, i, 2]
        p = p_ABs[a, i] + x * p_BCs[b, 0] + y * p_BCs[b, 1] + z * p_BCs[b, 2]
        moved += (p - p_ACs[c, i]) * (p - p_ACs[c, i])
        p_ACs[c, i] = p
        for j in range(3):
            r = x * R_BCs[b, 0, j] + y * R_BCs[b, 1, j] + z * R_BCs[b, 2, j]
            turned += (r - R_ACs[c, i, j]) * (r - R_ACs[c, i, j])
            R_ACs[c, i, j] = r
    return turned, moved


@inlined
def _copy(
    R_ABs: Floats, p_ABs: Floats, a: int, R_ACs: Floats, p_ACs: Floats, c: int
) -> tuple[float, float]:
    """Write X_AC of row a to row c; return the squared changes, as ``_compose`` does for B = C."""
    a, c = unsigned(a), unsigned(c)
    turned, moved = 0.0, 0.0
    for i in range(3):
        p = p_ABs[a, i]
        moved += (p - p_ACs[c, i]) * (p - p_ACs[c, i])
        p_ACs[c, i] = p
        for j in range(3):
            r = R_ABs[a, i, j]
            turned += (r - R_ACs[c, i, j]) * (r - R_ACs[c, i, j])
            R_ACs[c, i, j] = r
    return turned, moved


@inlined
def _way(turned: float, moved: float, turn_radius: float) -> float:
    """Return the largest motion of a point of a body by a step of ``_compose`` [m], rounded up.

    A point at x_G moves by (R - R') x + (p - p'). The spectral norm of the difference of two
    rotations is its Frobenius norm over the square root of two; each matrix is a rotation within
    ROTATION_DEFECT.
    """
    way = math.sqrt(moved)
    if turned > 0.0 and turn_radius > 0.0:
        way += turn_radius * (math.sqrt(0.5 * turned) + 2.0 * ROTATION_DEFECT)
    return way * (1.0 + 8.0 * EPS)


@inlined
def _pose_frames(
    moved: Booleans,
    parents: Indices,
    R_PFs: Floats,
    p_PFs: Floats,
    R_WFs: Floats,
    p_WFs: Floats,
    frame_roundings: Floats,
) -> int:
    """Pose the frames marked as moved, and their descendants; return how many."""
    count = 0
    for f in range(1, parents.size):
        parent = parents[f]
        # Row 0, the world, is marked as moved only in a new scene, to pose everything.
        moved[f] = moved[f] or moved[parent]
        if not moved[f]:
            continue
        count += 1
        taken = 0.0 if is_exact(R_PFs, f) else ROTATION_TAKEN
        if parent == 0:
            for i in range(3):
                p_WFs[f, i] = p_PFs[f, i]
                for j in range(3):
                    R_WFs[f, i, j] = R_PFs[f, i, j]
            frame_roundings[f, TURN] = taken
            continue
        _compose((R_WFs, p_WFs), parent, (R_PFs, p_PFs), f, (R_WFs, p_WFs), f)
        if taken > 0.0:
            taken += ROTATION_STEP
            make_orthogonal(R_WFs, f)
        reach, length = length_of(p_WFs, parent), length_of(p_PFs, f)
        turn, shift = frame_roundings[parent, TURN], frame_roundings[parent, SHIFT]
        frame_roundings[f, TURN] = turn + taken
        frame_roundings[f, SHIFT] = shift_of(turn, shift, reach, length)
    return count


@inlined
def _put_half_extents(
    g: int,
    types: Indices,
    starts: Indices,
    pool: Floats,
    R_WGs: Floats,
    rounding: float,
    half_extents: Floats,
) -> None:
    """Write the half extents of a geometry's box, extended by its rounding."""
    if types[g] == SPHERE:
        for i in range(3):
            half_extents[g, i] = pool[starts[g]] + rounding
        return
    shape = part(pool, starts[g], starts[g + 1])
    box_half_extents(types[g], shape, row(R_WGs, g), row(half_extents, g))
    for i in range(3):
        half_extents[g, i] += rounding


@compiled
def update_frames(world: Handle) -> int:
    """Pose the frames that moved in a world, given by its handle; return how many did."""
    world = world_of(world)
    return _pose_frames(
        world.moved,
        world.parents,
        world.R_PFs,
        world.p_PFs,
        world.R_WFs,
        world.p_WFs,
        world.frame_roundings,
    )


@compiled
def update_geometries(world: Handle, revision: int, first: int, last: int) -> int:
    """Pose the geometry on moved frames, with its bounds and travels; return how many moved.

    The range from ``first`` up to ``last`` is of the movable geometries, or of all in a new scene.
    The record is unpacked first, because passing on that of the world makes posing 1000 balls take
    12 microseconds longer, of 80.
    """
    world = world_of(world)
    moved, movable, frames, body_data = world.moved, world.movable, world.frames, world.body_data
    R_WFs, p_WFs, frame_roundings = world.R_WFs, world.p_WFs, world.frame_roundings
    R_FGs, p_FGs, R_WGs, p_WGs = world.R_FGs, world.p_FGs, world.R_WGs, world.p_WGs
    types, starts, pool, roundings = world.types, world.starts, world.pool, world.roundings
    half_extents, stamps, travels = world.half_extents, world.stamps, world.travels
    count = 0
    every = moved[0]
    for k in range(first, min(last, frames.size if every else movable.size)):
        g = k if every else movable[k]
        f = frames[g]
        if moved[f]:
            count += 1
            if body_data[g, AT_ORIGIN] > 0.0:
                turned, shifted = _copy(R_WFs, p_WFs, f, R_WGs, p_WGs, g)
            else:
                turned, shifted = _compose((R_WFs, p_WFs), f, (R_FGs, p_FGs), g, (R_WGs, p_WGs), g)
            reach, length = length_of(p_WFs, f), length_of(p_FGs, g)
            turn, shift = frame_roundings[f, TURN], frame_roundings[f, SHIFT]
            rounding = shift_of(turn, shift, reach, length) + body_data[g, SHIFT]
            turn += body_data[g, TURN]
            if types[g] == HALF_SPACE:
                roundings[g, TILT] = turn
            else:
                rounding += turn * body_data[g, LEVER]
            grown = max(0.0, rounding - roundings[g, RADIUS])
            roundings[g, RADIUS] = rounding
            _put_half_extents(g, types, starts, pool, R_WGs, rounding, half_extents)
            if stamps[g] > 0:
                # The rounding ball of each point may have moved by its growth, too.
                way = _way(turned, shifted, body_data[g, LEVER]) + grown
                travels[g] = (travels[g] + way) * (1.0 + 2.0 * EPS)
                body_data[g, PACE] = max(way, FADING * body_data[g, PACE])
            stamps[g] = revision
    return count


@compiled
def update(world: Handle, revision: int) -> tuple[int, int]:
    """Pose moved frames and bodies of a world, given by its handle; return how many of each."""
    frame_count = update_frames(world)
    arrays = world_of(world)
    body_count = update_geometries(world, revision, 0, arrays.types.size)
    arrays.moved[:] = False
    return frame_count, body_count
