"""The arrays of a neighbour list, as compiled functions take them, and what their places mean."""

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

# What ``bring_up_to_date`` tells.
STANDS = 0
MADE = 1
LACKS_CODES = 2  # there are NEEDED of them
LACKS_RESTING = 3
LACKS_SLOTS = 4
LACKS_GRIDS = 5  # the code for many bodies, which is not compiled yet

# Places of ``ListArrays.numbers``.
PAIRS = 0  # of the list
CONSIDERED = 1  # pairs before the filters
FREE = 2  # slots
NEEDED = 3
HAS_KERNELS = 4  # 1 once those of its pairs are known to be compiled
VERSION, PLACINGS = 5, 6  # of the filters, and of who waits for a first pose
MADE_AT = 7  # revision of the world in which the list was made
CHECKED_AT = 8  # in which everybody was last seen in the boxes
SETTLED_AT = 9  # in which those that rest were put into their cells
ACTIVE_THEN = 10  # how many did not rest
RESTING = 11  # pairs of bodies that rest
FOUND = 12  # codes of pairs, before the filters; minus what is lacking
NUMBERS = 13
# Places of ``ListArrays.lengths``.
LIST_CUTOFF = 0  # [m] the list holds every pair this near; below 0: not made yet
ASKED_CUTOFF = 1  # [m] the largest cutoff asked for since the list was made
RESTING_CUTOFF = 2  # [m] that the resting pairs were made for
FILTERING = 3  # [s] that the filters took when the list was made
ORIGIN = 4  # [m] three places: where the ``sides`` of boxes are measured from
LENGTHS = 7


class ListArrays(NamedTuple):
    """A neighbour list of n geometries with room for m pairs."""

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
    nobody: Flags  # (0,)
    # Codes of pairs: all that were found (c,), room to sort and to filter them, and of those that
    # rest. The last place is none (see ``grids.put_code``).
    found: Integers
    sorting: Integers
    resting: Integers
    # Of the list.
    codes: Integers  # (m,)
    pairs: IndexPairs  # (m, 2) rows of the world, i < j
    slots: Integers  # (m,)
    new_slots: Integers  # (m,)
    free: Integers  # (m,) slots
    hits: Integers  # (m,) room for numbers of pairs
    by_grids: Integers  # (1,) an address; 0 where that is not compiled yet
    memory: Rows  # (m, SLOT_WIDTH or more) by slots, see ``pairs.slots.empty_memory``


class FilterArrays(NamedTuple):
    """What tells whether a pair of rows of the world is filtered."""

    slots: Integers  # (n,) of the geometries
    bits: Bits
    bodies: Integers
    bit_rows: BitRows


list_of = taker(ListArrays)
filters_of = taker(FilterArrays)
