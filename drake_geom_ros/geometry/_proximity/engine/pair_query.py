"""A query in one compiled call: world updated, list made, narrow phase run, rows gathered.

Each compiled call and each array that it is given takes Python a tenth of a microsecond and more,
which is most of the time of a query in a small scene. Where something is to be done that compiled
code cannot do, the call ends early and says what; it is made again after that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.addresses import has_each
from drake_geom_ros.geometry._proximity.near import arrays as list_arrays
from drake_geom_ros.geometry._proximity.near.arrays import (
    HAS_KERNELS,
    LACKS_SLOTS,
    MADE,
    PAIRS,
    FilterArrays,
    ListArrays,
    filters_of,
    list_of,
)
from drake_geom_ros.geometry._proximity.near.grids import Boxes, code_of
from drake_geom_ros.geometry._proximity.near.making import bring_up_to_date
from drake_geom_ros.geometry._proximity.pairs.answer_rows import gather_answers
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import near_pairs
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.quick_contacts import quick_contact
from drake_geom_ros.geometry._proximity.report import (
    ANSWERED,
    COMPILED,
    CONSIDERED,
    CONTACT_A,
    CONTACT_B,
    FILTERING,
    LIST_MADE,
    LISTED,
    LISTED_PAIRS,
    ReportArrays,
    pose_world,
    report_of,
)
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Handle,
    HandleField,
    Reals,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of

# What is asked for.
LIST = 0  # no more than the list, and the kernels of its pairs
CANDIDATES = 1  # its pairs whose boxes are within the cutoff
CONTACT = 2  # one pair that the query is about
ANSWERS = 3  # all of them, and their rows

LACKS_KERNELS = (
    LACKS_SLOTS + 1
)  # of the pairs of the list; the others are those of ``near.arrays``


class Hands(NamedTuple):
    """The handles of all that a cycle works on."""

    world: HandleField
    near: HandleField
    moving: HandleField
    resting: HandleField
    filters: HandleField
    report: HandleField
    kernels: HandleField  # the addresses of the pair table
    asked: Reals  # (ASKED,)


# Places of ``Hands.asked``: those of ``slots.Query``, what is asked for, under which version of
# the filters.
LEVEL_GAP, CUTOFF, PENETRATING, MODE, VERSION = range(5)
ASKED = 5

_hands_of = taker(Hands)
_boxes_of = taker(Boxes)


@compiled
def run_cycle(
    hands: Handle,
    lacking: int,
    stale: bool,
    revision: int,
    X_PFs: Floats,
    answers: Floats,
) -> int:
    """Do what a query does; return how many pairs it is about, or minus what is lacking.

    ``hands`` is the handle of ``Hands``. What was ``lacking`` (0: nothing) is there now, and the
    cycle goes on there. If it is ``stale``, the world gets the poses ``X_PFs`` (n, POSE_WIDTH) of
    the frames that it was told of, and is updated to this ``revision``. The numbers of the pairs
    are written to the list's ``hits``, and their ``answers`` (k, ANSWER_WIDTH) if there is room
    for all.
    """
    hands = _hands_of(hands)
    level_gap, cutoff, mode = hands.asked[LEVEL_GAP], hands.asked[CUTOFF], hands.asked[MODE]
    world, near, report = world_of(hands.world), list_of(hands.near), report_of(hands.report)
    moments = report.moments
    if lacking == 0:
        pose_world(hands.world, report, stale, revision, X_PFs)
        if mode == CONTACT and _is_quick_contact(
            world, filters_of(hands.filters), report, level_gap
        ):
            return 1
    if lacking != LACKS_KERNELS:
        done = bring_up_to_date(
            near,
            world,
            _boxes_of(hands.moving),
            _boxes_of(hands.resting),
            filters_of(hands.filters),
            revision,
            int(hands.asked[VERSION]),
            world.placings[0],
            cutoff,
        )
        if done > MADE:
            return -done
        report.told[LIST_MADE] = done
        report.told[CONSIDERED] = near.numbers[list_arrays.CONSIDERED]
        report.told[LISTED_PAIRS] = near.numbers[PAIRS]
        moments[FILTERING] = near.lengths[list_arrays.FILTERING] if done == MADE else 0.0
        moments[LISTED] = moments[COMPILED] = moments[ANSWERED] = now()
        if mode != CANDIDATES and not math.isinf(level_gap) and near.numbers[HAS_KERNELS] == 0:
            if not has_each(world.types, near.pairs, near.numbers[PAIRS], report.compiled):
                return -LACKS_KERNELS
            near.numbers[HAS_KERNELS] = 1
    count = near.numbers[PAIRS]
    if mode > LIST:
        query = level_gap, cutoff, hands.asked[PENETRATING] != 0.0
        count = _answer(hands.kernels, hands.world, near, report, revision, query, mode)
    if mode == ANSWERS and count <= answers.shape[0]:
        hits = part(near.hits, 0, count)
        rows = near.pairs, near.slots, near.memory
        gather_answers(hits, *rows, level_gap, hands.world, answers)
    moments[ANSWERED] = now()
    return count


@inlined
def _is_quick_contact(
    world: WorldArrays, filters: FilterArrays, report: ReportArrays, level_gap: float
) -> bool:
    """Tell whether a contact was seen without a list, and report so."""
    told, moments = report.told, report.moments
    a, b = quick_contact(world, filters, level_gap, told[CONTACT_A], told[CONTACT_B])
    if a < 0:
        return False
    told[CONTACT_A], told[CONTACT_B] = a, b
    told[LIST_MADE], told[CONSIDERED], told[LISTED_PAIRS] = 0, 0, 0
    report.counts[:] = 0
    moments[LISTED] = moments[COMPILED] = moments[ANSWERED] = now()
    moments[FILTERING] = 0.0
    return True


@inlined
def _place_of_contact(near: ListArrays, report: ReportArrays) -> int:
    """Return the number of the pair in which the last contact was, or of the one after it."""
    a, b = report.told[CONTACT_A], report.told[CONTACT_B]
    low, high = 0, near.numbers[PAIRS]
    while low < high:
        middle = (low + high) // 2
        if near.codes[middle] < code_of(a, b):
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def _answer(
    kernels: Addresses,
    world: Handle,
    near: ListArrays,
    report: ReportArrays,
    revision: int,
    query: tuple[float, float, bool],
    mode: float,
) -> int:
    """Fill in the hits of the list's pairs; return how many there are."""
    count = near.numbers[PAIRS]
    pairs = near.pairs[:count]
    if mode == CANDIDATES:
        report.counts[:] = 0
        _, cutoff, _ = query
        return near_pairs(pairs, world, cutoff, near.hits)
    # Where there was a contact there still is one, mostly.
    first = _place_of_contact(near, report) if mode == CONTACT else -1
    found = answer_pairs(
        kernels,
        pairs,
        part(near.slots, 0, count),
        near.memory,
        world,
        revision,
        query,
        first,
        (report.waiting, report.distances),
        near.hits,
        report.counts,
    )
    if mode == CONTACT and found:
        report.told[CONTACT_A] = near.pairs[near.hits[0], 0]
        report.told[CONTACT_B] = near.pairs[near.hits[0], 1]
    return found
