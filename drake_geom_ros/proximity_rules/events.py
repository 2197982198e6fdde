"""Events of rules: each reports one change of one rule."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.array_types import Flags
from drake_geom_ros.proximity_rules.decisions import Entered, Poses
from drake_geom_ros.proximity_rules.measured import Measured
from drake_geom_ros.proximity_rules.nearest_pairs import NearestPairs
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, Why
from drake_geom_ros.proximity_rules.watched_pairs import WatchedPairs
from drake_geom_ros.stopping import Stop

Ids = NDArray[np.int64]
_NOBODY = np.full(3, math.nan)


class Event(NamedTuple):
    """One change of one rule.

    The pair is the rule's nearest, or for SOON the pair that would touch first. If no pair was
    near enough, ids are 0, the distance is inf and points are NaN. For STALE, NO_POSE,
    TWO_SENDERS and OTHER_CLOCK ``id_A`` is a geometry without a valid pose, and the distance is
    NaN.

    The lower bound was compared with ``limit_distance``, which is ``enter`` of the rule, or
    ``leave`` if the rule is left. For CANNOT_STOP that is its ``margin``, and the pair, the
    distance and the points are those of the moment on the way from which on nothing is proved.
    """

    sequence: int
    rule: str
    level: Level
    is_entered: bool
    why: Why
    id_A: int = 0
    id_B: int = 0
    distance: float = math.inf  # [m]
    error_bound: float = 0.0  # [m]
    p_WCa: NDArray[np.float64] = _NOBODY  # (3,) [m]
    p_WCb: NDArray[np.float64] = _NOBODY
    closing_speed: float = math.nan  # [m/s] NaN: unknown
    limit_distance: float = math.nan  # [m]
    limit_time: float = 0.0  # [s] ``min_time_to_contact`` of the rule


class LastMeasured(NamedTuple):
    """Measurement of the last cycle that had one, and the nearest pair of each group in it."""

    measured: Measured
    nearest: NearestPairs


# The fields of an event about its pair, for a rule without a pair near enough.
_NO_PAIR = (0, 0, math.inf, 0.0, _NOBODY, _NOBODY, math.nan)
_Pair: TypeAlias = tuple[int, int, float, float, NDArray[np.float64], NDArray[np.float64], float]


def events_of_gone(first: int, rules: Sequence[ProximityRule]) -> list[Event]:
    """Return GONE events of removed rules, numbered from ``first``."""
    gone = enumerate(rules, first)
    return [Event(k, rule.name, rule.level, False, Why.GONE) for k, rule in gone]


def events_of(
    first: int,
    rules: Sequence[ProximityRule],
    changed: Ids,
    entered: Entered,
    watched: WatchedPairs,
    poses: Poses,
    seen: LastMeasured | None,
    stops: Mapping[str, Stop],
) -> list[Event]:
    """Return the events of the rules that ``changed`` (r,), numbered from ``first``."""
    is_entered, whys = entered.is_entered[changed], entered.why[changed]
    # A rule that is left reports its nearest pair, which may enter it again first.
    pairs = _pairs(seen, watched.groups[changed], is_entered & (whys == Why.SOON))
    rows = zip(changed.tolist(), is_entered.tolist(), map(Why, whys.tolist()), pairs, strict=True)
    events, without = [], dict(poses.without())
    for sequence, (number, enters, why, pair) in enumerate(rows, first):
        rule = rules[number]
        if enters and why in without and len(without[why]):
            flags = without[why]
            ids = watched.ids[watched.needed(number) & flags]
            pair = (int(ids[0]) if len(ids) else 0, 0, math.nan, *_NO_PAIR[3:])
        limit = rule.enter if enters else rule.leave
        if rule.level == Level.STOPPABLE:
            limit = rule.margin
            if not enters:
                pair = _NO_PAIR
            elif why == Why.CANNOT_STOP:
                pair = _pair_of(stops.get(rule.name))
        if rule.min_points > 1 and not enters:  # its nearest pair is no reason to be left
            pair = _NO_PAIR
        limits = limit, rule.min_time_to_contact
        events.append(Event(sequence, rule.name, rule.level, enters, why, *pair, *limits))
    return events


def _pair_of(stop: Stop | None) -> _Pair:
    """Return the pair that an answer could not prove; nothing is known without one."""
    if stop is None or not stop.id_A:
        return (0, 0, math.nan, *_NO_PAIR[3:])
    points = stop.p_WCa, stop.p_WCb
    return stop.id_A, stop.id_B, stop.distance, stop.error_bound, *points, math.nan


def _pairs(seen: LastMeasured | None, groups: Ids, soonest: Flags) -> Iterator[_Pair]:
    """Return the nearest pair of each group; the first to touch where ``soonest`` (g,)."""
    if seen is None:
        return iter([_NO_PAIR] * len(groups))
    measured, nearest = seen
    pairs = np.where(soonest, nearest.soonest_pair[groups], nearest.lowest_pair[groups])
    has_pair = pairs >= 0
    rows, speeds = pairs[has_pair], measured.closing_speed
    each = zip(
        measured.id_A[rows].tolist(),
        measured.id_B[rows].tolist(),
        measured.distance[rows].tolist(),
        measured.error_bound[rows].tolist(),
        measured.p_WCa[rows],
        measured.p_WCb[rows],
        [math.nan] * len(rows) if speeds is None else speeds[rows].tolist(),
        strict=True,
    )
    return (next(each) if has_one else _NO_PAIR for has_one in has_pair.tolist())
