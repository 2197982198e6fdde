"""Pairs of a question about stops, which robots move relative to each other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.motion_queries import MotionAnswer, MotionQuestion
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.robots import RobotState
from drake_geom_ros.stopping.stop import RESOLUTION, Stop
from drake_geom_ros.stopping.stop_paths import StopPath


class Moment(NamedTuple):
    """Values, speeds and ages at a moment."""

    values: Floats  # (c,)
    velocities: Floats
    states: tuple[RobotState, ...]
    chain: JointChain
    ages: Floats  # (n,) [s] of geometries
    delay: float  # [s]
    R_PFs: Floats
    p_PFs: Floats
    unplaced: Flags  # (n,)


class MovingPairs:
    """Pairs of a question, with queries about them."""

    def __init__(
        self, motions: JointMotions, pairs: Indices, relative: Flags, can_move: Flags, speed: float
    ) -> None:
        self.pairs, self.used = pairs, np.unique(pairs)
        self._bits = np.packbits(relative, axis=1)
        self._speeds = np.where(can_move, speed, 0.0)
        self._of_pairs: Floats = self._speeds[pairs].sum(axis=1)
        self.queries, self._ids = motions.queries(pairs), motions.ids
        self._chain: JointChain | None = None

    def moved_by(self, columns: Flags) -> Flags:
        """Return which pairs (k,) move relative to each other with some columns (c,)."""
        return np.asarray((self._bits & np.packbits(columns)).any(axis=1))

    def be_at(self, moment: Moment) -> None:
        """Pose all bodies, and let those that may move come nearer since they were measured."""
        if self._chain is not moment.chain:
            self.queries.drive_by(moment.chain)
            self._chain = moment.chain
        self.queries.stand(moment.R_PFs, moment.p_PFs)
        since = np.zeros(len(self.pairs))
        if moment.ages.any():
            ways = np.where(self._speeds > 0.0, moment.ages, 0.0) * self._speeds
            since = ways[self.pairs].sum(axis=1)
        self.queries.approach(self._of_pairs, since)

    def follow(self, way: StopPath, asked: Flags, margin: float, most: int) -> MotionAnswer:
        """Return the answer about a path and the ``asked`` pairs (k,)."""
        widest = float(np.diff(way.reached).max(initial=0.0)) or 1.0
        question = MotionQuestion(
            min_distance=margin,
            time_tolerance=0.5 * RESOLUTION / widest,
            max_evaluations=most,
            quick=True,
        )
        return self.queries.follow(question, way.path, skipped=~asked)

    def stop(self, way: StopPath, answer: MotionAnswer, asked: Flags, most: int) -> Stop:
        """Return the answer about a path over shares."""
        is_proved, end = answer.outcome == 'clear', float(way.reached[-1])
        looked = int(np.count_nonzero(self.queries.examined() & asked))
        places = (answer.a, answer.b) if answer.a >= 0 else ()
        id_A, id_B = [int(self._ids[place]) for place in places] or (0, 0)
        spent = not is_proved and 0 < most <= answer.evaluations
        return Stop(
            clear=is_proved and end >= 1.0,
            scale=end if is_proved else way.at(answer.times[0]),
            id_A=id_A,
            id_B=id_B,
            distance=answer.distance,
            error_bound=answer.error_bound,
            p_WCa=answer.p_WCa,
            p_WCb=answer.p_WCb,
            least_clearance=answer.lower_bound if is_proved else -math.inf,
            contact_time=math.inf if is_proved else 0.0,
            pairs=looked,
            far_pairs=int(np.count_nonzero(asked)) - looked,
            evaluations=answer.evaluations,
            trouble='max_evaluations were used up before it was proved' if spent else '',
        )
