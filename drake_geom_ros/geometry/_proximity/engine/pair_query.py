"""One compiled call for a query: world update, neighbour list, narrow phase, rows of answers.

Each compiled call, and each array passed to it, costs Python a tenth of a microsecond or more,
which is most of the time of a query in a small scene. Where compiled code lacks something that
only Python can provide, the call returns early with a code for it and is then resumed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.addresses import has_each
from drake_geom_ros.geometry._proximity.near import arrays as list_arrays
from drake_geom_ros.geometry._proximity.near.arrays import (
    HAS_KERNELS,
    LACKS_GRIDS,
    MADE,
    PAIRS,
    FilterArrays,
    ListArrays,
    filters_of,
    list_of,
)
from drake_geom_ros.geometry._proximity.near.grids import code_of
from drake_geom_ros.geometry._proximity.near.making import bring_up_to_date
from drake_geom_ros.geometry._proximity.pairs.answer_rows import gather_answers
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import near_pairs
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.quick_contacts import quick_contact
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT
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

# Modes of a query.
LIST = 0  # only the neighbour list, and the kernels of its pairs
CANDIDATES = 1  # its pairs whose boxes are within the cutoff
CONTACT = 2  # the first hit
ANSWERS = 3  # all hits, and their rows

LACKS_KERNELS = LACKS_GRIDS + 1  # of the pairs of the list; the others are those of list_arrays


class CycleHandles(NamedTuple):
    """The handles of all arrays that a cycle works on."""

    world: HandleField
    near: HandleField
    moving: HandleField
    resting: HandleField
    filters: HandleField
    report: HandleField
    kernels: HandleField  # the addresses of the pair table
    parameters: Reals  # (PARAMETER_COUNT,)


# Places of ``CycleHandles.parameters``: the fields of ``slots.Query``, the mode, and the version
# of the filters.
LEVEL_GAP, CUTOFF, PENETRATING, MODE, VERSION = range(5)
PARAMETER_COUNT = 5

_handles_of = taker(CycleHandles)


@compiled
def run_cycle(
    handles: Handle,
    lacking: int,
    stale: bool,
    revision: int,
    X_PFs: Floats,
    answers: Floats,
) -> int:
    """Run a whole query; return the number of hits, or the negative code of what is lacking.

    ``handles`` is the handle of ``CycleHandles``. ``lacking`` is the code of what the previous
    call lacked (0: nothing) and Python has provided since; the cycle resumes there. A ``stale``
    world gets the poses ``X_PFs`` (n, POSE_WIDTH) of its pending frames and is updated to this
    ``revision``. The numbers of the pairs are written to the list's ``hits``, and their
    ``answers`` (k, ANSWER_WIDTH) if all fit.
    """
    handles = _handles_of(handles)
    level_gap, cutoff, mode = (
        handles.parameters[LEVEL_GAP],
        handles.parameters[CUTOFF],
        handles.parameters[MODE],
    )
    world, near, report = world_of(handles.world), list_of(handles.near), report_of(handles.report)
    moments = report.moments
    if lacking == 0:
        pose_world(handles.world, report, stale, revision, X_PFs)
        if mode == CONTACT and _is_quick_contact(world, filters_of(handles.filters), report):
            return 1
    if lacking != LACKS_KERNELS:
        done = bring_up_to_date(
            near,
            world,
            (handles.near, handles.world, handles.moving, handles.resting),
            filters_of(handles.filters),
            revision,
            int(handles.parameters[VERSION]),
            world.placings[0],
            cutoff,
        )
        if done > MADE:
            return -done
        report.summary[LIST_MADE] = done
        report.summary[CONSIDERED] = near.numbers[list_arrays.CONSIDERED]
        report.summary[LISTED_PAIRS] = near.numbers[PAIRS]
        moments[FILTERING] = near.lengths[list_arrays.FILTERING] if done == MADE else 0.0
        moments[LISTED] = moments[COMPILED] = moments[ANSWERED] = now()
        if mode != CANDIDATES and not math.isinf(level_gap) and near.numbers[HAS_KERNELS] == 0:
            if not has_each(world.types, near.pairs, near.numbers[PAIRS], report.compiled):
                return -LACKS_KERNELS
            near.numbers[HAS_KERNELS] = 1
    count = near.numbers[PAIRS]
    if mode > LIST:
        query = level_gap, cutoff, handles.parameters[PENETRATING] != 0.0
        count = _answer(handles.kernels, handles.world, near, report, revision, query, mode)
    if mode == ANSWERS and count <= answers.shape[0]:
        hits = part(near.hits, 0, count)
        rows = near.pairs, near.slots, near.memory
        gather_answers(hits, *rows, level_gap, handles.world, answers)
    moments[ANSWERED] = now()
    return count


@inlined
def _is_quick_contact(world: WorldArrays, filters: FilterArrays, report: ReportArrays) -> bool:
    """Return whether a contact is evident without a neighbour list; write it to the report."""
    summary, moments = report.summary, report.moments
    a, b = quick_contact(world, filters, summary[CONTACT_A], summary[CONTACT_B])
    if a < 0:
        return False
    summary[CONTACT_A], summary[CONTACT_B] = a, b
    summary[LIST_MADE], summary[CONSIDERED], summary[LISTED_PAIRS] = 0, 0, 0
    report.counts[:] = 0
    moments[LISTED] = moments[COMPILED] = moments[ANSWERED] = now()
    moments[FILTERING] = 0.0
    return True


@inlined
def _place_of_contact(near: ListArrays, report: ReportArrays) -> int:
    """Return the list index of the pair of the last contact, or of the pair following it."""
    a, b = report.summary[CONTACT_A], report.summary[CONTACT_B]
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
    """Write the hits among the listed pairs; return how many there are."""
    count = near.numbers[PAIRS]
    pairs = near.pairs[:count]
    if mode == CANDIDATES:
        report.counts[:] = 0
        _, cutoff, _ = query
        return near_pairs(pairs, world, cutoff, near.hits)
    search = EVERY_HIT
    if mode == CONTACT:  # the pair of the last contact is the likeliest one
        search = (_place_of_contact(near, report), 0.0)
    hit_count = answer_pairs(
        kernels,
        pairs,
        part(near.slots, 0, count),
        near.memory,
        world,
        revision,
        query,
        search,
        (report.waiting, report.distances),
        near.hits,
        report.counts,
    )
    if mode == CONTACT and hit_count:
        report.summary[CONTACT_A] = near.pairs[near.hits[0], 0]
        report.summary[CONTACT_B] = near.pairs[near.hits[0], 1]
    return hit_count
