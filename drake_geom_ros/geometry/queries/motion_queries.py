"""Motion queries on a packed scene, by poses or joint values, and their answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.motion.arrays import (
    CLEAR,
    CONTACT,
    NO_POSE,
    SCREW,
    SLERP,
    STOPPED,
    UNKNOWN,
)
from drake_geom_ros.geometry._proximity.motion.joint_path import NO_VALUES, JointPath
from drake_geom_ros.geometry._proximity.motion.motion_loops import MotionLoops, MotionOutcome
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH, PairBatch
from drake_geom_ros.geometry._proximity.world.pose_rows import POSITION
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.errors import ArgumentError, PoseError
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.half_space_pairs import HalfSpaceGaps
from drake_geom_ros.geometry.queries.half_space_states import (
    HalfSpaceStates,
    SpanOfHalfSpaces,
    span_of,
)
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import Paddings, padded_rows
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

__all__ = ['NOTHING_PROVED', 'JointPath', 'MotionAnswer', 'MotionQueries', 'MotionQuestion']

Booleans = NDArray[np.bool_]

INTERPOLATIONS = {'slerp': SLERP, 'screw': SCREW}
OUTCOMES = {CLEAR: 'clear', CONTACT: 'contact', UNKNOWN: 'unknown'}


@dataclass(frozen=True)
class MotionQuestion:
    """Parameters of a motion query; raises ArgumentError for values out of range."""

    min_distance: float = 0.0  # [m] pairs are clear while farther apart
    time_tolerance: float = TIME_TOLERANCE  # the longest span that holds a first contact
    max_evaluations: int = 0  # of pairs by kernels; 0: no limit
    ignore_start_contacts: bool = False
    # [m] largest gap from the reported bound of a clear motion to the smallest computed distance
    bound_tolerance: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 <= self.min_distance < math.inf:
            raise ArgumentError(
                f'min_distance={self.min_distance!r} must be a distance >= 0, in metres'
            )
        if not self.time_tolerance > 0.0:
            raise ArgumentError(
                f'time_tolerance={self.time_tolerance!r} must be > 0: it is the longest span of '
                'time that may hold the first contact'
            )
        if self.max_evaluations < 0:
            raise ArgumentError(
                f'max_evaluations={self.max_evaluations!r} must be >= 0; 0 is no limit'
            )
        if not self.bound_tolerance > 0.0:
            raise ArgumentError(
                f'bound_tolerance={self.bound_tolerance!r} must be > 0, in metres: it is how far '
                'lower_bound may be below the least distance that was seen'
            )


@dataclass(frozen=True, eq=False)
class MotionAnswer:
    """Answer about a motion; geometries by their place, -1 for none."""

    outcome: str
    times: tuple[float, float]
    time: float  # at which the reported pair has its distance
    a: int
    b: int
    distance: float  # [m]
    error_bound: float  # [m]
    lower_bound: float  # [m]
    p_WCa: Floats  # (3,) [m]
    p_WCb: Floats
    evaluations: int
    ignored: int


# Of a motion that nobody has looked at.
NOTHING_PROVED = MotionAnswer(
    outcome='unknown',
    times=(0.0, math.inf),
    time=0.0,
    a=-1,
    b=-1,
    distance=math.inf,
    error_bound=0.0,
    lower_bound=-math.inf,
    p_WCa=np.full(3, np.nan),
    p_WCb=np.full(3, np.nan),
    evaluations=0,
    ignored=0,
)


class MotionQueries:
    """Motion queries on a packed scene, without the GIL; each thread needs its own.

    The scene's moved frames follow poses or, with a ``chain``, the joint values of ``columns``.
    When another thread sets ``stop`` (1,) to a number other than 0, a check raises
    InterruptedError. Every answer depends on its motion and its question alone.
    """

    def __init__(
        self,
        scene: PackedScene,
        accuracy: AccuracyLike,
        stop: Indices,
        chain: JointChain | None = None,
        columns: int = 0,
    ) -> None:
        self._half_spaces = HalfSpaceStates.of(scene, chain)
        if chain is not None:
            chain = chain._replace(X_WLs=chain.X_WLs.copy())  # scratch of this thread alone
        self.moved = scene.moved
        self._world, self._padded = scene.world(), bool(scene.paddings.any())
        self._paddings = Paddings(scene.paddings, scene.meshes)
        self._loops = MotionLoops(
            self._world,
            scene.pairs.copy(),
            scene.moved.copy(),
            scene.paddings,
            accuracy_of(accuracy).length,
            stop,
            chain,
            columns,
        )

    def stand(self, R_PFs: Floats, p_PFs: Floats) -> None:
        """Set the poses of the frames that stay, from X_PF (nf,) of all frames by place."""
        self._loops.stand(R_PFs, p_PFs)
        if self._half_spaces is not None:
            self._half_spaces.stand(R_PFs, p_PFs)

    def take_shapes_of(self, world: World) -> bool:
        """Take the shapes of a world that differs by these alone, and poses; else return False."""
        if not self._world.has_other_shapes_only(world):
            return False
        self._loops.take_shapes(world)
        return True

    def drive_by(self, chain: JointChain) -> None:
        """Take the numbers of a chain with the same links and columns as the one at first."""
        self._loops.drive_by(chain)
        if self._half_spaces is not None:
            self._half_spaces.drive_by(chain)

    def move(
        self, question: MotionQuestion, starts: Floats, ends: Floats, interpolation: str
    ) -> MotionAnswer:
        """Return the answer about the motion between two poses (f, 12) of each moved frame.

        Rows are R_PF by its rows, then p_PF. Times go from 0 to 1.
        """

        def once(question: MotionQuestion, skipped: Booleans | None) -> MotionAnswer:
            self._prepare(question, skipped)
            row = self._loops.move(starts, ends, INTERPOLATIONS[interpolation])
            return self._answer_of(row, NO_VALUES, 1.0)

        answer = self._with_close_bound(question, once, None)
        if self._half_spaces is None:
            return answer
        turns = bool((starts[:, :POSITION] != ends[:, :POSITION]).any())
        start = self._half_spaces.at_rows(starts)
        end = None if turns else self._half_spaces.at_rows(ends)
        span = _span(question, start, end, start, self._half_spaces.moves)
        return _with_half_spaces(answer, span, 0.0)

    def follow(
        self,
        question: MotionQuestion,
        path: JointPath,
        rows: tuple[int, int] | None = None,
        skipped: Booleans | None = None,
    ) -> MotionAnswer:
        """Return the answer about a path of contiguous arrays; times are row numbers.

        ``rows`` limits it to the part from one row to another; pairs in the mask ``skipped`` (n,)
        are left out.
        """
        count = len(path.rows)
        way = path if count > 1 else JointPath.straight(np.repeat(path.rows, 2, axis=0))
        first, last = rows or (0, count - 1)

        def once(question: MotionQuestion, skipped: Booleans | None) -> MotionAnswer:
            self._prepare(question, skipped)
            row = self._loops.follow(way, first, max(last, first + 1))
            return self._answer_of(row, way, float(last))

        answer = self._with_close_bound(question, once, skipped)
        if self._half_spaces is None:
            return answer
        at_joints = self._half_spaces.at_joints
        start = at_joints(way.rows[first])
        end = start if way.is_still(first, last) else None
        span = _span(question, start, end, at_joints(way.rows[0]), self._half_spaces.moves)
        return _with_half_spaces(answer, span, float(first))

    def speeds(self, path: JointPath) -> Floats:
        """Return upper bounds (e, n) of the speeds of geometries [m] an edge; with a chain."""
        return self._loops.speeds(path)

    def skipped(self) -> Booleans:
        """Return the mask (n,) of pairs that the last answer left out, not clear at its start."""
        return self._loops.skipped.copy()

    def _with_close_bound(
        self,
        question: MotionQuestion,
        once: Callable[[MotionQuestion, Booleans | None], MotionAnswer],
        skipped: Booleans | None,
    ) -> MotionAnswer:
        """Return the answer of ``once``, with a bound within the tolerance if the motion is clear.

        The bounds of a proof are only as large as it needs. So it is repeated with larger minimum
        distances: first one just below the computed distance, and then by bisection.
        """
        answer = once(question, skipped)
        if answer.outcome != 'clear' or question.bound_tolerance == math.inf:
            return answer
        left_out, tolerance = self.skipped(), question.bound_tolerance
        low, high = answer.lower_bound, answer.distance
        target = high - 0.5 * tolerance
        while high - low > tolerance:
            if not low < target < math.inf:
                target = 0.5 * (low + min(high, 3.0 * low))  # no distance yet: double the bound
            left = question.max_evaluations - answer.evaluations
            if not low < target < high or (question.max_evaluations > 0 and left <= 0):
                break
            attempt = once(
                replace(
                    question,
                    min_distance=target,
                    time_tolerance=math.inf,
                    max_evaluations=max(left, 0),
                    ignore_start_contacts=False,
                ),
                left_out,
            )
            nearest = attempt if attempt.distance < answer.distance else answer
            if attempt.outcome == 'clear':
                low = attempt.lower_bound
            answer = replace(
                nearest,
                outcome='clear',
                times=answer.times,
                lower_bound=low,
                evaluations=answer.evaluations + attempt.evaluations,
                ignored=answer.ignored,
            )
            if attempt.outcome == 'unknown':
                break
            high = min(high, answer.distance)
            target = high - 0.5 * tolerance if attempt.outcome == 'clear' else -math.inf
        self._loops.skipped[:] = left_out
        return answer

    def _prepare(self, question: MotionQuestion, skipped: Booleans | None) -> None:
        self._loops.skipped[:] = False if skipped is None else skipped
        self._loops.ask(
            question.min_distance,
            question.time_tolerance,
            question.max_evaluations,
            ignores=question.ignore_start_contacts,
        )

    def _refuse(self, verdict: int, edge: int) -> None:
        """Raise the error of a check without a verdict, which ended in an edge of its path."""
        if verdict == STOPPED:
            raise InterruptedError(f'stopped in edge {edge} of a path')
        if verdict == NO_POSE:
            raise PoseError(
                f'The motion was refused: between {edge} and {edge + 1} of its time a '
                'frame would be where no pose may be, too far away'
            )

    def _padded_rows(self, batch: PairBatch) -> Floats:
        """Return the rows of answers about the bodies as they are padded."""
        if not self._padded:
            return batch.rows
        return padded_rows(batch.rows, batch.ids, self._paddings, self._world)

    def _answer_of(self, row: MotionOutcome, path: JointPath, end: float) -> MotionAnswer:
        """Return the answer for a row of the loops, about a motion that ends at time ``end``."""
        self._refuse(row.verdict, row.edge)
        still = end == 0.0
        pair, edge, time = row.seen_pair, row.seen_edge, row.seen_time
        times = (end, end)
        if row.verdict != CLEAR:
            edge = row.edge
            pair, time = row.pair, row.t1 if row.verdict == CONTACT else row.t0
            times = _earlier(edge, row.t0), _later(edge, row.t1)
        pair_row = np.zeros(BATCH_WIDTH)
        pair_row[DISTANCE] = math.inf
        a = b = -1
        if pair >= 0:
            batch = self._loops.row(path, edge, time, pair)
            (pair_row,), ((a, b),) = self._padded_rows(batch), batch.ids.tolist()
        return MotionAnswer(
            outcome=OUTCOMES[row.verdict],
            times=(0.0, 0.0) if still else times,
            time=0.0 if still else edge + time,
            a=a,
            b=b,
            distance=float(pair_row[DISTANCE]),
            error_bound=float(pair_row[ERROR_BOUND]),
            lower_bound=row.lower_bound,
            p_WCa=pair_row[WITNESS_A : WITNESS_A + 3].copy(),
            p_WCb=pair_row[WITNESS_B : WITNESS_B + 3].copy(),
            evaluations=row.evaluations,
            ignored=row.ignored,
        )


def _span(
    question: MotionQuestion,
    start: HalfSpaceGaps,
    end: HalfSpaceGaps | None,
    beginning: HalfSpaceGaps,
    moves: Booleans,
) -> SpanOfHalfSpaces:
    """Return the result for half spaces from ``start`` to ``end``, None if frames may turn.

    Pairs that were not clear at the ``beginning`` of the whole path may be ignored.
    """
    left_out = np.zeros(len(moves), dtype=np.bool_)
    if question.ignore_start_contacts:
        left_out = ~(beginning.lower > question.min_distance)
    return span_of(start, end, moves, left_out, question.min_distance)


def _with_half_spaces(answer: MotionAnswer, span: SpanOfHalfSpaces, start: float) -> MotionAnswer:
    """Return an answer about a motion from time ``start`` on, merged with that of half spaces."""
    ignored = answer.ignored + span.ignored
    if span.outcome == 'clear':
        return replace(
            answer, lower_bound=min(answer.lower_bound, span.lower_bound), ignored=ignored
        )
    if answer.outcome == 'contact' and answer.times[0] <= start:
        return replace(answer, ignored=ignored)
    nowhere = np.full(3, np.nan)
    return replace(
        answer,
        outcome=span.outcome,
        times=(start, start if span.outcome == 'contact' else answer.times[1]),
        time=start,
        a=span.a,
        b=span.b,
        distance=span.distance,
        error_bound=span.error_bound,
        lower_bound=span.lower_bound,
        p_WCa=nowhere,
        p_WCb=nowhere,
        ignored=ignored,
    )


def _earlier(edge: int, t: float) -> float:
    """Return edge + t, rounded down."""
    time = edge + t
    return math.nextafter(time, -math.inf) if time - edge > t else time


def _later(edge: int, t: float) -> float:
    """Return edge + t, rounded up."""
    time = edge + t
    return math.nextafter(time, math.inf) if time - edge < t else time
