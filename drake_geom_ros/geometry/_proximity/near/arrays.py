"""The arrays of a neighbour list for compiled functions, and names of their places."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._proximity.runtime.handles import (
    BitRows,
    Bits,
    Flags,
    IndexPairs,
    Integers,
    Reals,
    Rows,
    SingleRows,
    Vectors,
    taker,
)

# Return codes of ``bring_up_to_date``.
STANDS = 0  # the list is still valid
MADE = 1
LACKS_CODES = 2  # NEEDED of them
LACKS_RESTING = 3
LACKS_SLOTS = 4
LACKS_GRIDS = 5  # the code for many bodies is not compiled yet

# Places of ``ListArrays.numbers``.
PAIRS = 0  # of the list
CONSIDERED = 1  # pairs before the filters
FREE = 2  # slots
NEEDED = 3
HAS_KERNELS = 4  # 1 once the kernels of its pairs are known to be compiled
VERSION, PLACINGS = 5, 6  # versions of the filters, and of the bodies that wait for a first pose
MADE_AT = 7  # revision of the world in which the list was made
CHECKED_AT = 8  # revision in which all bodies were last verified to be in their boxes
SETTLED_AT = 9  # revision in which resting bodies were put into their cells
ACTIVE_THEN = 10  # number of bodies that did not rest then
RESTING = 11  # pairs of bodies that rest
CANDIDATE_COUNT = 12  # codes of pairs before the filters; negative: the code of what is lacking
NUMBERS = 13
# Places of ``ListArrays.lengths``.
LIST_CUTOFF = 0  # [m] the list has every pair within this distance; below 0: not made yet
ASKED_CUTOFF = 1  # [m] the largest cutoff requested since the list was made
RESTING_CUTOFF = 2  # [m] the cutoff of the resting pairs
FILTERING = 3  # [s] time of the filters when the list was made
ORIGIN = 4  # [m] three places: the origin of the ``sides`` of boxes
LENGTHS = 7


class ListArrays(NamedTuple):
    """Arrays of a neighbour list of n geometries, with capacity for m pairs."""

    numbers: Integers  # (NUMBERS,)
    lengths: Reals  # (LENGTHS,)
    # Of geometries (n,).
    is_plane: Flags
    active: Flags  # neither a plane nor anchored nor known to rest
    lowers: Vectors  # [m] the boxes for which the list stands
    uppers: Vectors
    paddings: Reals  # [m]
    rows: Integers
    rest_paddings: Reals  # [m]
    tally: Integers  # (n + 1,)
    sides: SingleRows  # (6, n + LANES) [m]
    planes: Integers  # (p,) rows
    no_bodies: Flags  # (0,)
    # Codes of pairs: all candidates (c,), scratch to sort and filter them, and pairs of resting
    # bodies. The last place is not used (see ``grids.put_code``).
    candidates: Integers
    sorting: Integers
    resting: Integers
    # Of the list.
    codes: Integers  # (m,)
    pairs: IndexPairs  # (m, 2) rows of the world, i < j
    slots: Integers  # (m,)
    new_slots: Integers  # (m,)
    free: Integers  # (m,) slots
    hits: Integers  # (m,) scratch for numbers of pairs
    by_grids: Integers  # (1,) an address; 0 if not compiled yet
    memory: Rows  # (m, SLOT_WIDTH or more) by slots, see ``pairs.slots.empty_memory``


class FilterArrays(NamedTuple):
    """Arrays that determine whether a pair of rows of the world is filtered."""

    slots: Integers  # (n,) of the geometries
    bits: Bits
    bodies: Integers
    bit_rows: BitRows


list_of = taker(ListArrays)
filters_of = taker(FilterArrays)
