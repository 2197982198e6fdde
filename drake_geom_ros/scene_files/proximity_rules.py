"""Proximity rules of scene files: plain values to rules and back."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError
from drake_geom_ros.scene_files.yaml_text import Document

_NUMBERS = ('hold', 'enter_after', 'min_time_to_contact')


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
    return ProximityRule(
        plain['name'],
        _patterns(plain['set_a']),
        _patterns(plain.get('set_b', ())),
        Level[plain['level'].upper()],
        float(plain['enter']),
        float(plain['leave']),
        **{name: float(plain.get(name, 0.0)) for name in _NUMBERS},
        when_stale=plain.get('when_stale', ''),
        scale=tuple((float(d), float(s)) for d, s in plain.get('scale', ())),
        acknowledge=plain.get('acknowledge', False),
    )


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
    }
    return {
        'name': rule.name,
        'set_a': list(rule.set_a),
        'level': rule.level.name.lower(),
        'enter': rule.enter,
        'leave': rule.leave,
        **{key: value for key, value in optional.items() if value},
    }
