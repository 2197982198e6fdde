"""Filter log: all statements about pairs in order, the source of the matrix and of reasons.

The persistent part holds group relations, cliques and declarations in one sequence; the transient
part holds the statements of each filter id. For every pair the last statement counts: persistent
ones first to last, then transient ones first to last.

A statement repeated about the same sets replaces the former one, which has no effect any more. So
a program that excludes and allows the same sets for days does not grow the log, and the log still
leads to the same matrix.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from enum import Enum
from typing import NamedTuple


class FilterOperation(str, Enum):
    """Operation of a filter statement; values are the methods of CollisionFilterDeclaration."""

    EXCLUDE_WITHIN = 'ExcludeWithin'
    EXCLUDE_BETWEEN = 'ExcludeBetween'
    ALLOW_WITHIN = 'AllowWithin'
    ALLOW_BETWEEN = 'AllowBetween'

    @classmethod
    def of(cls, *, excludes: bool, takes_two_sets: bool) -> FilterOperation:
        """Return the operation that excludes or allows pairs of one set or of two."""
        if takes_two_sets:
            return cls.EXCLUDE_BETWEEN if excludes else cls.ALLOW_BETWEEN
        return cls.EXCLUDE_WITHIN if excludes else cls.ALLOW_WITHIN

    @property
    def excludes(self) -> bool:
        """True if the pairs are taken out of the candidates, False if they are put into them."""
        return self in (FilterOperation.EXCLUDE_WITHIN, FilterOperation.EXCLUDE_BETWEEN)

    @property
    def takes_two_sets(self) -> bool:
        """True if the pairs are those between two sets."""
        return self in (FilterOperation.EXCLUDE_BETWEEN, FilterOperation.ALLOW_BETWEEN)


Keys = tuple[int, ...]
Statement = tuple[FilterOperation, Keys, Keys]  # set A, set B (not read by WITHIN)

_GROUP = 'group'
_CLIQUE = 'clique'
_PERSISTENT = 'persistent declaration'
_TRANSIENT = 'transient declaration'

# Elements that leave are removed from the log together, at the latest when there are this many.
_MOST_FORGOTTEN = 256


class Origin(NamedTuple):
    """Origin of an entry: the number of a declaration, or the name of a group or clique."""

    kind: str
    name: int | str
    ignored: str = ''  # the group that a group ignores


class Entry(NamedTuple):
    """One statement about all pairs between two sets; *within* a set is between it and itself."""

    excludes: bool
    keys_a: Keys
    keys_b: Keys | None  # None: every element, also those that come later
    origin: Origin

    def label(self) -> str:
        """Return the label of the entry in ``reasons``."""
        return f'{self.origin.kind} {self.origin.name}'

    def is_declared(self) -> bool:
        """Return whether this is a statement of a declaration, not of a group or a clique."""
        return self.origin.kind not in (_GROUP, _CLIQUE)

    def place(self) -> tuple[object, ...]:
        """Return the key of the entry: an entry replaces an older one with the same key."""
        keys_a, keys_b = self.keys_a, self.keys_b
        if keys_b is None or not self.is_declared():
            return self.origin
        return (keys_a, keys_b) if keys_a <= keys_b else (keys_b, keys_a)

    def covers(self, key_a: int, key_b: int) -> bool:
        """Return whether the entry is about this pair."""
        if self.keys_b is None:
            return key_a in self.keys_a or key_b in self.keys_a
        return (key_a in self.keys_a and key_b in self.keys_b) or (
            key_b in self.keys_a and key_a in self.keys_b
        )

    def without(self, gone: set[int]) -> Entry | None:
        """Return the entry without some elements, None when no pair is left."""
        keys_a = _without(self.keys_a, gone)
        keys_b = None if self.keys_b is None else _without(self.keys_b, gone)
        if not keys_a or keys_b == ():
            return None
        return self._replace(keys_a=keys_a, keys_b=keys_b)

    def statement(self, everything: Keys) -> Statement:
        """Return the entry as it would be declared, ``everything`` standing for every element."""
        keys_b = everything if self.keys_b is None else self.keys_b
        is_within = self.keys_a == keys_b
        operation = FilterOperation.of(excludes=self.excludes, takes_two_sets=not is_within)
        return operation, self.keys_a, () if is_within else keys_b


class _Mentions:
    """The transient declarations about each element, so that a removal need not look at all."""

    def __init__(self) -> None:
        self._noted = 0
        self._places: dict[int, dict[int, int]] = {}  # in the history, by element and declaration

    def note(self, filter_id: int, made: Iterable[Entry]) -> None:
        """Note a declaration that comes after all others."""
        for key in _keys_of(made):
            self._places.setdefault(key, {})[filter_id] = self._noted
        self._noted += 1

    def forget(self, filter_id: int, made: Iterable[Entry]) -> None:
        """Forget a declaration that goes."""
        for key in _keys_of(made):
            del self._places[key][filter_id]

    def of(self, entries: Iterable[Entry]) -> list[int]:
        """Return the declarations about any element of some entries, first to last."""
        places: dict[int, int] = {}
        for key in _keys_of(entries):
            places.update(self._places.get(key, {}))
        return sorted(places, key=places.__getitem__)


class FilterLog:
    """The entries in force, persistent and transient; elements are plain int keys."""

    def __init__(self) -> None:
        self._persistent: dict[tuple[object, ...], Entry] = {}
        self._transient: dict[int, list[Entry]] = {}
        # None until a declaration is removed: most logs are copies of which none is.
        self._about: _Mentions | None = None
        self._declared = 0
        self._forgotten: set[int] = set()

    def copy(self) -> FilterLog:
        """Return an independent copy of the log."""
        other = FilterLog()
        other._persistent = dict(self._persistent)
        other._transient = dict(self._transient)
        other._declared = self._declared
        other._forgotten = set(self._forgotten)
        return other

    def declare(self, statements: Iterable[Statement]) -> list[Entry]:
        """Append a persistent declaration and return its entries."""
        made = _entries(statements, Origin(_PERSISTENT, self._declared))
        self._declared += 1
        for entry in made:
            self.relate(entry)
        return made

    def relate(self, entry: Entry) -> None:
        """Append one persistent entry, replacing an older one with the same key."""
        place = entry.place()
        self._persistent.pop(place, None)
        self._persistent[place] = entry

    def push(self, filter_id: int, statements: Iterable[Statement]) -> list[Entry]:
        """Append a transient declaration and return its entries."""
        made = _entries(statements, Origin(_TRANSIENT, filter_id))
        self._transient[filter_id] = made
        if self._about is not None:
            self._about.note(filter_id, made)
        return made

    def pull(self, filter_id: int) -> list[Entry]:
        """Remove an active transient declaration and return its entries."""
        self._settle()
        made = self._transient.pop(filter_id)
        if self._about is not None:
            self._about.forget(filter_id, made)
        return made

    def active_ids(self) -> list[int]:
        """Return the ids of the transient declarations, first to last."""
        return list(self._transient)

    def is_active(self, filter_id: int) -> bool:
        """Return whether a transient declaration is in the history."""
        return filter_id in self._transient

    def has_history(self) -> bool:
        """Return whether there are transient declarations."""
        return bool(self._transient)

    def history(self) -> list[Entry]:
        """Return the transient entries, first to last."""
        self._settle()
        return [entry for made in self._transient.values() for entry in made]

    def history_about(self, entries: Collection[Entry]) -> list[Entry]:
        """Return the transient declarations about any element of some entries, first to last."""
        if any(entry.keys_b is None for entry in entries):
            return self.history()
        self._settle()
        if self._about is None:
            self._about = _Mentions()
            for filter_id, made in self._transient.items():
                self._about.note(filter_id, made)
        about = self._about.of(entries)
        return [entry for filter_id in about for entry in self._transient[filter_id]]

    def flatten(self) -> None:
        """Turn the transient declarations into persistent ones."""
        history = list(self._transient.values())
        self._transient.clear()
        self._about = None
        for made in history:
            for entry in made:
                self.relate(entry._replace(origin=Origin(_PERSISTENT, self._declared)))
            self._declared += 1

    def register(self, key: int) -> None:
        """Ensure that no former statement applies to a new element with this key."""
        if key in self._forgotten:
            self._settle()

    def forget(self, key: int) -> None:
        """Remove an element from all statements, now or later together with others."""
        self._forgotten.add(key)
        if len(self._forgotten) >= _MOST_FORGOTTEN:
            self._settle()

    def reasons(self, key_a: int, key_b: int) -> list[str]:
        """Return the labels of what excludes a pair since it was last allowed, newest first."""
        labels = []
        for entry in (*reversed(self.history()), *reversed(self._persistent.values())):
            if entry.covers(key_a, key_b):
                if not entry.excludes:
                    break
                labels.append(entry.label())
        return list(dict.fromkeys(labels))

    def cliques(self) -> dict[str, Keys]:
        """Return the members of each clique by its name."""
        self._settle()
        return {
            str(entry.origin.name): entry.keys_a
            for entry in self._persistent.values()
            if entry.origin.kind == _CLIQUE
        }

    def clique_members(self, name: str) -> Keys:
        """Return the members of one clique, none if there is no such clique."""
        self._settle()
        entry = self._persistent.get(Origin(_CLIQUE, name))
        return entry.keys_a if entry else ()

    def declarations(self, everything: Keys) -> list[list[Statement]]:
        """Return declarations that restore the same filters once groups and cliques are defined.

        Declarations are returned as they were made. Statements of groups or cliques made after the
        first declaration are included in their order, because the last statement counts.
        """
        self._settle()
        made: list[list[Statement]] = []
        origin = None
        for entry in self._persistent.values():
            if made or entry.is_declared():
                if entry.origin != origin:
                    made.append([])
                    origin = entry.origin
                made[-1].append(entry.statement(everything))
        return made

    def _settle(self) -> None:
        """Remove the elements that left from all entries."""
        if not self._forgotten:
            return
        gone, self._forgotten = self._forgotten, set()
        former = self._persistent.values()
        self._persistent = {}
        for entry in former:
            if rest := entry.without(gone):
                self.relate(rest)
        self._about = None
        self._transient = {
            filter_id: [rest for entry in made if (rest := entry.without(gone))]
            for filter_id, made in self._transient.items()
        }


def clique(name: str, members: Keys) -> Entry:
    """Return the entry of a clique: no two of its members are reported."""
    return Entry(True, members, members, Origin(_CLIQUE, name))


def group_relation(name: str, members: Keys, ignored: str, its_members: Keys | None) -> Entry:
    """Return the entry of one group that ignores another; None stands for every element."""
    return Entry(True, members, its_members, Origin(_GROUP, name, ignored))


def _entries(statements: Iterable[Statement], origin: Origin) -> list[Entry]:
    """Return the entries of some statements; a statement about no pairs makes none."""
    made = []
    for operation, keys_a, keys_b in statements:
        if not operation.takes_two_sets:
            keys_b = keys_a
        if keys_a and keys_b:
            made.append(Entry(operation.excludes, keys_a, keys_b, origin))
    return made


def _keys_of(entries: Iterable[Entry]) -> set[int]:
    """Return the elements that entries mention by their keys."""
    return {
        key for entry in entries for keys in (entry.keys_a, entry.keys_b or ()) for key in keys
    }


def _without(keys: Keys, gone: set[int]) -> Keys:
    return keys if gone.isdisjoint(keys) else tuple(key for key in keys if key not in gone)
