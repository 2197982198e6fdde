"""Planners' queries of a node: many joint states in one call, and whole motions."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from trajectory_msgs.msg import JointTrajectory

from drake_geom_ros.client.left_out import refuse_stale
from drake_geom_ros.client.motions import Motion, joint_trajectory
from drake_geom_ros.client.scene_table import SceneTable
from drake_geom_ros.client.services import (
    JointValues,
    Poses,
    frame_poses,
    joint_positions,
    limit,
)
from drake_geom_ros.client.states import Progress, States, StatesRequest
from drake_geom_ros.math.tolerances import TIME_TOLERANCE


class PlannersQuestions(ABC):
    """Planners' queries, for a client that can call services and has the scene."""

    @abstractmethod
    def ask(self, name: str, /, **fields: Any) -> Any:
        """Call a service that changes nothing; call it again if no response arrives."""

    @abstractmethod
    def _table(self, version: int) -> SceneTable:
        """Return the newest table of ~/scene; wait until it has at least that version."""

    def evaluate_states(
        self,
        joint_names: Sequence[str],
        positions: ArrayLike,
        want: str = 'collision',
        *,
        clearance: float = 0.0,
        max_distance: float = math.inf,
        poses: Poses | None = None,
        stop_at_first: bool = False,
        ignore_limits: bool = False,
        accuracy: str = '',
        progress: Progress | None = None,
        allow_stale: bool = False,
    ) -> States:
        """Evaluate n joint states, ``positions`` (n, q) [rad] or [m].

        A state is free if every pair is certified to be farther apart than ``clearance`` [m].
        Joints that are not named keep their live values. ``want`` is ``collision``, ``least`` or
        ``near`` (all pairs up to ``max_distance`` [m]). States that exceed one response are sent
        in several requests; after each, ``progress`` is called with the numbers of states done
        and of all. Raises RuntimeError if the scene changes between requests, and StaleError if
        the result rests on stale live poses, unless ``allow_stale``.
        """
        request = StatesRequest(
            list(joint_names),
            np.atleast_2d(np.asarray(positions, dtype=np.float64)),
            {
                'want': want,
                'clearance': clearance,
                'max_distance': 0.0 if want != 'near' else limit(max_distance),
                'poses': frame_poses(poses or {}),
                'stop_at_first': stop_at_first,
                'ignore_limits': ignore_limits,
                'accuracy': accuracy,
            },
        )
        answers = request.ask(partial(self.ask, 'evaluate_states'), progress)
        states = States.of(answers, self._table(answers[0].scene_version))
        if not allow_stale:
            refuse_stale('evaluate_states', states.stale_frames)
        return states

    def check_motion(
        self,
        end: Poses | None = None,
        *,
        start: Poses | None = None,
        joint_names: Sequence[str] = (),
        path: ArrayLike = (),
        times: ArrayLike | None = None,
        start_joints: JointValues | None = None,
        min_distance: float = 0.0,
        time_tolerance: float = TIME_TOLERANCE,
        interpolation: str = '',
        max_evaluations: int = 0,
        accuracy: str = '',
        ignore_start_contacts: bool = False,
        ignore_limits: bool = False,
        allow_stale: bool = False,
    ) -> Motion:
        """Return whether a whole motion is clear of ``min_distance`` [m], for all times.

        Either frames move to the poses ``end``, from time 0 to 1, by ``interpolation`` 'slerp' or
        'screw'; or joints move along ``path`` (k, q) [rad] or [m], one column for each of
        ``joint_names``, in straight lines between rows, at ``times`` (k,) [s]. Without ``times``
        the path lasts from 0 to 1 and starts at its first row; a single row is the end.

        ``start`` and ``start_joints`` set the initial poses and joint values; all others are the
        live ones. A path whose first time is later than 0 begins there too. ``time_tolerance``
        [s] is the width to which the time of contact is bracketed. Raises StaleError if the
        result rests on stale live poses, unless ``allow_stale``.
        """
        rows = np.asarray(path, dtype=np.float64)
        trajectory = joint_trajectory(joint_names, rows, times) if rows.size else JointTrajectory()
        answer = self.ask(
            'check_motion',
            start=frame_poses(start or {}),
            end=frame_poses(end or {}),
            start_joints=joint_positions(start_joints or {}),
            path=trajectory,
            min_distance=float(min_distance),
            time_tolerance=float(time_tolerance),
            interpolation=interpolation,
            max_evaluations=max_evaluations,
            accuracy=accuracy,
            ignore_start_contacts=ignore_start_contacts,
            ignore_limits=ignore_limits,
        )
        motion = Motion.of(answer)
        if not allow_stale:
            refuse_stale('check_motion', motion.stale_frames)
        return motion
