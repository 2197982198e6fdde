"""Comparison of recorded pairs of a node with those recomputed now."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import GeometryId, QueryObject
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.recordings.message_types import DISTANCES
from drake_geom_ros.recordings.recorded_witnesses import JudgedWitnesses, Witnesses, fault_of
from drake_geom_ros.replay import RecordedEvent

_BOUND_ONLY = 4  # METHOD_BOUND_ONLY of the messages
Names = Mapping[int, str]  # full names of geometries by id


class Outcome(Enum):
    """Outcome of the audit of a result or event."""

    SAME = 'same to the bit'
    WITHIN = 'within bound'
    REFUTED = 'REFUTED'
    NOT_REPRODUCIBLE = 'not reproducible'


class Compared(NamedTuple):
    """Outcome for a message, with the reason."""

    outcome: Outcome
    because: str = ''


class RecordedPairs(NamedTuple):
    """Pairs by name with distances and witnesses; penetrations count as negative distances."""

    names: list[tuple[str, str]]
    distance: Floats  # (n,) [m]
    error_bound: Floats  # (n,) [m]
    waiting: int  # number of pairs omitted for lack of poses
    reach: float  # [m] pairs farther apart are omitted
    witnesses: Witnesses
    has_points: Flags  # (n,) false: only bounds are known, and points are not guaranteed


def names_in(scene: Any) -> dict[int, str]:
    """Return the full names of the geometries of a Scene message, by id."""
    sources = {source.id: source.name for source in scene.sources}
    frames = {frame.id: frame.name for frame in scene.frames}
    return {
        int(each.id): f'{sources[each.source_id]}::{frames[each.frame_id]}/{each.name}'
        for each in scene.geometries
    }


def recorded_pairs(kind: str, message: Any, names: Names) -> RecordedPairs:
    """Return the pairs of a SignedDistancePairs or PenetrationPairs message.

    Raises KeyError for an id without a name.
    """
    ids = zip(message.id_a.tolist(), message.id_b.tolist(), strict=True)
    is_distance = kind == DISTANCES
    return RecordedPairs(
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
) -> RecordedPairs:
    """Return the pairs that a node would report for the state of a query object."""
    results = query.ComputeSignedDistancePairwiseClosestPoints(reach)
    if kind == DISTANCES:
        witnesses = Witnesses(results.p_ACa, results.p_BCb, results.nhat_BA_W, are_local=True)
        numbers = results.distance, results.error_bound
        points = np.asarray(results.method) != _BOUND_ONLY
        return RecordedPairs(_named(results, names), *numbers, waiting, reach, witnesses, points)
    deep = results.penetrations()
    witnesses = Witnesses(deep.p_WCa, deep.p_WCb, deep.nhat_BA_W, are_local=False)
    numbers, points = (-deep.depth, deep.error_bound), np.asarray(deep.method) != _BOUND_ONLY
    return RecordedPairs(_named(deep, names), *numbers, waiting, reach, witnesses, points)


def _named(results: Any, names: Names) -> list[tuple[str, str]]:
    both = zip(results.id_A.tolist(), results.id_B.tolist(), strict=True)
    return [(names[i], names[j]) for i, j in both]


def compare(
    recorded: RecordedPairs, now: RecordedPairs, query: QueryObject, names: Names
) -> Compared:
    """Return the verdict on recorded pairs, by those computed ``now`` for a query object.

    Witness points and normals that differ are judged by what messages guarantee of them.
    """
    here = {frozenset(pair): k for k, pair in enumerate(now.names)}
    recorded_names = {frozenset(pair) for pair in recorded.names}
    same = len(recorded_names) == len(here) and recorded.waiting == now.waiting
    others: list[tuple[int, int]] = []  # pairs with other witnesses, recorded and computed row
    numbers = recorded.distance.tolist(), recorded.error_bound.tolist()
    rows = zip(recorded.names, *numbers, strict=True)
    for place, (pair, distance, bound) in enumerate(rows):
        if not (math.isfinite(distance) and 0.0 <= bound < math.inf):
            return Compared(Outcome.REFUTED, f'{_called(pair)}: {distance!r} ± {bound!r} m')
        k = here.get(frozenset(pair))
        if k is None:
            if distance + bound < recorded.reach:
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
        if turned or not recorded.witnesses.same(place, now.witnesses, k):
            others.append((place, k))
    for both, k in here.items():
        if both not in recorded_names and now.distance[k] + now.error_bound[k] < recorded.reach:
            why = f'{_called(now.names[k])}, {now.distance[k]} m apart, is left out'
            return Compared(Outcome.REFUTED, f'{why}; filters of the node are to be in the scene')
    if fault := _fault_of_witnesses(recorded, now, others, query, names):
        return Compared(Outcome.REFUTED, fault)
    if same and not others:
        return Compared(Outcome.SAME)
    if recorded.waiting != now.waiting:
        why = f'{recorded.waiting} pairs waited for a pose, and here {now.waiting} do'
        return Compared(Outcome.NOT_REPRODUCIBLE, why)
    return Compared(Outcome.WITHIN)


def _fault_of_witnesses(
    recorded: RecordedPairs,
    now: RecordedPairs,
    others: Sequence[tuple[int, int]],
    query: QueryObject,
    names: Names,
) -> str:
    """Return the first fault of recorded witnesses that differ from those of now; '' for none."""
    by_name = {name: value for value, name in names.items()}
    judged_ones = [(place, k) for place, k in others if recorded.has_points[place]]
    places, here = [place for place, _ in judged_ones], [k for _, k in judged_ones]
    judged = JudgedWitnesses(
        places=places,
        ids=np.array([[by_name[n] for n in recorded.names[k]] for k in places]).reshape(-1, 2),
        distance=recorded.distance[places],
        error_bound=recorded.error_bound[places] + now.error_bound[here],
    )
    fault = fault_of(query, recorded.witnesses, judged)
    return '' if fault is None else f'{_called(recorded.names[places[fault[0]]])}: {fault[1]}'


def of_event_points(
    event: RecordedEvent,
    now: Any,
    query: QueryObject,
    pair: tuple[GeometryId, GeometryId],
    *,
    is_same: bool,
) -> Compared:
    """Return the verdict on the points of an event whose distance was confirmed.

    ``now`` are the results computed for its pair; ``is_same``: the distance is equal to the bit.
    """
    outcome = Outcome.SAME if is_same else Outcome.WITHIN
    if event.points is None or now.method[0] == _BOUND_ONLY:
        return Compared(outcome)
    points = np.vstack((now.p_WCa, now.p_WCb))
    if now.id_A[0] != pair[0].get_value():
        points = points[::-1]
    if np.array_equal(event.points, points):
        return Compared(outcome)
    witnesses = Witnesses(event.points[:1], event.points[1:], None, are_local=False)
    judged = JudgedWitnesses(
        places=[0],
        ids=np.array([[each.get_value() for each in pair]]),
        distance=np.array([event.distance]),
        error_bound=np.array([event.error_bound + float(now.error_bound[0])]),
    )
    fault = fault_of(query, witnesses, judged)
    return Compared(Outcome.WITHIN) if fault is None else Compared(Outcome.REFUTED, fault[1])


def _called(pair: tuple[str, str]) -> str:
    return f'{pair[0]} and {pair[1]}'
