"""Pairs of questions about stops, which robots move relative to each other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.queries.joint_motions import JointMotions
from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.stop_queries import StopDemand, StopLook
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.stopping.question_pairs import QuestionPairs
from drake_geom_ros.stopping.robots import RobotState
from drake_geom_ros.stopping.stop import Stop
from drake_geom_ros.stopping.stop_profile import StopProfile


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
    is_known: bool  # the values of all columns, and where all geometries are


class ChosenPairs(NamedTuple):
    """Those of some pairs (k,) that move, and their bodies."""

    flags: Flags  # (k,)
    places: Indices  # of the pairs in one world
    bodies: Flags  # (n,)
    key: bytes  # the same for the same pairs whose bodies approach each other at the same speeds


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
        self.turns = np.zeros(0)  # (c,) see ``turns_of``
        self._moment: Moment | None = None
        # Of this moment. Rules of two robots ask the same about the pairs between these.
        self._looks: dict[tuple[object, ...], StopLook] = {}

    def take_shapes(self) -> bool:
        """Take the shapes of now if nothing else changed in the scene; return whether it did."""
        self._moment = None
        return self._motions.take_shapes(self.queries)

    def be_at(self, moment: Moment) -> None:
        """Take the poses of all bodies at a moment, and where robots stand."""
        if self._moment is moment:
            return
        if self._chain is not moment.chain:
            self.queries.drive_by(moment.chain)
            self._chain = moment.chain
            self.turns = turns_of(moment.chain, len(moment.values))
        self.queries.stand(moment.R_PFs, moment.p_PFs)
        self._moment = moment
        self._looks.clear()

    def look(
        self,
        moment: Moment,
        kind: int,
        share: float,
        profile: StopProfile,
        demand: StopDemand,
        chosen: ChosenPairs,
        speeds: Floats,
    ) -> StopLook:
        """Return the answer about the chosen pairs, as ``StopQueries.look`` does."""
        self.be_at(moment)
        arrays = profile.columns, profile.shares, profile.times
        key = kind, share, demand, chosen.key, *(each.tobytes() for each in arrays)
        if (it := self._looks.get(key)) is None:
            values, places, ages = moment.values, chosen.places, moment.ages
            it = self.queries.look(kind, share, values, arrays, demand, places, speeds, ages)
            self._looks[key] = it
        return it


class MovingPairs:
    """Pairs (k,) of one question that are looked at together, with queries about them."""

    def __init__(self, posed: PosedPairs, about: QuestionPairs, which: Flags) -> None:
        """``which`` (n,) flags those of the question."""
        self._posed, self._speeds = posed, np.ascontiguousarray(about.speeds)
        self._places = np.searchsorted(posed.rows, about.rows[which])
        self._pairs = posed.pairs[self._places]
        self.used = np.unique(self._pairs)
        self._bits = np.packbits(about.relative[which], axis=1)
        self._chosen: tuple[bytes, ChosenPairs] | None = None

    def moved_by(self, columns: Flags) -> Flags:
        """Return which pairs (k,) move relative to each other with some columns (c,)."""
        return np.asarray((self._bits & np.packbits(columns)).any(axis=1))

    def chosen_by(self, columns: Flags) -> ChosenPairs:
        """Return the pairs that move relative to each other with some columns (c,)."""
        key = columns.tobytes()  # mostly the same columns move as in the last cycle
        if self._chosen is None or self._chosen[0] != key:
            self._chosen = key, self._those(self.moved_by(columns))
        return self._chosen[1]

    def of(self, chosen: ChosenPairs, stop: Stop) -> ChosenPairs:
        """Return the chosen pair that an answer names; none if it is not among them."""
        ids = self._posed.ids[self._pairs]
        return self._those(chosen.flags & (ids == (stop.id_A, stop.id_B)).all(axis=1))

    def _those(self, flags: Flags) -> ChosenPairs:
        bodies = np.zeros(len(self._posed.ids), dtype=np.bool_)
        bodies[self._pairs[flags].ravel()] = True
        places = self._places[flags]
        return ChosenPairs(flags, places, bodies, places.tobytes() + self._speeds.tobytes())

    def look(
        self,
        moment: Moment,
        kind: int,
        share: float,
        profile: StopProfile,
        demand: StopDemand,
        chosen: ChosenPairs,
    ) -> StopLook:
        """Return the answer about the chosen pairs on the path of a ``kind`` up to a share."""
        return self._posed.look(moment, kind, share, profile, demand, chosen, self._speeds)

    def stop(self, it: StopLook, chosen: ChosenPairs) -> Stop:
        """Return the answer about the chosen pairs on a path over shares."""
        ids = self._posed.ids
        return Stop(
            clear=it.is_whole,
            scale=it.scale,
            id_A=int(ids[it.a]) if it.a >= 0 else 0,
            id_B=int(ids[it.b]) if it.a >= 0 else 0,
            distance=it.distance,
            error_bound=it.error_bound,
            p_WCa=it.p_WCa,
            p_WCb=it.p_WCb,
            least_clearance=it.clearance,
            contact_time=math.inf if it.is_proved else 0.0,
            pairs=it.pairs,
            far_pairs=len(chosen.places) - it.pairs,
            evaluations=it.evaluations,
            trouble='max_evaluations were used up before it was proved' if it.is_spent else '',
        )


def turns_of(chain: JointChain, count: int) -> Floats:
    """Return how fast (count,) [rad] a joint turns for each column's unit of speed; 0: slides."""
    turns = np.zeros(count)
    led = (chain.leaders >= 0) & (chain.kinds == JointKind.REVOLUTE)
    np.maximum.at(turns, chain.leaders[led], np.abs(chain.multipliers[led]))
    return turns
