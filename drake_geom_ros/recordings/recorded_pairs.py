"""What a node said of pairs, as it was recorded, beside what is computed of them now."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryId, QueryObject
from drake_geom_ros.recordings.message_types import DISTANCES
from drake_geom_ros.recordings.witnesses import Judged, Witnesses, fault_of
from drake_geom_ros.replay import RecordedEvent

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
_BOUND_ONLY = 4  # METHOD_BOUND_ONLY of the messages
Names = Mapping[int, str]  # full names of geometries by id


class Outcome(Enum):
    """What is true of something that a node said."""

    SAME = 'same to the bit'
    WITHIN = 'within bound'
    REFUTED = 'REFUTED'
    NOT_REPRODUCIBLE = 'not reproducible'


class Compared(NamedTuple):
    """What is true of a message, and why."""

    outcome: Outcome
    because: str = ''


class Pairs(NamedTuple):
    """Pairs by their names, and what is told of each; of penetrations, too, as distances."""

    names: list[tuple[str, str]]
    distance: Floats  # (n,) [m]
    error_bound: Floats  # (n,) [m]
    waiting: int  # how many pairs are left out for want of poses
    reach: float  # [m] farther apart than this they are left out
    witnesses: Witnesses
    has_points: Flags  # (n,) false: bounds alone are told, and points promise nothing


def names_in(scene: Any) -> dict[int, str]:
    """Return the full names of the geometries of a Scene message, by id."""
    sources = {source.id: source.name for source in scene.sources}
    frames = {frame.id: frame.name for frame in scene.frames}
    return {
        int(each.id): f'{sources[each.source_id]}::{frames[each.frame_id]}/{each.name}'
        for each in scene.geometries
    }


def recorded_pairs(kind: str, message: Any, names: Names) -> Pairs:
    """Return what a SignedDistancePairs or PenetrationPairs says.

    Raises KeyError for an id without a name.
    """
    ids = zip(message.id_a.tolist(), message.id_b.tolist(), strict=True)
    is_distance = kind == DISTANCES
    return Pairs(
        names=[(names[i], names[j]) for i, j in ids],
        distance=message.distance if is_distance else -message.depth,
        error_bound=message.error_bound,
        waiting=int(message.waiting_pairs),
        reach=float(message.max_distance) if is_distance else 0.0,
        witnesses=Witnesses(
            p_A=np.reshape(message.p_aca if is_distance else message.p_wca, (-1, 3)),
            p_B=np.reshape(message.p_bcb if is_distance else message.p_wcb, (-1, 3)),
            nhat_BA_W=np.reshape(message.nhat_ba_w, (-1, 3)),
            are_local=is_distance,
        ),
        has_points=np.asarray(message.method) != _BOUND_ONLY,
    )


def computed_pairs(
    kind: str, query: QueryObject, names: Names, waiting: int, reach: float
) -> Pairs:
    """Return what a node would say now."""
    found = query.ComputeSignedDistancePairwiseClosestPoints(reach)
    if kind == DISTANCES:
        witnesses = Witnesses(found.p_ACa, found.p_BCb, found.nhat_BA_W, are_local=True)
        told = found.distance, found.error_bound
        points = np.asarray(found.method) != _BOUND_ONLY
        return Pairs(_named(found, names), *told, waiting, reach, witnesses, points)
    deep = found.penetrations()
    witnesses = Witnesses(deep.p_WCa, deep.p_WCb, deep.nhat_BA_W, are_local=False)
    told, points = (-deep.depth, deep.error_bound), np.asarray(deep.method) != _BOUND_ONLY
    return Pairs(_named(deep, names), *told, waiting, reach, witnesses, points)


def _named(found: Any, names: Names) -> list[tuple[str, str]]:
    both = zip(found.id_A.tolist(), found.id_B.tolist(), strict=True)
    return [(names[i], names[j]) for i, j in both]


def compare(said: Pairs, now: Pairs, query: QueryObject, names: Names) -> Compared:
    """Return whether what a node said is what is computed ``now`` of the state of a query object.

    Witness points and normals that are others than now are judged by what is promised of them.
    """
    here = {frozenset(pair): k for k, pair in enumerate(now.names)}
    told = {frozenset(pair) for pair in said.names}
    same = len(told) == len(here) and said.waiting == now.waiting
    others: list[tuple[int, int]] = []  # pairs of other witnesses, there and here
    rows = zip(said.names, said.distance.tolist(), said.error_bound.tolist(), strict=True)
    for place, (pair, distance, bound) in enumerate(rows):
        if not (math.isfinite(distance) and 0.0 <= bound < math.inf):
            return Compared(Outcome.REFUTED, f'{_called(pair)}: {distance!r} ± {bound!r} m')
        k = here.get(frozenset(pair))
        if k is None:
            if distance + bound < said.reach:
                why = f'{_called(pair)} is no pair that queries report here; it says {distance} m'
                return Compared(Outcome.REFUTED, why)
            same = False
            continue
        there, other = float(now.distance[k]), float(now.error_bound[k])
        same = same and (distance, bound) == (there, other)
        if not abs(distance - there) <= bound + other:
            why = f'{_called(pair)}: it says {distance!r} m ± {bound:.1e} m, and it is {there!r} m'
            return Compared(Outcome.REFUTED, f'{why} ± {other:.1e} m')
        turned = now.names[k] != pair
        if turned or not said.witnesses.same(place, now.witnesses, k):
            others.append((place, k))
    for both, k in here.items():
        if both not in told and now.distance[k] + now.error_bound[k] < said.reach:
            why = f'{_called(now.names[k])}, {now.distance[k]} m apart, is left out'
            return Compared(Outcome.REFUTED, f'{why}; filters of the node are to be in the scene')
    if fault := _fault_of_witnesses(said, now, others, query, names):
        return Compared(Outcome.REFUTED, fault)
    if same and not others:
        return Compared(Outcome.SAME)
    if said.waiting != now.waiting:
        why = f'{said.waiting} pairs waited for a pose, and here {now.waiting} do'
        return Compared(Outcome.NOT_REPRODUCIBLE, why)
    return Compared(Outcome.WITHIN)


def _fault_of_witnesses(
    said: Pairs, now: Pairs, others: Sequence[tuple[int, int]], query: QueryObject, names: Names
) -> str:
    """Return in words what cannot be of witnesses that are not those of now; empty: all can."""
    by_name = {name: value for value, name in names.items()}
    judged_ones = [(place, k) for place, k in others if said.has_points[place]]
    places, here = [place for place, _ in judged_ones], [k for _, k in judged_ones]
    judged = Judged(
        places=places,
        ids=np.array([[by_name[n] for n in said.names[k]] for k in places]).reshape(-1, 2),
        distance=said.distance[places],
        error_bound=said.error_bound[places] + now.error_bound[here],
    )
    fault = fault_of(query, said.witnesses, judged)
    return '' if fault is None else f'{_called(said.names[places[fault[0]]])}: {fault[1]}'


def of_event_points(
    event: RecordedEvent,
    now: Any,
    query: QueryObject,
    pair: tuple[GeometryId, GeometryId],
    *,
    is_same: bool,
) -> Compared:
    """Return whether the points of an event can be those of its pair, whose distance is right.

    ``now`` is what is computed of the pair, ``is_same`` whether to the bit.
    """
    outcome = Outcome.SAME if is_same else Outcome.WITHIN
    if event.points is None or now.method[0] == _BOUND_ONLY:
        return Compared(outcome)
    points = np.vstack((now.p_WCa, now.p_WCb))
    if now.id_A[0] != pair[0].get_value():
        points = points[::-1]
    if np.array_equal(event.points, points):
        return Compared(outcome)
    said = Witnesses(event.points[:1], event.points[1:], None, are_local=False)
    judged = Judged(
        places=[0],
        ids=np.array([[each.get_value() for each in pair]]),
        distance=np.array([event.distance]),
        error_bound=np.array([event.error_bound + float(now.error_bound[0])]),
    )
    fault = fault_of(query, said, judged)
    return Compared(Outcome.WITHIN) if fault is None else Compared(Outcome.REFUTED, fault[1])


def _called(pair: tuple[str, str]) -> str:
    return f'{pair[0]} and {pair[1]}'
