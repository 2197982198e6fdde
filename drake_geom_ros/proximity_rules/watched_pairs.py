"""Pairs of a scene that each rule watches: built when the scene changes, read each cycle.

Rules with the same sets, such as a stop and a warning, form a group, and each group is a bit.
Each geometry has a row of bits for the groups with it in ``set_a``, and a row for ``set_b``; the
groups that watch a pair are ``A[a] & B[b] | A[b] & B[a]``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.geometry_names import GeometryNames, is_plain, matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.proximity_rules.measured import NOTHING, Measured
from drake_geom_ros.proximity_rules.nearest_pairs import (
    WORD,
    NearestPairs,
    SetBits,
    nearest_pairs,
)
from drake_geom_ros.proximity_rules.rule import ProximityRule

Ids = NDArray[np.int64]
_COLUMNS = 1024  # of a matrix of pairs that are counted at once: four bytes each
_MOST_LOOKED_AT = 5000  # names that are compared with an unknown one


class ScenePairs(NamedTuple):
    """Geometries and pairs of a scene that queries may report."""

    ids: Ids  # (n,), ascending
    names: Sequence[GeometryNames]  # (n,)
    reported: Flags  # (n, n), symmetric: pairs that may be reported

    def are(self, ids: Ids, reported: Flags) -> bool:
        """Return whether this object has these geometries and pairs."""
        return np.array_equal(ids, self.ids) and np.array_equal(reported, self.reported)


class WatchedPairs:
    """Pairs of one version of a scene that a set of rules watches."""

    def __init__(
        self, rules: Sequence[ProximityRule], scene: ScenePairs, met: Collection[str] = ()
    ) -> None:
        """Find the pairs of each rule; rules named in ``met`` may lack some of their names.

        ``trouble`` is for each rule the reason why it can never be entered, or empty. It is
        ``unknown`` if a name matches nothing (for rules in ``met``: if all names of a set do), or
        that no pair of the rule is ever reported. ``lacking`` are for each rule in ``met`` the
        names that match nothing, without which it goes on.
        """
        self.ids: Ids = np.array(scene.ids, dtype=np.int64)
        # Rules with the same sets differ if only one of them may lack a name.
        keys = [(rule.set_a, rule.set_b, rule.name in met) for rule in rules]
        numbers: dict[tuple[object, ...], int] = {}
        self.groups: Ids = np.array(
            [numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64
        )
        firsts = np.unique(self.groups, return_index=True)[1].tolist()
        finder = _Finder(scene)
        sets = [finder.sets_of(rules[n], may_lack=keys[n][2]) for n in firsts]
        shape = len(firsts), len(scene.ids)
        self._in_a = np.array([each.in_a for each in sets], dtype=np.bool_).reshape(shape)
        self._in_b = np.array([each.in_b for each in sets], dtype=np.bool_).reshape(shape)
        self._count(scene.reported)
        of_rules = [sets[group] for group in self.groups.tolist()]
        self.unknown = [
            finder.unknown(rule, each.unknown) if each.unknown else ''
            for rule, each in zip(rules, of_rules, strict=True)
        ]
        self.lacking = [each.lacking for each in of_rules]
        self.is_unknown: Flags = np.array([bool(each) for each in self.unknown], dtype=np.bool_)
        unwatched = [
            '' if refusal else _why_never(rule, int(pairs), int(left_out))
            for rule, refusal, pairs, left_out in zip(
                rules, self.unknown, self.pairs, self.left_out, strict=True
            )
        ]
        self.trouble = [a or b for a, b in zip(self.unknown, unwatched, strict=True)]
        self._bits = _bits(self.ids, self._in_a, self._in_b)
        if rules:
            self.nearest(NOTHING)  # compiles the search now instead of in a cycle

    def _count(self, reported: Flags) -> None:
        """Count pairs {i, j} with i in A and j in B: ordered pairs minus those counted twice."""
        in_a, in_b = self._in_a.astype(np.float32), self._in_b.astype(np.float32)
        both = in_a * in_b
        # Whole numbers to 2 ** 24 are exact here; their sums need not be so small.
        near_a, near_b, near_both = (np.empty_like(in_a) for _ in range(3))
        for first in range(0, len(reported), _COLUMNS):
            columns = slice(first, first + _COLUMNS)
            partners = reported[:, columns].astype(np.float32)
            near_a[:, columns], near_b[:, columns] = in_a @ partners, in_b @ partners
            near_both[:, columns] = both @ partners
        ordered = (near_a * in_b).sum(axis=1, dtype=np.float64)
        twice = (near_both * both).sum(axis=1, dtype=np.float64) / 2.0
        pairs = (ordered - twice).astype(np.int64)
        a, b, c = (self._in_a.sum(axis=1), self._in_b.sum(axis=1), both.sum(axis=1))
        every = a * b - c - c * (c - 1) / 2  # without a geometry and itself
        self.pairs: Ids = pairs[self.groups]  # (r,) that may be reported
        self.left_out: Ids = (every.astype(np.int64) - pairs)[self.groups]  # (r,) that never are
        # (g, n) geometries with a partner in the other set; the poses of others do not matter.
        self._needed: Flags = (self._in_a & (near_b > 0.0)) | (self._in_b & (near_a > 0.0))

    def needed(self, rule: int) -> Flags:
        """Return the geometries (n,) whose poses a rule needs."""
        return np.asarray(self._needed[self.groups[rule]])

    def needs(self, flags: Flags) -> Flags:
        """Return a mask (r,) of the rules that need the pose of a flagged geometry (n,)."""
        if not flags.any():  # as in most cycles
            return np.zeros(len(self.groups), dtype=np.bool_)
        needing: Flags = np.logical_or.reduce(self._needed[:, flags], axis=1)
        return np.asarray(needing[self.groups])

    def nearest(self, measured: Measured, farthest: float = math.inf) -> NearestPairs:
        """Return the nearest pairs of each rule (r,), within ``farthest`` [m]."""
        return self.nearest_of_groups(measured, farthest).of(self.groups)

    def nearest_of_groups(self, measured: Measured, farthest: float = math.inf) -> NearestPairs:
        """Return the nearest pairs of each group; ``groups`` (r,) maps rules to groups."""
        return nearest_pairs(measured, farthest, self._bits, len(self._in_a))

    def watched(self) -> Flags:
        """Return a symmetric mask (n, n) of the pairs that any rule watches."""
        one_way = np.matmul(self._in_a.T.astype(np.float32), self._in_b.astype(np.float32)) > 0.0
        return np.asarray(one_way | one_way.T)

    def greatest_shared(
        self, numbers: Sequence[int], others: Sequence[int], values: Floats
    ) -> Floats:
        """Return for each rule the greatest of the ``values`` (k,) of rules that share a pair.

        0 if no other rule shares a pair, or all values are less. Filters are ignored. Groups are
        compared instead of rules, so that the time does not grow with the square of their number.
        """
        groups, places = np.unique(self.groups[list(numbers)], return_inverse=True)
        other_groups, other_places = np.unique(self.groups[list(others)], return_inverse=True)
        greatest = np.full(len(other_groups), -math.inf)
        np.maximum.at(greatest, other_places, values)
        in_a, in_b = (sets[other_groups].astype(np.float32).T for sets in (self._in_a, self._in_b))
        shared = np.zeros(len(groups))
        for k, group in enumerate(groups.tolist()):  # row by row: a matrix of all may be large
            a, b = (sets[group].astype(np.float32) for sets in (self._in_a, self._in_b))
            shares = (a @ in_a > 0.0) & (b @ in_b > 0.0)
            shares |= (a @ in_b > 0.0) & (b @ in_a > 0.0)
            shared[k] = greatest[shares].max(initial=0.0)
        return np.asarray(shared[places])


def _bits(ids: Ids, in_a: Flags, in_b: Flags) -> SetBits:
    """Return the bits of the masks (g, n) of the groups' first and second sets."""
    words_a, words_b = _words(in_a.T), _words(in_b.T)
    rows, places = np.nonzero(words_a)
    begins = np.zeros(in_a.shape[1] + 1, dtype=np.int64)
    np.cumsum(np.bincount(rows, minlength=in_a.shape[1]), out=begins[1:])
    # ``places`` is copied, because a strided array would compile another version.
    return SetBits(ids, begins, np.array(places), words_a[rows, places], words_b)


