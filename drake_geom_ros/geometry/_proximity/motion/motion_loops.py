"""Motion checks of one world: its pairs, the moving frames or joints, and all scratch arrays."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SLOT_WIDTH
from drake_geom_ros.geometry._proximity.motion.arrays import (
    BOUND_WIDTH,
    COUNT_WIDTH,
    EDGE,
    EVALUATIONS,
    FLAG_COUNT,
    IGNORED,
    IGNORES,
    JOINTS,
    KIND,
    LEVEL_GAP,
    LOWER_BOUND,
    MIN_DISTANCE,
    MOST,
    MOST_PADDING,
    MOVE_WIDTH,
    NO_ROOM,
    OFFSET,
    OUTCOME_WIDTH,
    PAIR,
    PARAMETER_COUNT,
    QUICK,
    RECORD_WIDTH,
    SEEN,
    SEEN_EDGE,
    SEEN_PAIR,
    SEEN_TIME,
    T0,
    T1,
    TIME_TOLERANCE,
    VALUE_ROWS,
    MotionArrays,
)
from drake_geom_ros.geometry._proximity.motion.edges import check_edges, row_of_pair
from drake_geom_ros.geometry._proximity.motion.joint_path import NO_VALUES, JointPath
from drake_geom_ros.geometry._proximity.motion.speeds import speeds_of_geometries
from drake_geom_ros.geometry._proximity.motion.tree import (
    common_nodes,
    offsets_of,
    reaches_of,
    reaches_of_groups,
    tree_of,
)
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH, PairBatch
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, handle_of
from drake_geom_ros.geometry._proximity.states.groups import Groups, groups_of, moved_together
from drake_geom_ros.geometry._proximity.tolerances import LEAST_TIME_TOLERANCE
from drake_geom_ros.geometry._proximity.world.joint_poses import (
    JointChain,
)
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_SPANS = 128  # one per halving may wait: more than floats in [0, 1] can be halved
_FIRST_ENTRIES = 1024  # initial capacity


class MotionOutcome(NamedTuple):
    """Verdict about a motion, and its details; indices of pairs are -1 where there is none."""

    verdict: int
    edge: int  # at which the search ended
    t0: float
    t1: float
    pair: int  # the pair that touches at t1, or of which nothing is proved from t0 on
    lower_bound: float  # [m] the least of all proved lower bounds
    seen: float  # [m] the least distance that was seen
    seen_edge: int
    seen_time: float
    seen_pair: int
    evaluations: int
    ignored: int


class MotionLoops:
    """Checks of motions of a world of its own, for one thread.

    ``rows`` (f,) are the frames that move: by poses or, with a chain, as its links by ``columns``
    of joint values. Others stay. ``paddings`` (n,) [m] are those of the geometries. Another thread
    ends a check by setting ``stop`` (1,).
    """

    def __init__(
        self,
        world: World,
        pairs: Indices,
        rows: Indices,
        paddings: Floats,
        level_gap: float,
        stop: Indices,
        chain: JointChain | None = None,
        columns: int = 0,
    ) -> None:
        if level_gap < math.inf:
            compile_rows(table_rows(*world.geometries.types[pairs].T))
        world.update()
        groups = groups_of(moved_together(world, rows), pairs)
        self._world = world  # kept alive, since the handle refers to its arrays
        self._still: Indices | None = None  # the frames that stay, once they were asked for
        self._arrays = _arrays(world, pairs, rows, paddings, groups, chain, columns)
        self._arrays = self._arrays._replace(stop=stop)
        self._arrays.parameters[LEVEL_GAP] = level_gap
        self._arrays.parameters[MOST_PADDING] = self._arrays.paddings.max(initial=0.0)
        if chain is not None:
            self._arrays.flags[KIND] = JOINTS
        self._handle = handle_of(self._arrays)

    def stand(self, R_PFs: Floats, p_PFs: Floats) -> None:
        """Pose the frames that stay, by R (nf, 3, 3) and p (nf, 3) of all."""
        if self._still is None:
            self._still = np.setdiff1d(np.arange(1, len(p_PFs)), self._arrays.rows)
        still = self._still
        self._world.set_poses(still, R_PFs[still], p_PFs[still])
        self._world.update()
        links = len(self._arrays.X_WLs)
        self._arrays.nodes[links + still, OFFSET] = offsets_of(p_PFs[still])

    def take_shapes(self, other: World) -> None:
        """Take the shapes of a world that differs by these alone, and by poses."""
        world, arrays = self._world, self._arrays
        world.take_shapes(other)
        world.update()
        reaches = reaches_of(world)
        of_groups = reaches_of_groups(reaches, arrays.firsts, arrays.members)
        self._arrays = arrays._replace(
            world=world.handle, reaches=reaches, group_reaches=of_groups
        )
        self._handle = handle_of(self._arrays)

    def drive_by(self, chain: JointChain) -> None:
        """Take the numbers of a chain with the same links and columns as the one at first."""
        for name, array in chain._asdict().items():
            getattr(self._arrays, _NAMES.get(name, name))[:] = array
        roots = np.setdiff1d(np.arange(len(chain.X_WLs)), chain.children)
        self._arrays.nodes[1 + roots, OFFSET] = offsets_of(chain.X_WLs[roots, :3])

    def ask(
        self,
        min_distance: float,
        time_tolerance: float,
        max_evaluations: int,
        *,
        ignores: bool,
    ) -> None:
        """Set the parameters of the following checks."""
        longest = max(time_tolerance, LEAST_TIME_TOLERANCE)
        self._arrays.parameters[[MIN_DISTANCE, TIME_TOLERANCE]] = min_distance, longest
        self._arrays.flags[[MOST, IGNORES, QUICK]] = max_evaluations, int(ignores), 0

    @property
    def handle(self) -> Handle:
        """The handle of the ``MotionArrays``, for other loops on them; valid until they change."""
        return self._handle

    @property
    def skipped(self) -> NDArray[np.bool_]:
        """Flags (k,) of pairs left out; set before a check, and by one that ignores contacts."""
        return self._arrays.skipped

    def move(self, starts: Floats, ends: Floats, kind: int) -> MotionOutcome:
        """Return the outcome for the motion of the frames between poses (f, POSE_WIDTH)."""
        self._arrays.starts[:], self._arrays.ends[:] = starts, ends
        self._arrays.flags[KIND] = kind
        return self.follow(NO_VALUES, 0, 1)

    def follow(self, path: JointPath, first: int, last: int) -> MotionOutcome:
        """Return the outcome for a path from row ``first`` to row ``last``."""
        verdict = self.search(path, first, last)
        outcome, counts = self._arrays.outcome.tolist(), self._arrays.counts.tolist()
        return MotionOutcome(
            verdict=verdict,
            edge=counts[EDGE],
            t0=outcome[T0],
            t1=outcome[T1],
            pair=counts[PAIR],
            lower_bound=outcome[LOWER_BOUND],
            seen=outcome[SEEN],
            seen_edge=counts[SEEN_EDGE],
            seen_time=outcome[SEEN_TIME],
            seen_pair=counts[SEEN_PAIR],
            evaluations=counts[EVALUATIONS],
            ignored=counts[IGNORED],
        )

    def search(self, path: tuple[Floats, Floats, Floats], first: int, last: int) -> int:
        """Return the verdict about a path from row ``first`` to row ``last``."""
        while (verdict := check_edges(self._handle, *path, first, last)) == NO_ROOM:
            entries = np.zeros((2 * len(self._arrays.entries), 3), dtype=np.int64)
            records = np.zeros((2 * len(self._arrays.records), RECORD_WIDTH))
            self._arrays = self._arrays._replace(entries=entries, records=records)
            self._handle = handle_of(self._arrays)
        return int(verdict)

    def row(self, path: JointPath, edge: int, t: float, pair: int) -> PairBatch:
        """Return the answer of one pair at a time of an edge, which poses the world there."""
        batch = PairBatch(np.zeros((1, 2), dtype=np.int64), np.zeros((1, BATCH_WIDTH)))
        row_of_pair(self._handle, path.rows, path.curves, edge, t, pair, batch.ids, batch.rows)
        return batch

    def speeds(self, path: JointPath) -> Floats:
        """Return upper bounds (e, n) of the speeds of geometries [m] an edge; with a chain."""
        return speeds_of_geometries(self._arrays, path)


def _arrays(
    world: World,
    pairs: Indices,
    rows: Indices,
    paddings: Floats,
    groups: Groups,
    chain: JointChain | None,
    columns: int,
) -> MotionArrays:
    tree = tree_of(world, rows, chain)
    sides, common = common_nodes(tree, groups)
    of_pair = np.empty(len(pairs), dtype=np.int64)
    of_pair[groups.numbers] = np.repeat(common, np.diff(groups.starts))
    moves, count = chain or _no_joints(), len(rows)
    return MotionArrays(
        parents=tree.parents,
        nodes=tree.nodes,
        on=tree.on,
        reaches=tree.reaches,
        starts=np.zeros((count if chain is None else 0, POSE_WIDTH)),
        ends=np.zeros((count if chain is None else 0, POSE_WIDTH)),
        moves=np.zeros((count if chain is None else 0, MOVE_WIDTH)),
        **{_NAMES.get(name, name): array for name, array in moves._asdict().items()},
        values=np.zeros((VALUE_ROWS, columns)),
        rows=rows,
        poses=np.zeros((1, count, 7)),
        Xs=np.zeros((count, POSE_WIDTH)),
        world=world.handle,
        pairs=pairs,
        paddings=paddings[pairs].sum(axis=1),
        skipped=np.zeros(len(pairs), dtype=np.bool_),
        approaches=np.zeros(len(pairs)),
        approached=np.zeros(len(pairs)),
        examined=np.zeros(len(pairs), dtype=np.bool_),
        firsts=groups.firsts,
        members=groups.members,
        group_pairs=groups.pairs,
        starts_of_pairs=groups.starts,
        numbers=groups.numbers,
        centres=groups.centres,
        halves=groups.halves,
        separations=groups.separations,
        group_reaches=reaches_of_groups(tree.reaches, groups.firsts, groups.members),
        sides=sides,
        common=common,
        common_of_pair=of_pair,
        kernels=ADDRESSES,
        parameters=np.zeros(PARAMETER_COUNT),
        flags=np.zeros(FLAG_COUNT, dtype=np.int64),
        stop=np.zeros(1, dtype=np.int64),
        outcome=np.zeros(OUTCOME_WIDTH),
        counts=np.zeros(COUNT_WIDTH, dtype=np.int64),
        bounds=np.zeros((len(pairs), BOUND_WIDTH)),
        entries=np.zeros((_FIRST_ENTRIES, 3), dtype=np.int64),
        records=np.zeros((2 * _FIRST_ENTRIES, RECORD_WIDTH)),
        spans=np.zeros((_SPANS, 2)),
        tops=np.zeros((_SPANS, 3), dtype=np.int64),
        one=np.zeros((1, 2), dtype=np.int64),
        slot=np.zeros(1, dtype=np.int64),
        hits=np.zeros(1, dtype=np.int64),
        memory=np.zeros((1, SLOT_WIDTH)),
        effects=np.zeros(COUNTS, dtype=np.int64),
        waiting=np.zeros(0, dtype=np.int64),
        distances=np.zeros(0),
    )


_NAMES = {'parents': 'chain_parents'}  # ``parents`` are those of nodes


def _no_joints() -> JointChain:
    none, nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
    return JointChain(
        leaders=none,
        multipliers=nothing,
        offsets=nothing,
        kinds=none,
        axes=np.zeros((0, 3)),
        X_PJs=np.zeros((0, 7)),
        parents=none,
        children=none,
        X_WLs=np.zeros((0, 7)),
        links=none,
    )
