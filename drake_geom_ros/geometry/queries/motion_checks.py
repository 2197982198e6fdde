"""The query for motions, and what it returns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError, PoseError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.motion_queries import (
    INTERPOLATIONS,
    FoundMotion,
    MotionQueries,
    MotionQuestion,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MotionCheck:
    """What is true of a whole motion.

    ``outcome`` is

    - ``'clear'``: every pair is certified to stay farther apart than ``min_distance``, and no
      pair comes nearer than ``lower_bound``; ``times`` are both the end;
    - ``'contact'``: all is certified to be clear until ``times[0]``, and at ``times[1]`` the pair
      is certified to be no farther apart than ``min_distance``. They are no farther apart than
      the tolerance;
    - ``'unknown'``: all is certified to be clear until ``times[0]``, and from there on nothing is
      proved, because evaluations were spent, or because bodies touch and part, or come so slowly,
      that rounding hides what is true. ``times[1]`` is the end, of a path that of the edge that
      was looked at, or an earlier time at which they are certified to touch.

    Two half spaces that are not opposed overlap. A pair that no frame moves against one another is
    what it is at the start; of others nothing is proved unless all frames of ``CheckMotion`` go
    straight: planes that turn cross at once, so the outcome is 'unknown' from the start on and
    names the pair. Where that does not count, filter it.

    ``id_A < id_B`` are the pair that is told, ``distance`` and ``error_bound`` its own at
    ``time``, with the witness points ``p_WCa`` and ``p_WCb`` (3,) in World [m] (NaN of two half
    spaces): of a contact the pair that touches, at ``times[1]``; of an unknown outcome the pair
    that is not proved, at ``times[0]``; of a clear one the least distance that was seen. (Where no
    pair had to be looked at, that is infinite and there are no ids: bounds alone proved that all
    stay apart.)
    ``lower_bound`` [m] is the least of all bounds that were proved. ``evaluations`` is how many
    pairs were answered by kernels, ``ignored`` how many pairs were left out because they were not
    clear at the start, as was asked for.
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
        """The latest time until which all is proved to be clear."""
        return self.times[0]

    def __bool__(self) -> bool:
        """Refuse to stand for yes or no: an unknown outcome is neither."""
        raise TypeError("a MotionCheck is neither true nor false: ask whether outcome == 'clear'")

    @classmethod
    def of(cls, found: FoundMotion, ids: NDArray[np.int64]) -> MotionCheck:
        """Return what was found, with the ids (n,) of geometries by their place."""
        both = sorted((int(ids[found.a]), int(ids[found.b]))) if found.a >= 0 else []
        return cls(
            outcome=found.outcome,
            times=found.times,
            id_A=GeometryId(both[0]) if both else None,
            id_B=GeometryId(both[1]) if both else None,
            distance=found.distance,
            error_bound=found.error_bound,
            lower_bound=found.lower_bound,
            time=found.time,
            p_WCa=found.p_WCa,
            p_WCb=found.p_WCb,
            evaluations=found.evaluations,
            ignored=found.ignored,
        )


class MotionChecks:
    """What a query object answers about motions; it has all other queries too."""

    _context: SceneGraphContext | None
    _state: ContextState

    def CheckMotion(
        self,
        end_poses: FramePoseVector,
        min_distance: float = 0.0,
        time_tolerance: float = TIME_TOLERANCE,
        interpolation: str = 'slerp',
        max_evaluations: int = 0,
        accuracy: str = '',
        *,
        ignore_start_contacts: bool = False,
        bound_tolerance: float = math.inf,
    ) -> MotionCheck:
        """Return whether the whole motion to ``end_poses`` is clear, certified for all times.

        Every frame of ``end_poses`` goes from its pose X_PF of now, at time 0, to that one, at
        time 1; all others stay. By ``interpolation`` 'slerp' its position goes straight and its
        rotation about one axis by the shorter way; by 'screw' both follow one screw. Clear is what
        stays farther apart than ``min_distance`` [m], of all pairs that no filter leaves out, with
        their paddings. ``time_tolerance`` is the longest span that may hold the first contact: 1
        asks only whether there is one. Less than 2^-40 counts as that.
        ``max_evaluations`` ends the search after so many pairs were answered (0: no limit).
        ``ignore_start_contacts`` leaves out pairs that are not clear at the start, of every part
        of the answer, and counts them in ``ignored``. ``lower_bound`` is only as large as the
        proof needs; with a ``bound_tolerance`` [m] more is proved of a clear motion, until the
        bound is no farther than that below the least distance that was seen, or rounding or the
        budget ends it.

        Proved is what keeps two bodies apart between two times: that their points cannot come as
        far as they are apart (Schwarzer, Saha, Latombe, Exact collision checking of robot paths,
        WAFR 2002), or a plane between them, see ``_proximity/motion/planes.py``.

        Raises ArgumentError for what cannot be asked, and where these frames carry nothing that
        could collide; PoseError for frames that are not here or never had a pose.

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
        asked = MotionQuestion(
            *(float(min_distance), float(time_tolerance), max_evaluations),
            *(ignore_start_contacts, float(bound_tolerance)),
        )
        if interpolation not in INTERPOLATIONS:
            allowed = ', '.join(INTERPOLATIONS)
            raise ArgumentError(f'interpolation={interpolation!r} must be one of {allowed}')
        checked_type(end_poses, FramePoseVector, 'CheckMotion: end_poses')
        state, context = self._state, self._context
        level = state.level(accuracy or None)
        assert context is not None  # else it has no level
        ids, ends = arrays_of(end_poses)
        world = state.posed_world()  # raises where a frame has no pose
        world.update()  # takes the poses that were given
        # Whatever else changes in a state changes one of these; a frame that is posed away from
        # where it is welded changes the filters of the state that poses it alone.
        kind = (
            *(ids.tobytes(), level, state.model.versions.any, state.filters.version),
            frozenset(state.filters.welded),
        )
        queries = state.prepared_motions.take(kind)
        if queries is None or len(world.unposed_frames()):
            queries = _prepared(context, ids, level)
        else:
            queries.stand(world.R_PFs, world.p_PFs)
        rows = queries.moved
        starts = np.hstack((world.R_PFs[rows].reshape(-1, 9), world.p_PFs[rows]))
        found = queries.move(asked, starts, np.ascontiguousarray(ends), interpolation)
        state.prepared_motions.keep(kind, queries)
        return MotionCheck.of(found, world.geometries.ids)


def _prepared(context: SceneGraphContext, ids: Indices, level: str) -> MotionQueries:
    """Return queries about motions of frames (f,), by the values of their ids.

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
    return MotionQueries(scene, level, np.zeros(1, dtype=np.int64))