def _words(flags: Flags) -> NDArray[np.uint64]:
    """Return flags (n, r) packed into rows of whole words."""
    bits = np.packbits(flags, axis=1, bitorder='little')
    filled = np.zeros((len(flags), -(-flags.shape[1] // WORD) * (WORD // 8)), dtype=np.uint8)
    filled[:, : bits.shape[1]] = bits
    return filled.view(np.uint64)


class _Sets(NamedTuple):
    """Masks (n,) of a rule's two sets, and the names that match nothing."""

    in_a: Flags
    in_b: Flags
    unknown: str = ''  # the first name that matches nothing, if the rule may not lack it
    lacking: tuple[str, ...] = ()


class _Finder:
    """Finds the geometries that patterns match, cached because rules repeat patterns."""

    def __init__(self, scene: ScenePairs) -> None:
        self._count = len(scene.names)
        self._rows: dict[str, list[int]] = {}  # by name; most have one or a few
        for row, names in enumerate(scene.names):
            for name in dict.fromkeys(names.found_by):
                self._rows.setdefault(name, []).append(row)
        self._masks: dict[str, Flags] = {}  # by pattern
        self._like: dict[str, str] = {}  # suggestions for patterns that match nothing

    def sets_of(self, rule: ProximityRule, *, may_lack: bool) -> _Sets:
        """Return the sets of a rule, both empty if a pattern matches nothing.

        A rule that ``may_lack`` patterns goes on with the others if neither set becomes empty.
        """
        in_a, in_b = self._members(rule.set_a), self._members(rule.set_b)
        patterns = (*rule.set_a, *rule.set_b)
        lacking = [pattern for pattern in patterns if not self._members([pattern]).any()]
        is_whole = bool(in_a.any()) and (not rule.set_b or bool(in_b.any()))
        if lacking and not (may_lack and is_whole):
            nothing = self._members([])
            return _Sets(nothing, nothing, lacking[0])
        return _Sets(in_a, in_b if rule.set_b else ~in_a, lacking=tuple(lacking))

    def _members(self, patterns: Sequence[str]) -> Flags:
        members = np.zeros(self._count, dtype=np.bool_)
        for pattern in patterns:
            if pattern not in self._masks:
                self._masks[pattern] = self._members_of(pattern)
            members |= self._masks[pattern]
        return members

    def _members_of(self, pattern: str) -> Flags:
        """Return a mask (n,) of the geometries that match a pattern."""
        members = np.zeros(self._count, dtype=np.bool_)
        if is_plain(pattern):
            members[self._rows.get(pattern, [])] = True
            return members
        for name, rows in self._rows.items():
            if matches([name], pattern):
                members[rows] = True
        return members

    def unknown(self, rule: ProximityRule, pattern: str) -> str:
        """Return the error text for a rule with a pattern that matches nothing."""
        if pattern not in self._like:
            self._like[pattern] = nearest(pattern, islice(self._rows, _MOST_LOOKED_AT))
        like = self._like[pattern]
        return (
            f'proximity rule {rule.name[:80]!r}: {pattern[:80]!r} stands for no geometry that '
            f'queries report{like}. The scene has {counted(self._count, "geometry")} with '
            'the proximity role; see ~/scene'
        )


def _why_never(rule: ProximityRule, pairs: int, left_out: int) -> str:
    """Return the error text for a rule that no pair can ever enter; empty if one can."""
    if pairs:
        return ''
    why = (
        f'of its {counted(left_out, "pair")} none is ever reported: all are filtered, of one '
        'frame, or of two anchored geometries; see explain_filter'
        if left_out
        else 'its two sets have no pair'
    )
    return f'proximity rule {rule.name[:80]!r} could never be entered: {why}'
