"""moveit_msgs/AllowedCollisionMatrix to the pairs of names that may collide, by duck type."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.names import shortened


@dataclass(frozen=True)
class AllowedCollisions:
    """Pairs of links and objects that may collide, by names, in MoveIt's order of precedence.

    A default of one of the two names counts before the entry of the pair; of two defaults both
    must allow it. A pair of which neither says anything is checked.
    """

    entries: frozenset[frozenset[str]] = frozenset()  # pairs that may collide
    defaults: Mapping[str, bool] = field(default_factory=dict, hash=False)
    entry_names: tuple[str, ...] = ()

    def allows(self, name_a: str, name_b: str) -> bool:
        """Return whether a pair may collide."""
        defaults = [self.defaults[name] for name in (name_a, name_b) if name in self.defaults]
        return all(defaults) if defaults else frozenset([name_a, name_b]) in self.entries

    def without(self, name: str) -> AllowedCollisions:
        """Return the matrix without the entries of a name, whose default stays, as in MoveIt."""
        entries = frozenset(pair for pair in self.entries if name not in pair)
        names = tuple(each for each in self.entry_names if each != name)
        return AllowedCollisions(entries, self.defaults, names)

    def names(self) -> list[str]:
        """Return all names of the matrix."""
        return list(dict.fromkeys([*self.entry_names, *self.defaults]))

    def partners(self, names: Iterable[str]) -> dict[str, list[str]]:
        """Return, of the pairs of some names that may collide, the later names by the earlier."""
        partners: dict[str, list[str]] = {}
        for name_a, name_b in combinations(dict.fromkeys(names), 2):
            if self.allows(name_a, name_b):
                partners.setdefault(name_a, []).append(name_b)
        return partners


def allowed_from_message(message: Any) -> tuple[AllowedCollisions, list[str]]:
    """Return the matrix of an AllowedCollisionMatrix, and notes on what was read otherwise.

    Raises ArgumentError where names and values do not match.
    """
    names, rows = list(message.entry_names), [list(row.enabled) for row in message.entry_values]
    _check_size('entry', names, rows)
    defaults = list(message.default_entry_names)
    _check_size('default_entry', defaults, list(message.default_entry_values))
    for name, row in zip(names, rows, strict=True):
        if len(row) != len(names):
            raise ArgumentError(
                f'allowed_collision_matrix: the row of {shortened(name)!r} holds {len(row)} '
                f'values for {len(names)} names'
            )
    pairs = list(combinations(range(len(names)), 2))
    uneven = [(j, k) for j, k in pairs if rows[j][k] != rows[k][j]]
    notes = [
        f'allowed_collision_matrix: {shortened(names[j])!r} and {shortened(names[k])!r} are '
        'allowed in one of their two entries only; the upper one counts, as for MoveIt'
        for j, k in uneven[:1]
    ]
    entries = frozenset(frozenset([names[j], names[k]]) for j, k in pairs if rows[j][k])
    values = dict(zip(defaults, map(bool, message.default_entry_values), strict=True))
    return AllowedCollisions(entries, values, tuple(names)), notes


def _check_size(kind: str, names: list[str], values: list[Any]) -> None:
    if len(names) != len(values):
        raise ArgumentError(
            f'allowed_collision_matrix: {kind}_values holds {len(values)} values for '
            f'{len(names)} {kind}_names'
        )
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ArgumentError(
            f'allowed_collision_matrix: {kind}_names holds {shortened(twice)!r} twice'
        )
