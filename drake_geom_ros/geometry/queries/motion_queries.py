"""Queries about motions of a packed scene, and what is told of them."""

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
from drake_geom_ros.geometry._proximity.motion.motion_loops import MotionLoops, Told
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry._proximity.world.pose_rows import POSITION
from drake_geom_ros.geometry.errors import ArgumentError, PoseError
from drake_geom_ros.geometry.queries.half_space_pairs import HalfSpaceGaps
from drake_geom_ros.geometry.queries.half_space_states import (
    HalfSpaceStates,
    SpanOfHalfSpaces,
    span_of,
)
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.padding import Paddings, padded_rows
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Booleans = NDArray[np.bool_]

INTERPOLATIONS = {'slerp': SLERP, 'screw': SCREW}
OUTCOMES = {CLEAR: 'clear', CONTACT: 'contact', UNKNOWN: 'unknown'}


@dataclass(frozen=True)
class MotionQuestion:
    """What is asked of a motion; raises ArgumentError for what cannot be asked."""

    min_distance: float = 0.0  # [m] clear is what stays farther apart
    time_tolerance: float = TIME_TOLERANCE  # the longest span that holds a first contact
    max_evaluations: int = 0  # of pairs by kernels; 0: no limit
    ignore_start_contacts: bool = False
    # [m] how far the bound that is told of a clear motion may be below what was seen
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
class FoundMotion:
    """What was found of a motion; geometries by their place, -1 where there is none."""

    outcome: str
    times: tuple[float, float]
    time: float  # of the pair that is told
    a: int
    b: int
    distance: float  # [m]
    error_bound: float  # [m]
    lower_bound: float  # [m]
    p_WCa: Floats  # (3,) [m]
    p_WCb: Floats
    evaluations: int
    ignored: int


