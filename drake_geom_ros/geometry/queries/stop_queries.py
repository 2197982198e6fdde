"""Queries about stops: the largest share of the present speed from which pairs stay apart."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.motion.arrays import CLEAR, CURVE_WIDTH
from drake_geom_ros.geometry._proximity.motion.joint_path import JointPath
from drake_geom_ros.geometry._proximity.runtime.handles import handle_of
from drake_geom_ros.geometry._stops.edges import (
    ALONG,
    AT_END,
    BOXES,
    EACH,
    IN_BOX,
    IN_TIME,
    MOST_EDGES,
)
from drake_geom_ros.geometry._stops.loops import (
    ANSWERED,
    CLEARANCE,
    EDGE_AT,
    LOOKED,
    MEASURES,
    OUT_WIDTH,
    PAIR_AT,
    SCALE,
    TIME_AT,
    StopArrays,
    begin_look,
    end_look,
    measure_stop,
    ways_of_bodies,
)
from drake_geom_ros.geometry._stops.profiles import (
    AGE,
    PROFILE_ROWS,
    REACTION,
    VELOCITY,
    seconds_within,
)
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.joint_trees import JointChain
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Flags, Floats, Indices

__all__ = [
    'AGE',
    'ALONG',
    'AT_END',
    'EACH',
    'IN_TIME',
    'PROFILE_ROWS',
    'REACTION',
    'VELOCITY',
    'StopLook',
    'StopQueries',
    'seconds_within',
]

_NOWHERE = np.full(3, np.nan)
_FINER = 4  # parts of an edge of boxes that is not proved, in the second look at it


class StopLook(NamedTuple):
    """Answer about pairs on the path of a stop; geometries by their place, -1 for none."""

    scale: float  # the share up to which all pairs are proved
    clearance: float  # [m] certified on the way; -inf where not all is proved
    is_proved: bool
    is_whole: bool  # proved for the whole present speed
    evaluations: int
    pairs: int  # that were looked at, beyond boxes
    is_spent: bool  # no more evaluations were left for a proof
    a: int
    b: int
    distance: float  # [m]
    error_bound: float  # [m]
    p_WCa: Floats  # (3,) [m]
    p_WCb: Floats
    near: Flags  # (n,) geometries of the pairs that were looked at
    busy: Flags  # (c,) columns that move these


class StopDemand(NamedTuple):
    """The demand of a look: pairs keep a margin [m], shares are resolved, evaluations limited."""

    margin: float
    resolution: float
    max_evaluations: int  # 0: any number


class _Question(NamedTuple):
    """The arguments of a look."""

    kind: int
    values: Floats
    profile: tuple[Floats, Floats, Floats]
    demand: StopDemand
    places: Indices
    approach: tuple[Floats, Floats]


class _Search(NamedTuple):
    """The result of a search along one path."""

    is_proved: bool
    scale: float
    clearance: float
    evaluations: int
    pairs: int
    edge: int  # where the pair is not proved, or nearest
    time: float
    pair: int  # -1: none


class StopQueries(MotionQueries):
    """Queries about stops in a packed scene whose frames follow a chain; for one thread.

    ``relative`` (m, c) flags the columns that move the bodies of each pair relative to each other.
    """

    def __init__(
        self,
        scene: PackedScene,
        accuracy: AccuracyLike,
        chain: JointChain,
        relative: Flags,
    ) -> None:
        count = relative.shape[1]
        super().__init__(scene, accuracy, np.zeros(1, dtype=np.int64), chain, count)
        none = np.zeros(0)
        self._stops = StopArrays(
            rows=np.zeros((0, count)),
            curves=np.zeros((0, CURVE_WIDTH, count)),
            times=none,
            reached=none,
            relative=np.ascontiguousarray(relative),
            near=np.zeros(len(scene.frames), dtype=np.bool_),
            busy=np.zeros(count, dtype=np.bool_),
            out=np.zeros(OUT_WIDTH),
        )
        self._measures = np.zeros(MEASURES)
        self._make_room(2 + MOST_EDGES)

    def look(
        self,
        kind: int,
        share: float,
        values: Floats,
        profile: tuple[Floats, Floats, Floats],
        demand: StopDemand,
        places: Indices,
        speeds: Floats,
        ages: Floats,
    ) -> StopLook:
        """Return the answer about the pairs at some ``places`` on the path of a ``kind``.

        Of paths over shares only those up to ``share`` matter. ``values`` (c,) are those of
        columns; ``profile`` is as in ``ProfileArrays``. Geometries (n,) may approach by themselves
        at ``speeds`` [m/s], and did so for ``ages`` [s].
        """
        shares = profile[1]
        if len(shares) + MOST_EDGES > len(self._stops.rows):
            self._make_room(len(shares) + MOST_EDGES)
        question = _Question(kind, values, profile, demand, places, (speeds, ages))
        span = 0.0, min(share, float(shares[-1]))
        if kind == EACH:
            search, evaluations, near, busy = self._in_boxes(question, span)
        else:
            search = self._search(question, span)
            evaluations = search.evaluations
            near, busy = self._stops.near.copy(), self._stops.busy.copy()
        return StopLook(
            search.scale,
            search.clearance,
            search.is_proved,
            search.is_proved and (kind not in (ALONG, EACH) or search.scale >= 1.0),
            evaluations,
            search.pairs,
            not search.is_proved and 0 < demand.max_evaluations <= search.evaluations,
            *self._pair(search),
            near,
            busy,
        )

    def _in_boxes(
        self, question: _Question, span: tuple[float, float]
    ) -> tuple[_Search, int, Flags, Flags]:
        """Return where pairs are proved whose columns stop each by itself, and the evaluations.

        Return also the flags of all bodies and columns that were looked at. Where other pairs
        allow less than the whole speed, one box mostly proves as much. An edge of boxes that is
        not proved is looked at again in parts, whose boxes are smaller.
        """
        near, busy = np.zeros_like(self._stops.near), np.zeros_like(self._stops.busy)
        spent = 0

        def search(kind: int, part: tuple[float, float], parts: int) -> _Search:
            nonlocal near, busy, spent
            it = self._search(question._replace(kind=kind), part, parts)
            near, busy = near | self._stops.near, busy | self._stops.busy
            spent += it.evaluations
            return it

        if span[1] < 1.0 and (box := search(IN_BOX, span, 1)).is_proved:
            return box, spent, near, busy
        first = search(EACH, span, BOXES)
        if first.is_proved:
            return first, spent, near, busy
        begin, end = self._stops.reached[first.edge : first.edge + 2].tolist()
        again = search(EACH, (begin, end), _FINER)
        if again.scale > first.scale:
            again = again._replace(is_proved=False, clearance=-math.inf, pairs=first.pairs)
            return again, spent, near, busy
        self._begin(question, span, BOXES)  # the path on which its pair was found
        return first, spent, near, busy

    def _begin(self, question: _Question, span: tuple[float, float], parts: int) -> int:
        """Write the path over a span of shares, in so many parts; return its number of edges."""
        demand = question.demand
        return int(
            begin_look(
                self._loops.handle,
                self._handle,
                (question.kind, *span, parts),
                question.values,
                question.profile,
                (demand.margin, demand.resolution, demand.max_evaluations),
                (question.places, *question.approach),
            )
        )

    def _search(self, question: _Question, span: tuple[float, float], parts: int = 1) -> _Search:
        """Return where the pairs are proved on the path over a span of shares."""
        edges, stops = self._begin(question, span, parts), self._stops
        path = stops.rows, stops.curves, stops.times
        verdict = self._loops.search(path, 0, edges)
        self._refuse(verdict, 0)
        end_look(self._loops.handle, self._handle, edges, verdict, question.places)
        out = stops.out.tolist()
        return _Search(
            verdict == CLEAR,
            out[SCALE],
            out[CLEARANCE],
            int(out[ANSWERED]),
            int(out[LOOKED]),
            int(out[EDGE_AT]),
            out[TIME_AT],
            int(out[PAIR_AT]),
        )

    def _pair(self, it: _Search) -> tuple[int, int, float, float, Floats, Floats]:
        """Return both bodies of a pair, their distance and its error bound [m], and both points.

        The path on which it was found is the present one.
        """
        if it.pair < 0:
            return -1, -1, math.inf, 0.0, _NOWHERE, _NOWHERE
        stops = self._stops
        path = JointPath(stops.rows, stops.curves, stops.times)
        batch = self._loops.row(path, it.edge, it.time, it.pair)
        row, (a, b) = self._padded_rows(batch)[0], batch.ids[0].tolist()
        witness_a, witness_b = row[WITNESS_A : WITNESS_A + 3], row[WITNESS_B : WITNESS_B + 3]
        return a, b, float(row[DISTANCE]), float(row[ERROR_BOUND]), witness_a, witness_b

    def ways(self, sizes: Floats, ways: Floats) -> Floats:
        """Return how far (n,) [m] all points of geometries go at most while columns go ``ways``.

        Values of columns are no larger than ``sizes`` (c,) meanwhile.
        """
        out = np.empty(len(self._stops.near))
        ways_of_bodies(self._loops.handle, sizes, ways, out)
        return out

    def measures(
        self,
        values: Floats,
        profile: tuple[Floats, Floats, Floats],
        share: float,
        moving: Flags,
        turns: Floats,
    ) -> list[float]:
        """Return the time [s] and the way [m] of the longest stop that is known.

        Return the speeds of the fastest point [m/s] and turn [rad/s] at a share of the present
        speed, too. Ways and points are those of the geometries that ``moving`` (n,) flags; a joint
        turns by ``turns`` (c,) [rad] for each column's unit.
        """
        measure_stop(self._loops.handle, values, profile, share, moving, turns, self._measures)
        return self._measures.tolist()

    def _make_room(self, rows: int) -> None:
        count = self._stops.rows.shape[1]
        self._stops = self._stops._replace(
            rows=np.zeros((rows, count)),
            curves=np.zeros((rows, CURVE_WIDTH, count)),
            times=np.zeros(rows),
            reached=np.zeros(rows),
        )
        self._handle = handle_of(self._stops)
