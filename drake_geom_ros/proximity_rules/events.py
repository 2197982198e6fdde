"""What changes of rules, as events."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules.decisions import Entered, Poses
from drake_geom_ros.proximity_rules.measured import Measured
from drake_geom_ros.proximity_rules.nearest_pairs import NearestPairs
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, Why
from drake_geom_ros.proximity_rules.watched_pairs import WatchedPairs

Flags = NDArray[np.bool_]
Ids = NDArray[np.int64]
_NOBODY = np.full(3, math.nan)


class Event(NamedTuple):
    """One change of one rule.

    The pair is the nearest of the rule's, for SOON the one that would touch first; ids of 0, a
    distance of inf and points of NaN: none was near enough to be looked at. For STALE, NO_POSE,
    TWO_SENDERS and OTHER_CLOCK ``id_A`` is a geometry without a good pose, and nothing is known of
    a distance (NaN).

    What the lower bound was held against is ``limit_distance``: ``enter`` of the rule, and
    ``leave`` where it is left.
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
    closing_speed: float = math.nan  # [m/s] NaN: not known
    limit_distance: float = math.nan  # [m]
    limit_time: float = 0.0  # [s] ``min_time_to_contact`` of the rule


class Seen(NamedTuple):
    """What the last cycle that measured saw, and the nearest pairs of each group in it."""

    measured: Measured
    nearest: NearestPairs


# The fields of an event that tell its pair, of a rule with no pair near enough.
_NO_PAIR = (0, 0, math.inf, 0.0, _NOBODY, _NOBODY, math.nan)
_Pair: TypeAlias = tuple[int, int, float, float, NDArray[np.float64], NDArray[np.float64], float]


def events_of_gone(first: int, rules: Sequence[ProximityRule]) -> list[Event]:
    """Return the events, numbered from ``first`` on, of rules that are no more."""
    gone = enumerate(rules, first)
    return [Event(k, rule.name, rule.level, False, Why.GONE) for k, rule in gone]


def events_of(
    first: int,
    rules: Sequence[ProximityRule],
    changed: Ids,
    entered: Entered,
    watched: WatchedPairs,
    poses: Poses,
    seen: Seen | None,
) -> list[Event]:
    """Return the events, numbered from ``first`` on, of the rules (r,) that ``changed``."""
    is_entered, whys = entered.is_entered[changed], entered.why[changed]
    # Of what is left, the pair that it is nearest to be entered for again.
    pairs = _pairs(seen, watched.groups[changed], is_entered & (whys == Why.SOON))
    told = zip(changed.tolist(), is_entered.tolist(), map(Why, whys.tolist()), pairs, strict=True)
    events, without = [], dict(poses.without())
    for sequence, (number, enters, why, pair) in enumerate(told, first):
        rule = rules[number]
        if enters and why in without and len(without[why]):
            flags = without[why]
            ids = watched.ids[watched.needed(number) & flags]
            pair = (int(ids[0]) if len(ids) else 0, 0, math.nan, *_NO_PAIR[3:])
        limit = rule.enter if enters else rule.leave
        limits = limit, rule.min_time_to_contact
        events.append(Event(sequence, rule.name, rule.level, enters, why, *pair, *limits))
    return events


def _pairs(seen: Seen | None, groups: Ids, soonest: Flags) -> Iterator[_Pair]:
    """Return the nearest pair of each of some groups, or the one that would touch first."""
    if seen is None:
        return iter([_NO_PAIR] * len(groups))
    measured, nearest = seen
    found = np.where(soonest, nearest.soonest_pair[groups], nearest.lowest_pair[groups])
    there = found >= 0
    rows, speeds = found[there], measured.closing_speed
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
    return (next(each) if is_there else _NO_PAIR for is_there in there.tolist())
