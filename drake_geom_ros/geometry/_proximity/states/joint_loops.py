"""Checks of single states of one world: its pairs, its joints, and all scratch arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SLOT_WIDTH
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH
from drake_geom_ros.geometry._proximity.pairs.slots import NO_QUEUE
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.handles import handle_of
from drake_geom_ros.geometry._proximity.states.groups import (
    Groups,
    groups_of,
    moved_together,
    put_boxes_of,
)
from drake_geom_ros.geometry._proximity.states.joint_checks import (
    PARAMETERS,
    CheckArrays,
    check_states,
    least_of_state,
)
from drake_geom_ros.geometry._proximity.world.joint_poses import JointChain
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# A verdict, the distance and error bound of a pair [m], and its two ids.
Least = tuple[int, float, float, int, int]


class JointLoops:
    """Verdicts about joint values (c,) of a world of its own, for one thread.

    ``rows`` (n,) are the frames that are links of the chain and move with it; others stay.
    ``limits`` (2, c) are those of the joint values, lower and upper.
    """

    def __init__(
        self,
        world: World,
        pairs: Indices,
        rows: Indices,
        chain: JointChain,
        limits: Floats,
        gap: float,
        margin: float | None,
        paddings: Floats,
        rounded: float,
    ) -> None:
        """Take arrays that must not change.

        Without a ``margin`` [m] states are near if a pair overlaps. ``paddings`` (n,) [m] enlarge
        the geometries for a margin; ``rounded`` is the rounding [-] of a distance of theirs.
        """
        if gap < np.inf:
            compile_rows(table_rows(*world.geometries.types[pairs].T))
        world.update()
        numbers = moved_together(world, rows)
        groups = groups_of(numbers, pairs)
        put_boxes_of(tuple(groups), world.handle)
        self.world = world  # kept alive, since the handle refers to its arrays
        self.arrays = _arrays(world, pairs, rows, chain, limits, groups, numbers)
        widest = 2.0 * float(paddings.max(initial=0.0))
        values = gap, margin or 0.0, margin is None, widest, rounded if widest > 0.0 else 0.0
        self.arrays.parameters[:] = values
        self.arrays.paddings[:] = paddings
        self.handle = handle_of(self.arrays)
        self._verdict = np.zeros(1, dtype=np.int64)  # scratch for one

    def verdict(self, state: Floats) -> int:
        """Return the verdict about a contiguous state (1, c)."""
        return check_states(self.handle, state, self._verdict)

    def verdicts(self, states: Floats) -> Indices:
        """Return the verdicts (N,) about contiguous states (N, c)."""
        verdicts = np.empty(len(states), dtype=np.int64)
        check_states(self.handle, states, verdicts)
        return verdicts

    def least(self, state: Floats) -> Least:
        """Return the pair of the least lower bound in a state (1, c), ignoring joint limits."""
        return least_of_state(self.handle, state)


def _arrays(
    world: World,
    pairs: Indices,
    rows: Indices,
    chain: JointChain,
    limits: Floats,
    groups: Groups,
    numbers: Indices,
) -> CheckArrays:
    """Return the arrays of checks; ``numbers`` (n,) are the group numbers of geometries."""
    moving = np.isin(np.arange(len(world.frames.ids)), rows)
    for frame, parent in enumerate(world.frames.parents.tolist()):
        moving[frame] |= moving[parent]
    movers = np.unique(numbers[moving[world.geometries.frames]])
    count, most = len(rows), len(pairs)
    return CheckArrays(
        lower=np.ascontiguousarray(limits[0]),
        upper=np.ascontiguousarray(limits[1]),
        **chain._asdict(),
        poses=np.zeros((1, count, 7)),
        rows=rows,
        Xs=np.empty((count, POSE_WIDTH)),
        world=world.handle,
        pairs=pairs,
        paddings=np.zeros(world.geometry_count),
        movers=movers.astype(np.int64),
        firsts=groups.firsts,
        members=groups.members,
        group_pairs=groups.pairs,
        starts=groups.starts,
        numbers=groups.numbers,
        centres=groups.centres,
        halves=groups.halves,
        separations=groups.separations,
        kernels=ADDRESSES,
        parameters=np.zeros(PARAMETERS),
        bounds=np.empty(most),
        order=np.empty(most, dtype=np.int64),
        last=np.full(1, -1, dtype=np.int64),
        one=np.zeros((1, 2), dtype=np.int64),
        slot=np.zeros(1, dtype=np.int64),
        hits=np.zeros(1, dtype=np.int64),
        memory=np.zeros((1, SLOT_WIDTH)),
        counts=np.zeros(COUNTS, dtype=np.int64),
        waiting=NO_QUEUE[0],
        distances=NO_QUEUE[1],
        never=np.zeros(1, dtype=np.int64),
        found_counts=np.zeros(1, dtype=np.int64),
        ids=np.zeros((1, 1, 2), dtype=np.int64),
        out=np.zeros((1, 1, BATCH_WIDTH)),
    )
