"""Pairs of questions about stops, which robots move relative to each other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.motion_queries import JointPath, MotionAnswer, MotionQuestion
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.question_pairs import QuestionPairs
from drake_geom_ros.stopping.robots import RobotState
from drake_geom_ros.stopping.stop import Stop
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


class Judged(NamedTuple):
    """An answer about a path, and the pairs (m,) that it had to look at, beyond boxes."""

    answer: MotionAnswer
    examined: Flags


class PosedPairs:
    """The pairs (m,) of all questions in one world, posed once a moment."""

    def __init__(self, motions: JointMotions, rows: Indices, resolution: float) -> None:
        """``rows`` (m,), ascending, are those of the pairs of ``motions``.

        ``resolution`` is that of shares.
        """
        self.resolution = resolution
        self.rows, self.pairs = rows, np.ascontiguousarray(motions.pairs[rows])
        self._motions, self.queries, self.ids = motions, motions.queries(self.pairs), motions.ids
        self._chain: JointChain | None = None
        self._moment: Moment | None = None
        self._approaching: MovingPairs | None = None
        # Of this moment. Rules of two robots ask the same about the pairs between these.
        self._judged: dict[tuple[object, ...], Judged] = {}

    def take_shapes(self) -> bool:
        """Take the shapes of now if nothing else changed in the scene; return whether it did."""
        self._moment = None
        return self._motions.take_shapes(self.queries)

    def drive_by(self, chain: JointChain) -> None:
        """Take the numbers of a chain, if they are others than those of the last one."""
        if self._chain is not chain:
            self.queries.drive_by(chain)
            self._chain = chain

    def follow(
        self,
        moment: Moment,
        question: MotionQuestion,
        path: JointPath,
        chosen: Indices,
        approaching: MovingPairs,
    ) -> Judged:
        """Return the answer about some places of pairs, which approach as ``approaching`` does."""
        self._be_at(moment)
        skipped = np.ones(len(self.rows), dtype=np.bool_)
        skipped[chosen] = False
        speeds, since = approaching.speeds, approaching.since(moment.ages)
        key = question, *(array.tobytes() for array in (skipped, *path, speeds, since))
        if key not in self._judged:
            if self._approaching is not approaching:
                self.queries.approach(speeds, since)
                self._approaching = approaching
            answer = self.queries.follow(question, path, skipped=skipped)
            self._judged[key] = Judged(answer, self.queries.examined())
        return self._judged[key]

    def _be_at(self, moment: Moment) -> None:
        """Pose all bodies."""
        if self._moment is not moment:
            self.drive_by(moment.chain)
            self.queries.stand(moment.R_PFs, moment.p_PFs)
            self._moment, self._approaching = moment, None
            self._judged.clear()


class MovingPairs:
    """Pairs (k,) of one question that are looked at together, with queries about them."""

    def __init__(self, posed: PosedPairs, about: QuestionPairs, which: Flags) -> None:
        """``which`` (n,) flags those of the question."""
        self._posed, self._speeds = posed, about.speeds
        self._places = np.searchsorted(posed.rows, about.rows[which])
        self._pairs = posed.pairs[self._places]
        self.used = np.unique(self._pairs)
        self._bits = np.packbits(about.relative[which], axis=1)
        # (m,) [m/s] at which all posed pairs approach by themselves; 0: it is not asked about
        self.speeds: Floats = np.zeros(len(posed.rows))
        self.speeds[self._places] = self._of_pairs(self._speeds)

    def _of_pairs(self, each: Floats) -> Floats:
        """Return the sums (k,) of both bodies of pairs."""
        return np.asarray(each[self._pairs[:, 0]] + each[self._pairs[:, 1]])

    def since(self, ages: Floats) -> Floats:
        """Return how far (m,) [m] pairs may have approached since bodies were measured."""
        since = np.zeros(len(self.speeds))
        if ages.any():
            ways = np.where(self._speeds > 0.0, ages, 0.0) * self._speeds
            since[self._places] = self._of_pairs(ways)
        return since

    def moved_by(self, columns: Flags) -> Flags:
        """Return which pairs (k,) move relative to each other with some columns (c,)."""
        return np.asarray((self._bits & np.packbits(columns)).any(axis=1))

    def bodies_of(self, chosen: Flags) -> Indices:
        """Return the places of the bodies of some pairs (k,), each as often as it is in one."""
        return self._pairs[chosen].ravel()

    def of(self, stop: Stop) -> Flags:
        """Return the mask (k,) of the pair that an answer names."""
        return np.asarray((self._posed.ids[self._pairs] == (stop.id_A, stop.id_B)).all(axis=1))

    def follow(
        self, moment: Moment, way: StopPath, chosen: Flags, margin: float, most: int
    ) -> Judged:
        """Return the answer about a path and the ``chosen`` pairs (k,)."""
        widest = float((way.reached[1:] - way.reached[:-1]).max()) or 1.0
        question = MotionQuestion(
            min_distance=margin,
            time_tolerance=0.5 * self._posed.resolution / widest,
            max_evaluations=most,
            quick=True,
        )
        return self._posed.follow(moment, question, way.path, self._places[chosen], self)

    def stop(self, way: StopPath, judged: Judged, chosen: Flags, most: int) -> Stop:
        """Return the answer about a path over shares."""
        answer, end = judged.answer, float(way.reached[-1])
        is_proved = answer.outcome == 'clear'
        looked = int(np.count_nonzero(judged.examined[self._places] & chosen))
        places = (answer.a, answer.b) if answer.a >= 0 else ()
        id_A, id_B = [int(self._posed.ids[place]) for place in places] or (0, 0)
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
            far_pairs=int(np.count_nonzero(chosen)) - looked,
            evaluations=answer.evaluations,
            trouble='max_evaluations were used up before it was proved' if spent else '',
        )
