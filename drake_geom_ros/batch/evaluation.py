"""``evaluate``: queries about many states of a scene in one call."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.batch.contacts import ContactsOfStates
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.questions import Columns, Job, Question
from drake_geom_ros.batch.results import (
    Gathered,
    LeastDistances,
    PairsOfStates,
    PointsOfStates,
    Results,
)
from drake_geom_ros.batch.running import (
    LEAST_BLOCK,
    LOCAL_BLOCK,
    REMOTE_BLOCK,
    Block,
    blocks_of,
    by_executor,
    by_threads,
    size_for_all,
)
from drake_geom_ros.common.progress_bar import progress_bar
from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    FrameId,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.geometry.queries.state_queries import accuracy_in
from drake_geom_ros.math.array_types import Flags

Progress = Callable[[int, int], None]  # number of states done, and of all
_SECONDS = 1.0  # between two lines of progress


# The type of the result depends on ``want``, so that editors complete its fields.
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    *,
    want: Literal['collision'],
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> Flags: ...
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    want: Literal['least'] = ...,
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    *,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> LeastDistances: ...
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    *,
    want: Literal['nearest', 'within'],
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> PairsOfStates: ...
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    *,
    want: Literal['points'],
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> PointsOfStates: ...
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    *,
    want: Literal['contacts'],
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> ContactsOfStates: ...
@overload
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = ...,
    poses: ArrayLike | None = ...,
    want: str = ...,
    max_distance: float = ...,
    accuracy: AccuracyLike = ...,
    executor: Executor | None = ...,
    progress: bool | Progress = ...,
    *,
    states: ArrayLike | None = ...,
    joints: Joints | None = ...,
    count: int = ...,
    points: ArrayLike | None = ...,
    by_joints: bool = ...,
    threads: int = ...,
    block_size: int = ...,
) -> Results: ...
def evaluate(
    scene_graph: SceneGraph | SceneGraphContext,
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None = None,
    poses: ArrayLike | None = None,
    want: str = 'least',
    max_distance: float = math.inf,
    accuracy: AccuracyLike = '',
    executor: Executor | None = None,
    progress: bool | Progress = False,
    *,
    states: ArrayLike | None = None,
    joints: Joints | None = None,
    count: int = 1,
    points: ArrayLike | None = None,
    by_joints: bool = False,
    threads: int = 0,
    block_size: int = 0,
) -> Results:
    """Return the answers to a query about each of N states of a scene.

    States are ``poses`` (N, n, 7), x y z [m] qx qy qz qw, the poses X_PF of the n frames
    ``frame_ids``, or ``states`` (N, q), the values [rad] or [m] of ``joints``. All other frames
    keep their poses in the context, or, for a scene graph, in a new context.

    ``want`` is one of

    - ``'collision'``: the result of HasCollisions, a bool array (N,). A finite ``max_distance``
      >= 0 [m] is a margin: False only if every pair is certified to be farther apart;
    - ``'least'``: the pair with the smallest lower bound, which is distance minus error bound. Its
      interval contains the smallest distance of all pairs: ``LeastDistances``;
    - ``'nearest'``: the ``count`` pairs with the smallest lower bounds, in ascending order. The
      others are certified to be no nearer than the last one's bound: ``PairsOfStates``;
    - ``'within'``: all pairs up to ``max_distance`` [m]: ``PairsOfStates``. Pairs of half spaces
      are left out here. They are included above, with the gap of opposed ones as distance, else
      minus infinity;
    - ``'points'``: the distances of all geometries to ``points`` (m, 3) [m] in World, which are
      closed forms at every level: ``PointsOfStates``;
    - ``'contacts'``: area, force and centre of pressure of all contact surfaces, and the
      overlapping pairs without one: ``ContactsOfStates``.

    ``max_distance`` [m] leaves out pairs that are farther apart; for ``least`` and ``nearest``
    only those certified to be. ``by_joints`` adds ``joint_gradient`` (k, q), the derivatives of
    the distances of pairs by the joint values of their state. ``accuracy`` is a level
    or a length [m], empty for the default of the scene.

    The states are computed by ``threads`` of this process (0: one for each core), or by an
    ``executor`` with the ``concurrent.futures`` interface, in blocks of ``block_size`` states (0:
    a suitable size). Threads recompute blocks that the executor loses. ``progress`` writes a line
    to standard error, or is called with the numbers of states done and of all. An interrupt ends
    the call at once.

    Raises ArgumentError for invalid arguments, GeometryError for contacts if no geometry has
    hydroelastic properties, PoseError for an invalid state and for frames without a pose,
    BatchError for workers of another version.
    """
    if threads < 0 or block_size < 0:
        raise ArgumentError(f'threads={threads} and block_size={block_size} must be >= 0')
    context = context_of(scene_graph)
    question = Question(
        want,
        float(max_distance),
        accuracy_in(context, accuracy),
        count,
        None if points is None else np.atleast_2d(np.asarray(points, dtype=np.float64)),
        by_joints,
    )
    rows, ids, arms = _states(frame_ids, poses, states, joints)
    job, geometry_ids = Job.of(context, question, ids, arms)
    names = QueryObject(context).inspector().full_names(geometry_ids)
    gathered = Gathered(want, len(rows), geometry_ids, names)
    # With many points a few states take as long as many states with pairs.
    least = LEAST_BLOCK if question.points is None else LEAST_BLOCK // (1 + len(question.points))
    if want == 'contacts':
        least = 1  # one takes as long as hundreds of others
    local = size_for_all(len(rows), threads, LOCAL_BLOCK, max(1, least))
    size = block_size or (local if executor is None else REMOTE_BLOCK)
    blocks = blocks_of(len(rows), size) or [(0, 0)]
    for block, columns in computed(job, rows, blocks, executor, progress, threads):
        gathered.put(block, columns)
    return gathered.results()


def context_of(scene: SceneGraph | SceneGraphContext) -> SceneGraphContext:
    """Return a context unchanged, or a new context of a scene graph."""
    return scene.CreateDefaultContext() if isinstance(scene, SceneGraph) else scene


def computed(
    job: Job,
    states: Any,
    blocks: list[Block],
    executor: Executor | None = None,
    progress: bool | Progress = False,
    threads: int = 0,
) -> Iterator[tuple[Block, Columns]]:
    """Yield the answers of blocks, in any order; geometries are places in the scene."""
    total, done = sum(last - first for first, last in blocks), 0
    if executor is None:
        answers = by_threads(job, states, blocks, threads)
    else:
        answers = by_executor(job, states, blocks, executor, threads)
    with _shown(progress, total) as show:
        for block, columns in answers:
            done += block[1] - block[0]
            show(done)
            yield block, columns


@contextmanager
def _shown(progress: bool | Progress, total: int) -> Iterator[Callable[[int], None]]:
    """Yield what shows how many states are done: once a second, and at the end."""
    if progress is True:
        with progress_bar('states', total) as show:
            yield show
        return
    shown = time.monotonic()

    def call(done: int) -> None:
        nonlocal shown
        if progress and (done == total or time.monotonic() - shown >= _SECONDS):
            shown = time.monotonic()
            progress(done, total)

    yield call


def _states(
    frame_ids: Sequence[FrameId] | NDArray[np.integer] | None,
    poses: ArrayLike | None,
    states: ArrayLike | None,
    joints: Joints | None,
) -> tuple[NDArray[np.float64], NDArray[np.int64], tuple[Any, ...]]:
    """Return states, the id values of the frames that they pose, and the arms of joint values."""
    by_poses = frame_ids is not None and poses is not None
    if isinstance(frame_ids, Joints):
        raise ArgumentError('name them: evaluate(scene_graph, states=states, joints=joints)')
    by_joints = states is not None and joints is not None
    if by_poses == by_joints or (frame_ids is None) != (poses is None):
        raise ArgumentError('states are frame_ids and their poses, or states and their joints')
    if joints is not None and states is not None:
        rows = np.asarray(states)
        if rows.ndim != 2 or rows.shape[1] != joints.count:
            raise ArgumentError(
                f'states has the shape {rows.shape}; it must be (N, {joints.count}), one value '
                f'each for {", ".join(joints.names)}'
            )
        return rows, joints.id_values, joints.arms
    assert frame_ids is not None
    ids = np.array([id if isinstance(id, int) else _value(id) for id in frame_ids], dtype=np.int64)
    rows = np.asarray(poses)
    if rows.ndim != 3 or rows.shape[1:] != (len(ids), 7):
        raise ArgumentError(
            f'poses has the shape {rows.shape}; it must be (N, {len(ids)}, 7) for {len(ids)} '
            'frames, x y z [m] qx qy qz qw'
        )
    return rows, ids, ()


def _value(id: Any) -> int:
    return id.get_value() if isinstance(id, FrameId) else int(id)
