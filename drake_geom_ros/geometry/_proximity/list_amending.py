"""The amending of a near list: only those that left their boxes are looked at anew.

It is for few bodies (``all_pairs``), a few of which are fast. The boxes, and the codes of all
pairs that were found, come out as if all had been looked at with the boxes that there are now.
"""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.all_pairs import look_at_one, set_side
from drake_geom_ros.geometry._proximity.broadphase import rows_of
from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.views import part
from drake_geom_ros.geometry._proximity.list_arrays import FOUND
from drake_geom_ros.geometry._proximity.list_boxes import set_box
from drake_geom_ros.geometry._proximity.list_keeping import sort


@compiled
def amend(near, world, leavers, distance):  # type: ignore[no-untyped-def]
    """Replace the codes of pairs of the first ``leavers`` of ``rows``; return how many there are.

    All are in order then, unless there are more than there is room for.
    """
    for k in range(leavers):
        g = near.rows[k]
        near.has_left[g] = near.active[g] = True
        set_box(near, world, g, True, distance)
        set_side(near, g, distance)
    staying = _without_leavers(near)
    count = staying
    for k in range(leavers):
        count = look_at_one(near, world, near.rows[k], 0, distance, count)
    for k in range(leavers):
        near.has_left[near.rows[k]] = False
    if count < near.found.size:
        new = part(near.found, staying, count)
        sort(new, near.sorting, near.tally, near.active.size)
        _merge(near.found, staying, count, near.sorting)
    return count


@inlined
def _without_leavers(near):  # type: ignore[no-untyped-def]
    """Keep the codes of pairs of which nobody has left; return how many there are."""
    found, count = near.found, 0
    for k in range(near.numbers[FOUND]):
        code = found[k]
        i, j = rows_of(code)
        found[count] = code
        count += not (near.has_left[i] or near.has_left[j])
    return count


@inlined
def _merge(codes, staying, count, room):  # type: ignore[no-untyped-def]
    """Merge the first ``staying`` codes and those behind them; both are in order."""
    new = count - staying
    for k in range(new):
        room[k] = codes[staying + k]
    while new > 0:  # the place that is filled is behind all those that are still to be moved
        count -= 1
        if staying > 0 and codes[staying - 1] > room[new - 1]:
            staying -= 1
            codes[count] = codes[staying]
        else:
            new -= 1
            codes[count] = room[new]
