"""Proximity rules of scene files: plain values to rules and back."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError
from drake_geom_ros.scene_files.yaml_text import Document

_NUMBERS = (
    *('enter', 'leave', 'hold', 'enter_after', 'min_time_to_contact'),
    *('reaction_time', 'margin', 'max_speed'),
)
_DISTANCES = ('enter', 'leave')


def read_proximity_rules(document: Document) -> tuple[ProximityRule, ...]:
    """Return the rules of a document; raises SceneFileError for an invalid one."""
    rules: dict[str, ProximityRule] = {}
    for index, plain in enumerate(document.value.get('proximity_rules', ())):
        where = document.at('proximity_rules', index)
        if plain['name'] in rules:
            raise where.error(f'proximity rule {plain["name"]!r} is there twice')
        try:
            rules[plain['name']] = _rule(plain)
        except RuleError as error:
            raise where.error(str(error)) from error
    return tuple(rules.values())


def _rule(plain: Any) -> ProximityRule:
    level = Level[plain['level'].upper()]
    if level != Level.STOPPABLE and (missing := [k for k in _DISTANCES if k not in plain]):
        raise RuleError(
            f'proximity rule {plain["name"][:80]!r}: {" and ".join(missing)} [m] must be given; '
            'only the level stoppable does without'
        )
    numbers: dict[str, Any] = {name: float(plain.get(name, 0.0)) for name in _NUMBERS}
    return ProximityRule(
        plain['name'],
        _patterns(plain['set_a']),
        _patterns(plain.get('set_b', ())),
        level,
        **numbers,
        when_stale=plain.get('when_stale', ''),
        scale=_points(plain.get('scale', ())),
        acknowledge=plain.get('acknowledge', False),
        min_points=plain.get('min_points', 1),
        **_decelerations(plain),
        stopping_times=_points(plain.get('stopping_times', ())),
        stop_category=plain.get('stop_category', 1),
    )


def _decelerations(plain: Any) -> dict[str, Any]:
    """Return ``joint_names`` and ``decelerations``, which may be a number or by joint."""
    names, values = tuple(plain.get('joint_names', ())), plain.get('decelerations', ())
    if isinstance(values, dict):
        if names:
            raise RuleError(
                f'proximity rule {plain["name"][:80]!r}: decelerations by joint name the joints; '
                'leave out joint_names'
            )
        return {
            'joint_names': tuple(values),
            'decelerations': tuple(map(float, values.values())),
        }
    each = values if isinstance(values, (list, tuple)) else (values,)
    return {'joint_names': names, 'decelerations': tuple(map(float, each))}


def _points(plain: Any) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in plain)


def _patterns(plain: Any) -> tuple[str, ...]:
    """Return names or patterns as a tuple; a single one may come without a list."""
    return (plain,) if isinstance(plain, str) else tuple(plain)


def plain_proximity_rule(rule: ProximityRule) -> dict[str, Any]:
    """Return the plain form of a rule, without defaults."""
    optional = {
        'set_b': list(rule.set_b),
        **{name: getattr(rule, name) for name in _NUMBERS},
        'when_stale': rule.when_stale,
        'scale': [list(point) for point in rule.scale],
        'acknowledge': rule.acknowledge,
        'min_points': rule.min_points if rule.min_points > 1 else None,
        **_plain_braking(rule),
    }
    needed: dict[str, Any] = (
        {} if rule.level == Level.STOPPABLE else {k: getattr(rule, k) for k in _DISTANCES}
    )
    if rule.level == Level.STOPPABLE and rule.stop_category == 0:
        needed['stop_category'] = 0  # 1 without it
    return {
        'name': rule.name,
        'set_a': list(rule.set_a),
        'level': rule.level.name.lower(),
        **needed,
        **{key: value for key, value in optional.items() if value and key not in needed},
    }


def _plain_braking(rule: ProximityRule) -> dict[str, Any]:
    if len(rule.decelerations) == len(rule.joint_names):
        by_joint = zip(rule.joint_names, rule.decelerations, strict=True)
        decelerations: dict[str, Any] = {'decelerations': dict(by_joint)}
    else:
        values = list(rule.decelerations)
        decelerations = {'joint_names': list(rule.joint_names), 'decelerations': values}
        if len(values) == 1:
            decelerations['decelerations'] = values[0]
    return {**decelerations, 'stopping_times': [list(point) for point in rule.stopping_times]}
