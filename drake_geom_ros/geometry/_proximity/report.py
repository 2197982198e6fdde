"""Report of a query about its own work, as arrays that compiled code writes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels import addresses as kernel_table
from drake_geom_ros.geometry._proximity.kinds import OPEN
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Flags,
    Handle,
    Integers,
    Reals,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.pose_update import set_poses, update

# Places of ``ReportArrays.summary``.
FRAMES_MOVED, BODIES_MOVED = 0, 1
LIST_MADE = 2
CONSIDERED, LISTED_PAIRS = 3, 4  # pairs before and after the filters
CONTACT_A, CONTACT_B = 5, 6  # rows of the pair in which the last contact was; -1: none yet
SUMMARY_WIDTH = 7
# Places of ``ReportArrays.moments`` [s]: the end of each step, where the next one begins; and
# the durations of filtering and of cache lookups.
BEGUN, POSED, LISTED, COMPILED, ANSWERED, FILTERING, KNOWING = range(7)
MOMENTS = 7


class ReportArrays(NamedTuple):
    """Counts and times of the work that a query did."""

    counts: Integers  # (COUNTS,) of ``narrow_phase``
    summary: Integers  # (SUMMARY_WIDTH,)
    moments: Reals  # (MOMENTS,)
    # No pair waits: see ``slots.Queue``.
    waiting: Integers  # (0,)
    distances: Reals  # (0,)
    compiled: Flags  # the rows of the pair table


report_of = taker(ReportArrays)


def empty_report() -> ReportArrays:
    """Return the report of an engine that has answered no query."""
    return ReportArrays(
        counts=np.zeros(COUNTS, dtype=np.int64),
        summary=np.zeros(SUMMARY_WIDTH, dtype=np.int64),
        moments=np.zeros(MOMENTS),
        waiting=np.zeros(0, dtype=np.int64),
        distances=np.zeros(0),
        compiled=kernel_table.COMPILED_ROWS,
    )


@inlined
def pose_world(
    world: Handle,
    report: ReportArrays,
    stale: bool,
    revision: int,
    X_PFs: Floats,
) -> None:
    """Pose a world as ``run_cycle`` does, and write counts and times to the report."""
    summary, moments = report.summary, report.moments
    moments[BEGUN] = now()
    summary[FRAMES_MOVED], summary[BODIES_MOVED] = 0, 0
    if stale:
        if X_PFs.shape[0] > 0:
            set_poses(part(world_of(world).named, 0, X_PFs.shape[0]), X_PFs, world)
        summary[FRAMES_MOVED], summary[BODIES_MOVED] = update(world, revision)
    moments[POSED], moments[KNOWING] = now(), 0.0


# Counts of ``answer_pairs``; the pairs computed by each method follow, by its number.
FAR = 0
CACHED = 1
POSTPONED = 2
WIDE = 3
BY_METHOD = 4
COUNTS = BY_METHOD + OPEN + 1
