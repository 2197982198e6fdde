"""Proximity rules, events and states to messages and back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any, cast

import numpy as np

from drake_geom_ros.geometry import QueryObject
from drake_geom_ros.live.conversions.fields import floats, uint8s, uint32s, unsigned
from drake_geom_ros.live.conversions.message_types import RuleMessage
from drake_geom_ros.math.batched import poses_from_matrices
from drake_geom_ros.proximity_rules import (
    Event,
    Level,
    ProximityRule,
    RuleError,
    RuleStates,
    Why,
    scale_points,
    stopping_points,
)

_NUMBERS = (
    *('enter', 'leave', 'hold', 'enter_after', 'min_time_to_contact'),
    *('reaction_time', 'margin', 'max_speed'),
)
# Lists of each rule, and in the flat message the field with their counts.
_COUNTS = {
    'set_a': 'set_a_count',
    'set_b': 'set_b_count',
    'scale': 'scale_count',
    'joint_names': 'joint_count',
    'decelerations': 'deceleration_count',
    'stopping_times': 'stopping_time_count',
}
_PAIRS = ('scale', 'stopping_times')  # lists of points


def rule_from_message(message: RuleMessage) -> ProximityRule:
    """Return the rule of a ProximityRule message; raises RuleError for what cannot be."""
    try:
        scale, times = scale_points(message.scale), stopping_points(message.stopping_times)
    except RuleError as error:
        raise RuleError(f'proximity rule {message.name[:80]!r}: {error}') from None
    numbers: dict[str, Any] = {name: float(getattr(message, name)) for name in _NUMBERS}
    return ProximityRule(
        message.name,
        tuple(message.set_a),
        tuple(message.set_b),
        cast(Level, message.level),  # which ProximityRule checks
        **numbers,
        when_stale=message.when_stale,
        scale=scale,
        acknowledge=bool(message.acknowledge),
        min_points=message.min_points or 1,
        joint_names=tuple(message.joint_names),
        decelerations=tuple(map(float, message.decelerations)),
        stopping_times=times,
        stop_category=message.stop_category,
    )


def rules_from_message(message: Any) -> list[ProximityRule]:
    """Return the rules of a ProximityRules message; raises RuleError for what cannot be."""
    flat = {field: getattr(message, field) for field in _COUNTS}
    flat['scale'] = scale_points(message.scale)
    flat['stopping_times'] = stopping_points(message.stopping_times)
    flat['decelerations'] = list(map(float, message.decelerations))
    lists = {field: _parts(message, field, values) for field, values in flat.items()}
    return [_rule_of(message, k, lists) for k in range(len(message.name))]


def _rule_of(message: Any, k: int, lists: Mapping[str, list[tuple[Any, ...]]]) -> ProximityRule:
    """Return rule k of a ProximityRules message, with its parts of the flat ``lists``."""
    fields: dict[str, Any] = {name: float(getattr(message, name)[k]) for name in _NUMBERS}
    fields |= {field: parts[k] for field, parts in lists.items()}
    return ProximityRule(
        name=message.name[k],
        level=message.level[k],
        **fields,
        when_stale=message.when_stale[k],
        acknowledge=bool(message.acknowledge[k]),
        min_points=int(message.min_points[k]) or 1,
        stop_category=message.stop_category[k],
    )


def _parts(message: Any, field: str, values: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Return the part of a flat field that is each rule's; raises RuleError for false counts."""
    counts = np.array(getattr(message, _COUNTS[field]), dtype=np.int64)
    ends = np.cumsum(counts).tolist()
    if len(counts) != len(message.name) or counts.sum() != len(values):
        raise RuleError(
            f'{len(message.name)} rules have {len(values)} {field}, and {_COUNTS[field]} is '
            f'{counts.tolist()[:20]}'
        )
    begins = [0, *ends]
    return [tuple(values[begin:end]) for begin, end in zip(begins, ends, strict=False)]


def fill_rules(message: Any, rules: Sequence[ProximityRule]) -> None:
    """Fill a ProximityRules message."""
    message.name = [rule.name for rule in rules]
    message.level = uint8s(np.array([rule.level for rule in rules]))
    message.stop_category = uint8s(np.array([rule.stop_category for rule in rules]))
    message.when_stale = [rule.when_stale for rule in rules]
    message.acknowledge = [rule.acknowledge for rule in rules]
    message.min_points = uint32s(np.array([rule.min_points for rule in rules]))
    for field in _NUMBERS:
        setattr(message, field, floats(np.array([getattr(rule, field) for rule in rules])))
    for field, counts in _COUNTS.items():
        lists = [getattr(rule, field) for rule in rules]
        setattr(message, counts, uint32s(np.array([len(each) for each in lists])))
        every = list(chain.from_iterable(lists))
        if field in _PAIRS:
            setattr(message, field, floats(np.array(every, dtype=np.float64).ravel()))
        else:
            setattr(message, field, every)


def fill_events(message: Any, events: Sequence[Event], names: Callable[[int], str]) -> None:
    """Fill the arrays of a ProximityEvents message; ``names`` maps ids of geometries to names."""

    def column(field: str) -> list[Any]:
        return [getattr(event, field) for event in events]

    message.sequence, message.rule = column('sequence'), column('rule')
    message.entered = column('is_entered')
    message.level, message.why = uint8s(np.array(column('level'))), uint8s(np.array(column('why')))
    for end, id in (('a', 'id_A'), ('b', 'id_B')):
        values = column(id)
        setattr(message, f'id_{end}', unsigned(np.array(values)))
        setattr(message, f'geometry_{end}', [names(value) for value in values])
    message.distance = floats(np.array(column('distance')))
    message.error_bound = floats(np.array(column('error_bound')))
    message.p_wca = floats(np.array(column('p_WCa')))
    message.p_wcb = floats(np.array(column('p_WCb')))


def fill_what_decided(
    message: Any, events: Sequence[Event], query: QueryObject, stale_after: float
) -> None:
    """Fill in the inputs of the decisions, so that each can be computed again.

    ``query`` has the poses that were decided by, ``stale_after`` is the age [s] of a stale pose.
    """
    ids = np.array([(event.id_A, event.id_B) for event in events], dtype=np.int64)
    poses = np.full((len(ids), 2, 7), math.nan)
    of_pairs = ids[:, 1] > 0
    if of_pairs.any():
        Rs, ps = query.X_WGs(ids[of_pairs].ravel())
        poses[of_pairs] = poses_from_matrices(Rs, ps).reshape(-1, 2, 7)
    message.pose_a, message.pose_b = floats(poses[:, 0].ravel()), floats(poses[:, 1].ravel())
    for field in ('closing_speed', 'limit_distance'):
        setattr(message, field, floats(np.array([getattr(event, field) for event in events])))
    stale = [event.is_entered and event.why == Why.STALE for event in events]
    times = np.array([event.limit_time for event in events])
    message.limit_time = floats(np.where(stale, stale_after, times))


def fill_states(message: Any, states: RuleStates) -> None:
    """Fill the arrays of a ProximityStates message, but for the rules and ``since``."""
    message.entered, message.why = states.is_entered.tolist(), uint8s(states.why)
    message.pairs, message.left_out_pairs = unsigned(states.pairs), unsigned(states.left_out)
    message.trouble = states.trouble
    message.awaits_acknowledgement = states.awaits_acknowledgement.tolist()
    message.entered_sequence = unsigned(states.entered_sequence)
