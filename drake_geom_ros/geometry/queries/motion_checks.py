"""``CheckMotion``, the continuous collision query, and its result."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError, PoseError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.queries.accuracy import Accuracy, AccuracyLike
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.motion_queries import (
    INTERPOLATIONS,
    MotionAnswer,
    MotionQueries,
    MotionQuestion,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import TIME_TOLERANCE


@dataclass(frozen=True, eq=False)
class MotionCheck:
    """Certified result for a whole motion.

    ``outcome`` is

    - ``'clear'``: every pair is certified to stay farther apart than ``min_distance``, and no
      pair comes nearer than ``lower_bound``; ``times`` are both the end;
    - ``'contact'``: the motion is certified to be clear until ``times[0]``, and at ``times[1]`` a
      pair is certified to be no farther apart than ``min_distance``. The two times differ by no
      more than the tolerance;
    - ``'unknown'``: the motion is certified to be clear until ``times[0]``, and nothing is proved
      after it. The evaluations were used up, or rounding hides the truth because bodies touch and
      part, or come very slowly. ``times[1]`` is the end (of a path, that of the edge in question),
      or an earlier time at which the pair is certified to touch.

    Two half spaces that are not opposed overlap. A pair of them whose bodies do not move relative
    to each other is judged at the start. For other such pairs a proof needs that no frame turns:
    planes that turn cross at once, so the outcome is 'unknown' from the start on and names the
    pair. Filter the pair if that is not wanted.

    ``id_A < id_B`` is the reported pair, ``distance`` and ``error_bound`` are its values at
    ``time``, with the witness points ``p_WCa`` and ``p_WCb`` (3,) in World [m] (NaN for two half
    spaces). It depends on the outcome:

    - contact: the pair that touches, at ``times[1]``;
    - unknown: the pair without a proof, at ``times[0]``;
    - clear: the pair with the smallest computed distance. If bounds alone proved that all pairs
      stay apart, the distance is infinite and there are no ids.

    ``lower_bound`` [m] is the smallest of all proved bounds. ``evaluations`` is the number of
    kernel calls, ``ignored`` the number of pairs that ``ignore_start_contacts`` left out.
    """

    outcome: str
    times: tuple[float, float]
    id_A: GeometryId | None
    id_B: GeometryId | None
    distance: float
    error_bound: float
    lower_bound: float
    time: float
    p_WCa: Floats
    p_WCb: Floats
    evaluations: int
    ignored: int

    @property
    def last_free(self) -> float:
        """The latest time until which the motion is proved to be clear."""
        return self.times[0]

    def __bool__(self) -> bool:
        """Raise TypeError, because an unknown outcome is neither true nor false."""
        raise TypeError("a MotionCheck is neither true nor false: ask whether outcome == 'clear'")

    @classmethod
    def of(cls, answer: MotionAnswer, ids: NDArray[np.int64]) -> MotionCheck:
        """Return the result for an answer by places, with the ids (n,) of these."""
        both = sorted((int(ids[answer.a]), int(ids[answer.b]))) if answer.a >= 0 else []
        return cls(
            outcome=answer.outcome,
            times=answer.times,
            id_A=GeometryId(both[0]) if both else None,
            id_B=GeometryId(both[1]) if both else None,
            distance=answer.distance,
            error_bound=answer.error_bound,
            lower_bound=answer.lower_bound,
            time=answer.time,
            p_WCa=answer.p_WCa,
            p_WCb=answer.p_WCb,
            evaluations=answer.evaluations,
            ignored=answer.ignored,
        )


class MotionChecks:
    """Base of ``QueryObject`` with the query for motions."""

    _context: SceneGraphContext | None
    _state: ContextState

    def CheckMotion(
        self,
        end_poses: FramePoseVector,
        min_distance: float = 0.0,
        time_tolerance: float = TIME_TOLERANCE,
        interpolation: Literal['slerp', 'screw'] | str = 'slerp',
        max_evaluations: int = 0,
        accuracy: AccuracyLike = '',
        *,
        ignore_start_contacts: bool = False,
        bound_tolerance: float = math.inf,
    ) -> MotionCheck:
        """Return whether the whole motion to ``end_poses`` is clear, certified for all times.

        Every frame of ``end_poses`` moves from its current pose X_PF, at time 0, to that one, at
        time 1; all others stay. Filters and paddings apply. A proof between two times shows that
        no point moves far enough to close the distance (Schwarzer, Saha, Latombe, Exact collision
        checking of robot paths, WAFR 2002), or that a plane separates the bodies, see
        ``_proximity/motion/planes.py``.

        Args:
            end_poses: Poses X_PF at time 1, of the frames that move.
            min_distance: Pairs are clear while farther apart than this [m].
            time_tolerance: Longest time span that may contain the first contact; 1 only asks
                whether there is a contact. Smaller values than 2^-40 count as 2^-40.
            interpolation: 'slerp' moves the position on a line and rotates about one axis by the
                shorter way; 'screw' moves both on one screw.
            max_evaluations: Limit of kernel calls, 0 for none.
            accuracy: Accuracy level or length [m], '' for the default one.
            ignore_start_contacts: Leave out pairs that are not clear at the start, and count them
                in ``ignored``.
            bound_tolerance: ``lower_bound`` is only as large as the proof needs. If the motion is
                clear, go on to prove more until the bound is at most this [m] below the smallest
                computed distance, or until rounding or ``max_evaluations`` ends it.

        Raises:
            ArgumentError: An argument is out of range, or the frames carry nothing that could
                collide.
            PoseError: A frame is not in this scene or has never received a pose.

            >>> from drake_geom_ros.geometry import *
            >>> from drake_geom_ros.math import RigidTransform
            >>> graph = SceneGraph()
            >>> source = graph.RegisterSource('example')
            >>> def ball(name, radius):
            ...     frame = graph.RegisterFrame(source, GeometryFrame(name))
            ...     body = GeometryInstance(RigidTransform(), Sphere(radius), 'ball')
            ...     body.set_proximity_properties(ProximityProperties())
            ...     graph.RegisterGeometry(source, frame, body)
            ...     return frame
            >>> moving, resting = ball('moving', 0.1), ball('resting', 0.2)
            >>> context = graph.CreateDefaultContext()
            >>> poses = {moving: RigidTransform(), resting: RigidTransform([1, 0, 0])}
            >>> graph.get_source_pose_port(source).FixValue(context, FramePoseVector(poses))
            >>> query = graph.get_query_output_port().Eval(context)
            >>> end = FramePoseVector({moving: RigidTransform([2, 0, 0])})
            >>> check = query.CheckMotion(end)
            >>> check.outcome, round(check.times[1], 5)
            ('contact', 0.35)
            >>> end = FramePoseVector({moving: RigidTransform([0, 2, 0])})
            >>> query.CheckMotion(end).outcome
            'clear'
        """
        question = MotionQuestion(
            *(float(min_distance), float(time_tolerance), max_evaluations),
            *(ignore_start_contacts, float(bound_tolerance)),
        )
        if interpolation not in INTERPOLATIONS:
            allowed = ', '.join(INTERPOLATIONS)
            raise ArgumentError(f'interpolation={interpolation!r} must be one of {allowed}')
        checked_type(end_poses, FramePoseVector, 'CheckMotion: end_poses')
        state, context = self._state, self._context
        wanted = state.accuracy_for(None if accuracy == '' else accuracy)
        assert context is not None  # else it has no accuracy
        ids, ends = arrays_of(end_poses)
        world = state.posed_world()  # raises where a frame has no pose
        world.update()  # applies the latest poses
        # Any other change of a state changes one of these. A frame that is posed away from its
        # weld changes the filters of this state alone, hence the set.
        kind = (
            *(ids.tobytes(), wanted, state.model.versions.any, state.filters.version),
            frozenset(state.filters.welded),
        )
        queries = state.prepared_motions.take(kind)
        if queries is None or len(world.unposed_frames()):
            queries = _prepared(context, ids, wanted)
        else:
            queries.stand(world.R_PFs, world.p_PFs)
        rows = queries.moved
        starts = np.hstack((world.R_PFs[rows].reshape(-1, 9), world.p_PFs[rows]))
        answer = queries.move(question, starts, np.ascontiguousarray(ends), interpolation)
        state.prepared_motions.keep(kind, queries)
        return MotionCheck.of(answer, world.geometries.ids)


def _prepared(context: SceneGraphContext, ids: Indices, accuracy: Accuracy) -> MotionQueries:
    """Return queries about motions of the frames with these id values (f,).

    Raises PoseError and ArgumentError as ``CheckMotion`` does.
    """
    state = state_of(context)
    scene, _ = PackedScene.of(context, ids, about_points=False)
    world = state.up_to_date_world()
    if len(lost := ids[~world.placed[scene.moved]]):
        raise PoseError(
            'CheckMotion was asked of frames that have no pose to start from: '
            f'{state.describe(lost.tolist())}'
        )
    if not scene.has_moving_pairs():
        raise ArgumentError(
            'CheckMotion was asked of frames that carry no geometry which could collide with '
            f'any other: {state.describe(ids.tolist()) or "no frame"}. It would be clear '
            'of what nobody looks at; filters may leave all of it out'
        )
    return MotionQueries(scene, accuracy, np.zeros(1, dtype=np.int64))