class MotionQueries:
    """Answers about motions of a packed scene, without the GIL; each thread takes one of its own.

    The frames that the scene has as moved go by poses or, of a chain, by joint values of so many
    ``columns``. ``stop`` (1,) set to another number than 0, by another thread, ends a check early:
    it raises InterruptedError then. Every answer depends on its motion and the question alone.
    """

    def __init__(
        self,
        scene: PackedScene,
        accuracy: str,
        stop: Indices,
        chain: JointChain | None = None,
        columns: int = 0,
    ) -> None:
        self._half_spaces = HalfSpaceStates.of(scene, chain)
        if chain is not None:
            chain = chain._replace(X_WLs=chain.X_WLs.copy())  # room, of this thread alone
        self.moved = scene.moved
        self._world, self._padded = scene.world(), bool(scene.paddings.any())
        self._paddings = Paddings(scene.paddings, scene.meshes)
        self._loops = MotionLoops(
            self._world,
            scene.pairs.copy(),
            scene.moved.copy(),
            scene.paddings,
            GAPS_OF_LEVELS[accuracy],
            stop,
            chain,
            columns,
        )

    def stand(self, R_PFs: Floats, p_PFs: Floats) -> None:
        """Let the frames that stay have poses of these, X_PF (nf,) of all frames by their place.

        Of queries without a chain.
        """
        self._loops.stand(R_PFs, p_PFs)
        if self._half_spaces is not None:
            self._half_spaces.stand(R_PFs, p_PFs)

    def move(
        self, asked: MotionQuestion, starts: Floats, ends: Floats, interpolation: str
    ) -> FoundMotion:
        """Return what is true of the motion between two poses (f, 12) of each moved frame.

        Rows are R_PF by its rows, then p_PF. Times go from 0 to 1.
        """

        def once(asked: MotionQuestion, skipped: Booleans | None) -> FoundMotion:
            self._ask(asked, skipped)
            told = self._loops.move(starts, ends, INTERPOLATIONS[interpolation])
            return self._found(told, np.zeros((2, 0)), 1.0)

        found = self._closely(asked, once, None)
        if self._half_spaces is None:
            return found
        turns = bool((starts[:, :POSITION] != ends[:, :POSITION]).any())
        start = self._half_spaces.at_rows(starts)
        end = None if turns else self._half_spaces.at_rows(ends)
        span = _span(asked, start, end, start, self._half_spaces.moves)
        return _with_half_spaces(found, span, 0.0)

    def follow(
        self,
        asked: MotionQuestion,
        path: Floats,
        rows: tuple[int, int] | None = None,
        skipped: Booleans | None = None,
    ) -> FoundMotion:
        """Return what is true of a path (k, c) in joint space, in one piece, times by its rows.

        Of a part of it from one row to another where ``rows`` are given, with pairs left out that
        are ``skipped`` (n,).
        """
        way = path if len(path) > 1 else np.repeat(path, 2, axis=0)
        first, last = rows or (0, len(path) - 1)

        def once(asked: MotionQuestion, skipped: Booleans | None) -> FoundMotion:
            self._ask(asked, skipped)
            told = self._loops.follow(way, first, max(last, first + 1))
            return self._found(told, way, float(last))

        found = self._closely(asked, once, skipped)
        if self._half_spaces is None:
            return found
        at_joints, part = self._half_spaces.at_joints, way[first : last + 1]
        start = at_joints(way[first])
        end = None if (part != way[first]).any() else start
        span = _span(asked, start, end, at_joints(way[0]), self._half_spaces.moves)
        return _with_half_spaces(found, span, float(first))

    def skipped(self) -> Booleans:
        """Return which pairs (n,) the last answer left out: they were not clear at its start."""
        return self._loops.skipped.copy()

    def _closely(
        self,
        asked: MotionQuestion,
        once: Callable[[MotionQuestion, Booleans | None], FoundMotion],
        skipped: Booleans | None,
    ) -> FoundMotion:
        """Return what is found ``once``, of a clear motion with as close a bound as is asked for.

        The bounds of a proof are only as large as it needs. So ever larger distances are asked
        about: one just below what was seen first, and then by bisection.
        """
        found = once(asked, skipped)
        if found.outcome != 'clear' or asked.bound_tolerance == math.inf:
            return found
        left_out, tolerance = self.skipped(), asked.bound_tolerance
        low, high = found.lower_bound, found.distance
        target = high - 0.5 * tolerance
        while high - low > tolerance:
            if not low < target < math.inf:
                target = 0.5 * (low + min(high, 3.0 * low))  # as long as none was seen, farther
            left = asked.max_evaluations - found.evaluations
            if not low < target < high or (asked.max_evaluations > 0 and left <= 0):
                break
            tried = once(
                replace(
                    asked,
                    min_distance=target,
                    time_tolerance=math.inf,
                    max_evaluations=max(left, 0),
                    ignore_start_contacts=False,
                ),
                left_out,
            )
            seen = tried if tried.distance < found.distance else found
            if tried.outcome == 'clear':
                low = tried.lower_bound
            found = replace(
                seen,
                outcome='clear',
                times=found.times,
                lower_bound=low,
                evaluations=found.evaluations + tried.evaluations,
                ignored=found.ignored,
            )
            if tried.outcome == 'unknown':
                break
            high = min(high, found.distance)
            target = high - 0.5 * tolerance if tried.outcome == 'clear' else -math.inf
        self._loops.skipped[:] = left_out
        return found

    def _ask(self, asked: MotionQuestion, skipped: Booleans | None) -> None:
        self._loops.skipped[:] = False if skipped is None else skipped
        self._loops.ask(
            asked.min_distance,
            asked.time_tolerance,
            asked.max_evaluations,
            ignores=asked.ignore_start_contacts,
        )

    def _found(self, told: Told, path: Floats, end: float) -> FoundMotion:
        """Return what is told, with the pair that it is about; a motion ends at time ``end``."""
        if told.verdict == STOPPED:
            raise InterruptedError(f'stopped in edge {told.edge} of a path')
        if told.verdict == NO_POSE:
            raise PoseError(
                f'The motion was refused: between {told.edge} and {told.edge + 1} of its time a '
                'frame would be where no pose may be, too far away'
            )
        still = end == 0.0
        pair, edge, time = told.seen_pair, told.seen_edge, told.seen_time
        times = (end, end)
        if told.verdict != CLEAR:
            edge = told.edge
            pair, time = told.pair, told.t1 if told.verdict == CONTACT else told.t0
            times = _earlier(edge, told.t0), _later(edge, told.t1)
        told_row = np.zeros(BATCH_WIDTH)
        told_row[DISTANCE] = math.inf
        a = b = -1
        if pair >= 0:
            found = self._loops.row(path, edge, time, pair)
            rows = found.rows
            if self._padded:
                rows = padded_rows(rows, found.ids, self._paddings, self._world)
            (told_row,), ((a, b),) = rows, found.ids.tolist()
        return FoundMotion(
            outcome=OUTCOMES[told.verdict],
            times=(0.0, 0.0) if still else times,
            time=0.0 if still else edge + time,
            a=a,
            b=b,
            distance=float(told_row[DISTANCE]),
            error_bound=float(told_row[ERROR_BOUND]),
            lower_bound=told.lower_bound,
            p_WCa=told_row[WITNESS_A : WITNESS_A + 3].copy(),
            p_WCb=told_row[WITNESS_B : WITNESS_B + 3].copy(),
            evaluations=told.evaluations,
            ignored=told.ignored,
        )


def _span(
    asked: MotionQuestion,
    start: HalfSpaceGaps,
    end: HalfSpaceGaps | None,
    beginning: HalfSpaceGaps,
    moves: Booleans,
) -> SpanOfHalfSpaces:
    """Return what is true of half spaces from ``start`` to ``end``; None: frames may turn.

    What is ignored is what was not clear at the ``beginning`` of the whole path.
    """
    left_out = np.zeros(len(moves), dtype=np.bool_)
    if asked.ignore_start_contacts:
        left_out = ~(beginning.lower > asked.min_distance)
    return span_of(start, end, moves, left_out, asked.min_distance)


def _with_half_spaces(found: FoundMotion, span: SpanOfHalfSpaces, start: float) -> FoundMotion:
    """Return what is found of a motion that begins at time ``start``, pairs of half spaces too."""
    ignored = found.ignored + span.ignored
    if span.outcome == 'clear':
        return replace(
            found, lower_bound=min(found.lower_bound, span.lower_bound), ignored=ignored
        )
    if found.outcome == 'contact' and found.times[0] <= start:
        return replace(found, ignored=ignored)
    nowhere = np.full(3, np.nan)
    return replace(
        found,
        outcome=span.outcome,
        times=(start, start if span.outcome == 'contact' else found.times[1]),
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
    """Return no more than edge + t."""
    time = edge + t
    return math.nextafter(time, -math.inf) if time - edge > t else time


def _later(edge: int, t: float) -> float:
    """Return no less than edge + t."""
    time = edge + t
    return math.nextafter(time, math.inf) if time - edge < t else time
