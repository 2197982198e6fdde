"""Pairs of a scene that each rule watches: built when the scene changes, read each cycle.

Rules with the same sets, such as a stop and a warning, form a group, and each group is a bit.
Each geometry has a row of bits for the groups with it in ``set_a``, and a row for ``set_b``; the
groups that watch a pair are ``A[a] & B[b] | A[b] & B[a]``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import CandidatePairs
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.proximity_rules.measured import NOTHING, Measured
from drake_geom_ros.proximity_rules.named_geometries import NamedGeometries
from drake_geom_ros.proximity_rules.nearest_pairs import (
    WORD,
    NearestPairs,
    SetBits,
    nearest_pairs,
)
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule

Ids = NDArray[np.int64]


@dataclass(frozen=True)
class ScenePairs:
    """Geometries and pairs of a scene that queries may report."""

    geometries: NamedGeometries  # (n,) by ascending ids
    reported: CandidatePairs  # pairs that may be reported

    @property
    def ids(self) -> Ids:
        """The id values (n,) of the geometries, ascending."""
        return self.reported.ids


class WatchedKinds(NamedTuple):
    """Watched pairs by kinds of geometries: those of one kind are in the same sets of rules.

    It takes memory for each geometry and for each pair of kinds, of which there are few.
    """

    kinds: Ids  # (n,) of the geometries
    watched: Flags  # (k, k), symmetric: pairs of these kinds are watched


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
        # Rules with the same sets differ if only one of them may lack a name or sees zones, and if
        # they count points.
        keys = [
            (
                *(rule.set_a, rule.set_b, rule.name in met),
                *(rule.level == Level.STOPPABLE, rule.min_points),
            )
            for rule in rules
        ]
        numbers: dict[tuple[object, ...], int] = {}
        self.groups: Ids = np.array(
            [numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64
        )
        firsts = np.unique(self.groups, return_index=True)[1].tolist()
        self.min_points: Ids = np.array([rules[n].min_points for n in firsts], dtype=np.int64)
        finder = scene.geometries
        self._is_zone = finder.is_zone
        sets = [finder.sets_of(rules[n], may_lack=keys[n][2]) for n in firsts]
        shape = len(firsts), len(scene.ids)
        self._in_a = np.array([each.in_a for each in sets], dtype=np.bool_).reshape(shape)
        self._in_b = np.array([each.in_b for each in sets], dtype=np.bool_).reshape(shape)
        self._count(scene.reported, finder.vital)
        of_rules = [sets[group] for group in self.groups.tolist()]
        self.unknown = [
            finder.unknown(rule, each.unknown) if each.unknown else ''
            for rule, each in zip(rules, of_rules, strict=True)
        ]
        self.lacking = [each.lacking for each in of_rules]
        self.is_unknown: Flags = np.array([bool(each) for each in self.unknown], dtype=np.bool_)
        has_vital = [bool((finder.vital & (s.in_a | s.in_b)).any()) for s in of_rules]
        unwatched = [
            '' if refusal or waits else _why_never(rule, int(pairs), int(left_out))
            for rule, refusal, waits, pairs, left_out in zip(
                rules, self.unknown, has_vital, self.pairs, self.left_out, strict=True
            )
        ]
        self.trouble = [a or b for a, b in zip(self.unknown, unwatched, strict=True)]
        self._bits = _bits(self.ids, self._in_a, self._in_b)
        if rules:
            self.nearest(NOTHING)  # compiles the search now instead of in a cycle

    def _count(self, reported: CandidatePairs, vital: Flags) -> None:
        """Count pairs {i, j} with i in A and j in B: ordered pairs minus those counted twice.

        The poses of ``vital`` geometries (n,) matter without a pair, too.
        """
        in_a, in_b = self._in_a, self._in_b
        both = in_a & in_b
        ofs = zip(in_a, in_b, both, strict=True)
        counts = [
            [reported.partners(*sets) for sets in ((a, b), (b, a), (c, c))] for a, b, c in ofs
        ]
        near = np.array(counts, dtype=np.int64).reshape(len(in_a), 3, len(self.ids))
        of_a, of_b, of_both = near[:, 0], near[:, 1], near[:, 2]
        pairs = of_a.sum(axis=1) - of_both.sum(axis=1) // 2
        a, b, c = (sets.sum(axis=1) for sets in (in_a, in_b, both))
        every = a * b - c - c * (c - 1) // 2  # without a geometry and itself
        self.pairs: Ids = pairs[self.groups]  # (r,) that may be reported
        self.left_out: Ids = (every - pairs)[self.groups]  # (r,) that never are
        # (g, n) geometries with a partner in the other set; the poses of others do not matter.
        self._needed: Flags = (of_a > 0) | (of_b > 0) | ((in_a | in_b) & vital)

    def needed(self, rule: int) -> Flags:
        """Return the geometries (n,) whose poses a rule needs."""
        return np.asarray(self._needed[self.groups[rule]])

    @cached_property
    def needed_zones(self) -> Flags:
        """The zones (n,) that any rule is about."""
        return np.asarray(self._needed.any(axis=0) & self._is_zone)

    def is_about_zones(self, rule: int) -> bool:
        """Return whether one of the sets of a rule is nothing but zones."""
        sets = self._in_a[self.groups[rule]], self._in_b[self.groups[rule]]
        return any(bool(each.any()) and not (each & ~self._is_zone).any() for each in sets)

    def sets_of(self, rule: int) -> tuple[Ids, Ids]:
        """Return the id values of the geometries in the two sets of a rule."""
        group = self.groups[rule]
        return self.ids[self._in_a[group]], self.ids[self._in_b[group]]

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
        nearest = nearest_pairs(measured, farthest, self._bits, len(self._in_a))
        for count, distance in measured.counted.items():
            counting = self.min_points == count
            as_counted = measured._replace(distance=distance)
            counted = nearest_pairs(as_counted, farthest, self._bits, len(self._in_a))
            for column, other in zip(nearest, counted, strict=True):
                column[counting] = other[counting]
        return nearest

    def groups_with(self, rows: Ids) -> Ids:
        """Return the groups with any of some geometries, by row, in a set."""
        return np.flatnonzero((self._in_a[:, rows] | self._in_b[:, rows]).any(axis=1))

    def watches(self, group: int, rows: Ids, others: Ids) -> Flags:
        """Return which pairs (m, n) of geometries, by row, a group watches; filters count not."""
        in_a, in_b = self._in_a[group], self._in_b[group]
        one_way = in_a[rows][:, np.newaxis] & in_b[others]
        return np.asarray(one_way | (in_b[rows][:, np.newaxis] & in_a[others]))

    def watched(self) -> WatchedKinds:
        """Return the pairs that any rule watches; filters are ignored."""
        nothing = np.zeros((1, len(self.ids)), dtype=np.bool_)  # for scenes without rules
        sets = np.packbits(np.concatenate((self._in_a, self._in_b, nothing)), axis=0).T
        # As bytes: NumPy compares rows of numbers one by one, in the interpreter's lock.
        rows = np.ascontiguousarray(sets).view(np.dtype((np.void, sets.shape[1])))
        _, firsts, kinds = np.unique(rows.ravel(), return_index=True, return_inverse=True)
        in_a, in_b = (each[:, firsts].astype(np.float32) for each in (self._in_a, self._in_b))
        one_way = in_a.T @ in_b > 0.0
        return WatchedKinds(kinds.ravel(), one_way | one_way.T)

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
