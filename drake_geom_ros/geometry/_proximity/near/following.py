"""The neighbour list of a world in which few geometries changed, from that of the former world.

Pairs of bodies that stay keep their slots, with the last answers, and resting bodies are not put
into cells again: bodies that came, or have another shape, count as active for a time. Candidate
pairs stay, too, and those of the bodies that came are found by comparing the box of each with all
others. So a change takes the time of copying columns, and the broad phase does not run.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.near.arrays import (
    ACTIVE_THEN,
    ASKED_CUTOFF,
    CANDIDATE_COUNT,
    CHECKED_AT,
    FREE,
    LIST_CUTOFF,
    MADE_AT,
    PAIRS,
    PLACINGS,
    RESTING,
    RESTING_CUTOFF,
    SETTLED_AT,
    VERSION,
    ListArrays,
)
from drake_geom_ros.geometry._proximity.near.grids import ROW_BITS, SECOND_ROW, rename_rows
from drake_geom_ros.geometry._proximity.near.making import FEW
from drake_geom_ros.geometry._proximity.near.neighbour_list import OF_PAIRS, NeighbourList
from drake_geom_ros.geometry._proximity.near.skins import WIDEST_SKIN
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def following(former: NeighbourList, world: World, change: RowChange) -> NeighbourList:
    """Return the list of a world with changed rows; ``former`` must not be used afterwards."""
    near = NeighbourList(world, former.unlimited, former)
    places = change.places(len(former.arrays.is_plane))
    has_pairs = former.arrays.memory.shape[1] == near.arrays.memory.shape[1]
    if has_pairs:
        _keep_pairs(former, near, places)
    if near.boxes is former.boxes and _keep_resting(former, near, places, world, change.new):
        if not change.appends_to(len(places)):
            rename_rows(near.boxes[1], places)
        if has_pairs:
            _keep_candidates(former.arrays, near.arrays, places, world, change)
    near.replace()
    return near


def _keep_pairs(former: NeighbourList, near: NeighbourList, places: Indices) -> None:
    """Take over the pairs of a former list by the places of its rows now, -1: it is gone."""
    before, count = former.arrays, former.count
    pairs, slots = places[former.pairs], former.slots.copy()
    is_kept = (pairs >= 0).all(axis=1)
    kept, gone = pairs[is_kept], slots[~is_kept]
    before.pairs[: len(kept)], before.slots[: len(kept)] = kept, slots[is_kept]
    before.codes[: len(kept)] = kept[:, 0] << ROW_BITS | kept[:, 1]
    free = int(before.numbers[FREE])
    before.free[free : free + len(gone)] = gone
    of_slots = {name: getattr(before, name) for name in (*OF_PAIRS, 'free')}
    near.arrays = near.arrays._replace(**of_slots)
    near.arrays.numbers[[PAIRS, FREE]] = count - len(gone), free + len(gone)


def _keep_resting(
    former: NeighbourList, near: NeighbourList, places: Indices, world: World, new: Indices
) -> bool:
    """Take over the pairs of resting bodies, as ``_keep_pairs`` does; return whether it can be.

    It cannot where anchored bodies that came lately have become too many to count as active.
    """
    before, stays = former.arrays, places >= 0
    active = near.arrays.active.copy()
    active[places[stays]] = before.active[stays]
    active[new] = ~near.arrays.is_plane[new]
    late = active & world.anchored
    late[world.newcomers] = False
    if late.any():
        return False
    near.arrays.active[:] = active
    codes = _renamed(before.resting[: before.numbers[RESTING]], places)
    before.resting[: len(codes)] = codes
    near.arrays = near.arrays._replace(resting=before.resting)
    for name in (MADE_AT, SETTLED_AT, ACTIVE_THEN):
        near.arrays.numbers[name] = before.numbers[name]
    near.arrays.numbers[RESTING] = len(codes)
    near.arrays.lengths[RESTING_CUTOFF] = before.lengths[RESTING_CUTOFF]
    return True


def _keep_candidates(
    before: ListArrays, arrays: ListArrays, places: Indices, world: World, change: RowChange
) -> None:
    """Take over the candidate pairs of a former list, and add those of the bodies that came.

    Lists of few bodies, and of all pairs, are made in less time than this takes.
    """
    cutoff = float(before.lengths[LIST_CUTOFF])
    is_made = arrays.lengths[RESTING_CUTOFF] >= cutoff >= 0.0
    is_placed = before.numbers[PLACINGS] == world.placings
    is_large = min(len(before.is_plane), len(arrays.is_plane)) > FEW
    if not (is_made and is_placed and is_large) or arrays.is_plane[change.new].any():
        return
    if not change.is_in_place:
        for name in ('lowers', 'uppers'):
            box_ends = getattr(arrays, name)[: len(places)]
            change.in_place(box_ends, 0.0)
    parts = [_renamed(before.candidates[: before.numbers[CANDIDATE_COUNT]], places)]
    for row in change.new.tolist():
        others = _rows_near(row, arrays, world, cutoff)
        parts.append(np.minimum(others, row) << ROW_BITS | np.maximum(others, row))
    codes = np.sort(np.concatenate(parts))
    if len(codes) >= len(arrays.candidates):
        return
    arrays.candidates[: len(codes)] = codes
    arrays.numbers[CANDIDATE_COUNT] = len(codes)
    for place in (CHECKED_AT, PLACINGS):
        arrays.numbers[place] = before.numbers[place]
    arrays.numbers[VERSION] = -1  # the filters are asked again
    arrays.lengths[[LIST_CUTOFF, ASKED_CUTOFF]] = cutoff


def _renamed(codes: Indices, places: Indices) -> Indices:
    """Return the codes of the pairs that stay, by the places of their rows now."""
    first, second = places[codes >> ROW_BITS], places[codes & SECOND_ROW]
    stays = (first >= 0) & (second >= 0)
    return first[stays] << ROW_BITS | second[stays]


def _rows_near(row: int, arrays: ListArrays, world: World, cutoff: float) -> Indices:
    """Return the rows of bodies whose boxes are within a cutoff [m] of that of a body that came.

    The box of a body that moves has a skin, also the one that is set here. Half spaces are near
    everything; two anchored bodies are no pair.
    """
    is_fixed = world.geometries.frames == 0 if arrays.planes.size else world.anchored
    skin = 0.0 if is_fixed[row] else WIDEST_SKIN * float(world.outer_radii[row])
    p, side = world.p_WGs[row], world.half_extents[row] + skin
    lowers, uppers = arrays.lowers, arrays.uppers
    lowers[row], uppers[row] = p - side, p + side
    box = p - side - cutoff, p + side + cutoff
    movable = world.movable
    near = _overlapping(movable, lambda rows, axis: (lowers[rows, axis], uppers[rows, axis]), box)
    planes = arrays.planes[~(is_fixed[arrays.planes] & is_fixed[row])]
    parts = [near[(near != row) & ~arrays.is_plane[near]], planes]
    if not is_fixed[row]:
        others = np.ones(len(is_fixed), dtype=np.bool_)
        others[movable] = others[arrays.planes] = False
        parts.append(_overlapping(np.flatnonzero(others), partial(_ends, world), box))
    return np.concatenate(parts)


def _ends(world: World, rows: Indices, axis: int) -> tuple[Floats, Floats]:
    """Return the ends [m] of the boxes of bodies along an axis."""
    centres, sides = world.p_WGs[rows, axis], world.half_extents[rows, axis]
    return centres - sides, centres + sides


def _overlapping(
    rows: Indices,
    ends: Callable[[Indices, int], tuple[Floats, Floats]],
    box: tuple[Floats, Floats],
) -> Indices:
    """Return the rows whose boxes overlap with another, or may, within rounding of ends."""
    noise = 4.0 * EPS
    for axis, (lower, upper) in enumerate(zip(*np.array(box).tolist(), strict=True)):
        low, up = ends(rows, axis)
        is_above = up + noise * np.abs(up) >= lower - noise * abs(lower)
        is_below = low - noise * np.abs(low) <= upper + noise * abs(upper)
        rows = rows[is_above & is_below]  # few: the next axis looks at these alone
    return rows
