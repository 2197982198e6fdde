"""Boxes for which a neighbour list is valid: each body's box with a skin for later updates."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.near.arrays import CHECKED_AT, MADE_AT, ListArrays
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays
from drake_geom_ros.geometry._proximity.world.pose_update import PACE

UPDATES_AHEAD = 16.0  # updates that a skin is made for; more of them: fewer lists, more pairs
WIDEST_SKIN = 0.5  # of a body's radius
LEAST_AHEAD = 4.0  # updates that a skin has to last: a skin costs as much as a list or two
PATIENCE = 64  # updates without a move after which a body counts as resting


@inlined
def somebody_left(near: ListArrays, world: WorldArrays, revision: int) -> bool:
    """Return whether any body has left its box."""
    since = near.numbers[CHECKED_AT]
    near.numbers[CHECKED_AT] = revision
    if since == revision:
        return False
    for k in range(world.movable.size):
        g = world.movable[k]
        if world.stamps[g] <= since:
            continue
        for c in range(3):
            p, half = world.p_WGs[g, c], world.half_extents[g, c]
            if not (p - half >= near.lowers[g, c] and p + half <= near.uppers[g, c]):
                return True
    return False


@inlined
def _lasts(world: WorldArrays, g: int) -> bool:
    """Return whether the skin of a body will last long enough at its recent pace."""
    return world.body_data[g, PACE] * LEAST_AHEAD <= WIDEST_SKIN * world.outer[g]


@inlined
def _set_box(near: ListArrays, world: WorldArrays, g: int, with_skin: bool, cutoff: float) -> None:
    """Set the padding of a body, and its box with a skin."""
    skin = 0.0
    if with_skin and near.active[g] and _lasts(world, g):
        skin = min(UPDATES_AHEAD * world.body_data[g, PACE], WIDEST_SKIN * world.outer[g])
    near.paddings[g] = skin + 0.5 * cutoff
    for c in range(3):
        p, side = world.p_WGs[g, c], world.half_extents[g, c] + skin
        near.lowers[g, c], near.uppers[g, c] = p - side, p + side


@inlined
def set_boxes(
    near: ListArrays, world: WorldArrays, revision: int, cutoff: float, every: bool
) -> tuple[int, int]:
    """Activate bodies that moved since the list was made, and set boxes with skins.

    If a body is too fast for a skin to last, no body gets one.

    Return the number of active bodies, and how many of them have rested for some time. ``lowers``
    and ``uppers`` get the boxes for which the next list is valid, ``paddings`` the skins plus half
    the cutoff [m]: of movable bodies, or of ``every`` body. ``rows`` begins with the active ones
    that have a place.
    """
    count, idle, fast, made = 0, 0, 0, near.numbers[MADE_AT]
    stamps, movable = world.stamps, world.movable
    for k in range(movable.size):
        g = movable[k]
        if made > 0 and stamps[g] > made and not near.is_plane[g]:
            near.active[g] = True
        if near.active[g] and not world.waiting[g]:
            near.rows[count] = g
            count += 1
            idle += stamps[g] <= revision - PATIENCE
            fast += not _lasts(world, g)
    if every or 2 * movable.size > near.active.size:
        for g in range(near.active.size):  # in memory order, which takes half as long
            _set_box(near, world, g, fast == 0, cutoff)
    else:
        for k in range(movable.size):
            _set_box(near, world, movable[k], fast == 0, cutoff)
    near.numbers[MADE_AT] = near.numbers[CHECKED_AT] = revision
    return count, idle
