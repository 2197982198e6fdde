"""``PathChecker``, ``check_path`` and ``check_paths``: continuous checks of joint paths."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.batch import prepared_paths
from drake_geom_ros.batch.evaluation import context_of
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.running import cores
from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    GeometryError,
    GeometryId,
    MotionCheck,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.geometry.queries.motion_queries import (
    NOTHING_PROVED,
    JointPath,
    MotionAnswer,
    MotionQueries,
    MotionQuestion,
)
from drake_geom_ros.geometry.queries.scene_mark import SceneMark
from drake_geom_ros.geometry.queries.state_queries import accuracy_in
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import TIME_TOLERANCE
from drake_geom_ros.trajectories.joint_spline import EDGES, JointSpline

Booleans = NDArray[np.bool_]
_PART = 256  # edges that are checked in one call, which Ctrl-C and other threads wait for
_SHORT_PART = 4 * EDGES  # of a check within a time, whose proof counts part by part


def check_path(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    path: ArrayLike,
    min_distance: float = 0.0,
    time_tolerance: float = TIME_TOLERANCE,
    max_evaluations: int = 0,
    threads: int = 0,
    *,
    accuracy: AccuracyLike = '',
    ignore_start_contacts: bool = False,
    ignore_limits: bool = False,
    bound_tolerance: float = math.inf,
) -> MotionCheck:
    """Return whether a whole path is clear, certified for all times.

    ``path`` (k, q) has joint values [rad] or [m] of ``joints``, and is straight in joint space
    from row to row; a continuous joint follows its values, not the shorter way. Times are rows:
    2.5 is halfway between the third row and the fourth. The result and the other arguments are as
    in ``QueryObject.CheckMotion``: a path is clear if pairs stay farther apart than
    ``min_distance`` [m]. Bounds use only the motion of the joints between two links, so links of
    an arm that move together are evaluated once per edge.

    Answers do not depend on the number of ``threads`` (0: one for each core), and equal, to the
    bit, those of ``check_paths``. Raises ArgumentError for a path without rows, values that are
    not finite, values outside the limits of their joint unless ``ignore_limits``, and joints that
    move nothing which could collide; PoseError for frames without a pose.
    """
    (check,) = check_paths(
        scene_graph,
        joints,
        [path],
        min_distance,
        time_tolerance,
        max_evaluations,
        threads,
        accuracy=accuracy,
        ignore_start_contacts=ignore_start_contacts,
        ignore_limits=ignore_limits,
        bound_tolerance=bound_tolerance,
    )
    return check


def check_paths(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    paths: Iterable[ArrayLike],
    min_distance: float = 0.0,
    time_tolerance: float = TIME_TOLERANCE,
    max_evaluations: int = 0,
    threads: int = 0,
    *,
    accuracy: AccuracyLike = '',
    ignore_start_contacts: bool = False,
    ignore_limits: bool = False,
    bound_tolerance: float = math.inf,
) -> list[MotionCheck]:
    """Return the result of ``check_path`` for each path, by threads (0: one for each core).

    An array (N, k, q) is N paths. Raises as ``check_path``, with the number of the path.
    """
    if threads < 0:
        raise ArgumentError(f'threads={threads} must be >= 0')
    with PathChecker(
        scene_graph,
        joints,
        min_distance,
        time_tolerance,
        max_evaluations,
        accuracy=accuracy,
        ignore_start_contacts=ignore_start_contacts,
        ignore_limits=ignore_limits,
        bound_tolerance=bound_tolerance,
    ) as checker:
        return checker.check_each(paths, threads)


def _path_of(path: ArrayLike, number: int, joints: Joints, ignore_limits: bool) -> Floats:
    """Return a path (k, q) as a contiguous array; raises ArgumentError for an invalid one."""
    try:
        rows = np.ascontiguousarray(path, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f'path {number} must be numbers (k, {joints.count}): {error}'
        ) from None
    if rows.ndim != 2 or rows.shape[1] != joints.count or len(rows) == 0:
        raise ArgumentError(
            f'path {number} has the shape {rows.shape}; it must be (k, {joints.count}) of at '
            f'least one row, one value each for {", ".join(joints.names)}'
        )
    bad = ~np.isfinite(rows)
    why = 'joint values must be finite'
    if not bad.any() and not ignore_limits:
        bad = (rows < joints.lower) | (rows > joints.upper)
        why = 'it is outside its limits'
    if bad.any():
        row, column = np.argwhere(bad)[0].tolist()
        limits = f'[{joints.lower[column]:.6g}, {joints.upper[column]:.6g}]'
        raise ArgumentError(
            f'path {number}, row {row}: {joints.names[column]} = {rows[row, column]:.6g}; {why}'
            + (f' {limits}; ignore_limits=True lets it pass' if 'limits' in why else '')
        )
    return rows


class PathChecker:
    """Checks whether paths are clear: prepared once, then called for each edge, as in planners.

    Arguments and answers are those of ``check_path``. The checker uses the scene at its
    construction. After a change of the scene, its filters or the poses of frames that the joints
    do not move, it raises GeometryError. Any number of threads may use one at once; a context must
    not change meanwhile.

    At the end of a ``with`` statement a checker of a context passes its prepared data to the next
    checker of the same joints, scene and resting frames, and can no longer be used.
    """

    def __init__(
        self,
        scene_graph: SceneGraph | SceneGraphContext,
        joints: Joints,
        min_distance: float = 0.0,
        time_tolerance: float = TIME_TOLERANCE,
        max_evaluations: int = 0,
        *,
        accuracy: AccuracyLike = '',
        ignore_start_contacts: bool = False,
        ignore_limits: bool = False,
        bound_tolerance: float = math.inf,
    ) -> None:
        """Prepare the scene; raises ArgumentError and PoseError as ``check_path`` does."""
        if not isinstance(joints, Joints):
            raise ArgumentError(
                f'joints={joints!r} must be batch.Joints, as Joints.of(loaded, names) returns it'
            )
        self._question = MotionQuestion(
            min_distance=float(min_distance),
            time_tolerance=float(time_tolerance),
            max_evaluations=max_evaluations,
            ignore_start_contacts=ignore_start_contacts,
            bound_tolerance=float(bound_tolerance),
        )
        self.joints, self._ignore_limits = joints, ignore_limits
        self._mark = SceneMark(scene_graph, joints.id_values)
        context = context_of(scene_graph)
        self._accuracy = accuracy_in(context, accuracy)
        self._context = context
        self._kind, self._prepared = prepared_paths.take(context, joints, self._accuracy)
        if not self._prepared.scene.has_moving_pairs():
            raise ArgumentError(
                'these joints move no geometry that could collide with any other: each path would '
                'be clear of what nobody looks at. The robot has no collision geometry in this '
                'scene, or filters leave all of it out'
            )
        self._own, self._stop = threading.local(), self._prepared.stop
        self._spare, self._ended = [self._prepared.queries], False

    def __repr__(self) -> str:
        return (
            f'<PathChecker: {self.joints.count} joints, {len(self._prepared.scene.pairs)} pairs, '
            f'min_distance {self._question.min_distance:g} m, accuracy {self._accuracy!r}>'
        )

    def __enter__(self) -> PathChecker:
        """Return this checker."""
        return self

    def __exit__(self, *raised: object) -> None:
        """Pass the prepared data to the next checker; this one can no longer be used."""
        if not self._ended:
            self._ended = True
            prepared_paths.give_back(self._context, self._kind, self._prepared)

    def check(self, path: ArrayLike) -> MotionCheck:
        """Return the result for a path (k, q), computed by this thread.

        Raises ArgumentError for an invalid path, GeometryError after a change of the scene.
        """
        self._refuse_another_scene()
        return self._check(JointPath.straight(self._rows_of(path)))

    def check_spline(self, spline: JointSpline) -> MotionCheck:
        """Return the result for a spline, with times by its points; raises as ``check``.

        It is refused where it leaves the limits of a joint, between two points too.
        """
        self._refuse_another_scene()
        self.refuse_limits(spline)
        return _by_points(self._check(spline.path()))

    def check_between(self, spline: JointSpline, times: Floats) -> list[MotionCheck]:
        """Return the result for each part (k,) of a spline between times (k + 1,) [s] that grow.

        Times of results count from the first point by parts of its path, and limits of joints are
        not looked at. With ``ignore_start_contacts``, pairs not clear at the start of the spline
        are left out of all.
        """
        self._refuse_another_scene()
        fine = spline.split(times)
        path, queries, question = fine.path(), self._queries(), self._question
        rows = (EDGES * np.searchsorted(fine.times, times)).tolist()
        skipped: Booleans | None = None
        if question.ignore_start_contacts:
            queries.follow(replace(question, bound_tolerance=math.inf), path, (0, 1))
            skipped = queries.skipped()
        answers = [queries.follow(question, path, part, skipped) for part in pairwise(rows)]
        return [MotionCheck.of(each, self._prepared.ids) for each in answers]

    def speeds(self, spline: JointSpline) -> tuple[Floats, list[GeometryId]]:
        """Return upper bounds (n,) [m/s] of the speeds of all points of geometries, and these."""
        bounds = self._queries().speeds(spline.path())
        spans = np.repeat(np.diff(spline.times) / EDGES, EDGES)[:, np.newaxis]
        fastest = (bounds / spans).max(axis=0, initial=0.0)
        return fastest, [GeometryId(int(value)) for value in self._prepared.ids.tolist()]

    def check_spline_within(
        self, spline: JointSpline, seconds: float, must_stop: Callable[[], bool]
    ) -> MotionCheck:
        """Return the result for a spline as far as a time [s] of computing goes; inf: to its end.

        What was proved by then counts, and the rest is 'unknown'. Limits of joints are not looked
        at (``refuse_limits`` does), and no other thread may use the checker meanwhile. Raises
        InterruptedError soon after ``must_stop()`` is true, which is asked now and then.
        """
        self._refuse_another_scene()
        return _by_points(self._check_within(spline.path(), seconds, must_stop))

    def refuse_limits(self, spline: JointSpline) -> None:
        """Raise ArgumentError for a spline that leaves limits, unless these are ignored."""
        self._rows_of(spline.positions)
        if not self._ignore_limits:
            self._refuse_overshoot(spline)

    def check_each(self, paths: Iterable[ArrayLike], threads: int = 0) -> list[MotionCheck]:
        """Return the result for each path, by threads (0: one for each core); raises as above."""
        every = [JointPath.straight(self._rows_of(path, k)) for k, path in enumerate(paths)]
        self._refuse_another_scene()
        count = threads or cores()
        if count == 1:
            return [self._check(path) for path in every]
        with ThreadPoolExecutor(count) as pool:
            try:
                if len(every) == 1:
                    return [self._check(every[0], pool)]
                return list(pool.map(self._check, every))
            except BaseException:
                self._stop[0] = 1  # ends running checks
                raise
            finally:
                pool.shutdown(cancel_futures=True)
                self._stop[0] = 0

    def check_edges(self, path: ArrayLike) -> list[MotionCheck]:
        """Return the result for each edge of a path (k, q), with times by the path's rows.

        With ``ignore_start_contacts``, pairs not clear at the start of the path are left out.
        """
        way = JointPath.straight(self._rows_of(path))
        self._refuse_another_scene()
        queries, question, last = self._queries(), self._question, len(way.rows) - 1
        answers = [queries.follow(question, way, (0, min(1, last)))]
        skipped = queries.skipped()
        for k in range(1, last):
            answers.append(queries.follow(question, way, (k, k + 1), skipped))
        return [MotionCheck.of(each, self._prepared.ids) for each in answers]

    def _rows_of(self, path: ArrayLike, number: int = 0) -> Floats:
        return _path_of(path, number, self.joints, self._ignore_limits)

    def _refuse_overshoot(self, spline: JointSpline) -> None:
        """Raise ArgumentError for a spline that leaves the limits of a joint."""
        joints, extreme = self.joints, spline.beyond(self.joints.lower, self.joints.upper)
        if extreme is not None:
            k = extreme.joint
            raise ArgumentError(
                f'the spline takes {joints.names[k]} to {extreme.value:.6g} at '
                f'{extreme.time:.6g} s, between points that are within; its limits are '
                f'[{joints.lower[k]:.6g}, {joints.upper[k]:.6g}]; ignore_limits=True lets it pass'
            )

    def _refuse_another_scene(self) -> None:
        if self._ended:
            raise GeometryError('this checker was used by `with`, and has ended: make a new one')
        if not self._mark.is_of_now():
            raise GeometryError(
                'the scene was changed since this checker was prepared: what is in it, its '
                'filters, or the pose of a frame that the joints do not move. Make a new one'
            )

    def _queries(self) -> MotionQueries:
        """Return this thread's queries."""
        if not hasattr(self._own, 'queries'):
            try:
                self._own.queries = self._spare.pop()  # the first thread's
            except IndexError:
                prepared = self._prepared
                self._own.queries = MotionQueries(
                    prepared.scene, self._accuracy, self._stop, prepared.chain, self.joints.count
                )
        queries: MotionQueries = self._own.queries
        return queries

    def _check(self, path: JointPath, pool: ThreadPoolExecutor | None = None) -> MotionCheck:
        """Return the result for a path, whose parts may be distributed to a pool's threads."""
        question, edges, queries = self._question, len(path.rows) - 1, self._queries()
        answer = queries.follow(question, path, (0, min(edges, _PART)))
        parts = [(k, min(k + _PART, edges)) for k in range(_PART, edges, _PART)]
        if answer.outcome == 'clear' and parts:
            skipped = queries.skipped()
            if pool is None or question.max_evaluations > 0:
                answer = self._one_by_one(answer, path, parts, skipped)
            else:
                later = partial(self._part, question, path, skipped)
                answer = _joined(answer, pool.map(later, parts))
        return MotionCheck.of(answer, self._prepared.ids)

    def _check_within(
        self, path: JointPath, seconds: float, must_stop: Callable[[], bool]
    ) -> MotionCheck:
        """Return the result for a path, part by part until a time [s] is over."""
        end, edges = time.monotonic() + seconds, len(path.rows) - 1
        answer, queries = NOTHING_PROVED, self._queries()
        skipped: Booleans | None = None
        with self._halting_after(seconds):
            for first in range(0, edges, _SHORT_PART):
                if must_stop():
                    raise InterruptedError(f'stopped in edge {first} of a path')
                part = first, min(first + _SHORT_PART, edges)
                try:
                    if time.monotonic() >= end:
                        raise InterruptedError
                    checked = queries.follow(self._question, path, part, skipped)
                except InterruptedError:
                    answer = replace(answer, outcome='unknown', times=(first, edges))
                    break
                answer = checked if skipped is None else _joined(answer, [checked])
                if answer.outcome != 'clear':
                    break
                skipped = queries.skipped() if skipped is None else skipped
        return MotionCheck.of(answer, self._prepared.ids)

    @contextmanager
    def _halting_after(self, seconds: float) -> Iterator[None]:
        """Have checks end with InterruptedError after a time [s]; inf: never."""
        timer = threading.Timer(min(seconds, threading.TIMEOUT_MAX), self._halt)
        timer.daemon = True
        if seconds < math.inf:
            timer.start()
        try:
            yield
        finally:
            timer.cancel()
            if timer.ident is not None:
                timer.join()
            self._stop[0] = 0

    def _halt(self) -> None:
        self._stop[0] = 1

    def _part(
        self, question: MotionQuestion, path: JointPath, skipped: Booleans, part: tuple[int, int]
    ) -> MotionAnswer:
        return self._queries().follow(question, path, part, skipped)

    def _one_by_one(
        self,
        answer: MotionAnswer,
        path: JointPath,
        parts: list[tuple[int, int]],
        skipped: Booleans,
    ) -> MotionAnswer:
        """Return the answer about a path whose parts share one budget of evaluations, if any."""
        for part in parts:
            question = self._question
            if question.max_evaluations > 0:
                left = question.max_evaluations - answer.evaluations
                if left <= 0:
                    ends = float(part[0]), float(part[0] + 1)
                    return replace(answer, outcome='unknown', times=ends)
                question = replace(question, max_evaluations=left)
            answer = _joined(answer, [self._part(question, path, skipped, part)])
            if answer.outcome != 'clear':
                break
        return answer


def _by_points(check: MotionCheck) -> MotionCheck:
    """Return a result about the edges of a spline with times by its points."""
    first, last = check.times
    return replace(check, times=(first / EDGES, last / EDGES), time=check.time / EDGES)


def _joined(answer: MotionAnswer, parts: Iterable[MotionAnswer]) -> MotionAnswer:
    """Return the answer about a path from those of its clear beginning and the later parts."""
    for part in parts:
        nearest = answer if part.outcome == 'clear' and answer.distance <= part.distance else part
        answer = replace(
            nearest,
            outcome=part.outcome,
            times=part.times,
            lower_bound=min(answer.lower_bound, part.lower_bound),
            evaluations=answer.evaluations + part.evaluations,
            ignored=answer.ignored,
        )
        if answer.outcome != 'clear':
            break
    return answer
