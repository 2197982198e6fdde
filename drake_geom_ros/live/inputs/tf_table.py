"""The newest transform of each TF frame: names in dictionaries, numbers in columns.

A message of thousands of transforms, of a sender whose names are known, is then a few operations
on arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from drake_geom_ros.live.conversions.transforms import TransformNames, Transforms
from drake_geom_ros.live.inputs.tf_edges import matrices_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Arrival, Since
from drake_geom_ros.math.array_types import Flags, Floats, Indices

_FIRST_SLOTS = 16
_MOST_LISTS = 256  # lists of names of which it is kept where their transforms stand
EPOCH, HEARD, HELD, OFFSET = range(4)  # the columns of moments (n, 4), as ``Since``


class Edge(NamedTuple):
    """The newest transform of a TF frame C in its parent P."""

    parent: str
    X_PC: Floats  # (4, 4)
    stamp: float  # [s] of the message; inf for a static one
    since: Since

    @property
    def R_PC(self) -> Floats:
        """The rotation (3, 3)."""
        return self.X_PC[:3, :3]

    @property
    def p_PC(self) -> Floats:
        """The translation (3,) [m]."""
        return self.X_PC[:3, 3]


class HeardTransforms(NamedTuple):
    """A message, and when the poses in it hold."""

    transforms: Transforms
    stamps: Floats  # (n,) [s]; inf for static ones
    since: Floats  # (n, 4) moments


class _Places(NamedTuple):
    """The slots of the transforms of a list of names, in one version of the tree."""

    version: int
    slots: Indices  # (n,) -1: there is none of the child yet
    have_other_parents: Flags  # (n,) or none


class EdgeTable:
    """Keeps transforms by the name of the child."""

    def __init__(self) -> None:
        self.parents: dict[str, str] = {}
        self._slots: dict[str, int] = {}
        self._version = 0  # of the tree
        self._rows = np.zeros((_FIRST_SLOTS, 7))
        self._stamps = np.zeros(_FIRST_SLOTS)
        self._since = np.zeros((_FIRST_SLOTS, 4))
        self._places: dict[TransformNames, _Places] = {}

    def __len__(self) -> int:
        return len(self.parents)

    def __contains__(self, child: str) -> bool:
        return child in self.parents

    def __iter__(self) -> Iterator[str]:
        return iter(self.parents)

    def edge(self, child: str) -> Edge | None:
        """Return the transform of a TF frame; None: there is none."""
        slot = self._slots.get(child)
        if slot is None:
            return None
        (X_PC,) = matrices_of(self._rows[slot : slot + 1])
        return Edge(self.parents[child], X_PC, float(self._stamps[slot]), self.since(child))

    def since(self, child: str) -> Since:
        """Return since when the transform of a TF frame holds."""
        return Since(*self._since[self._slots[child]].tolist())

    def X_PCs(self, names: TransformNames) -> Floats:
        """Return the transforms (n, 4, 4) of TF frames that are known."""
        return matrices_of(self._rows[self._places_of(names).slots])

    def moments(self, names: TransformNames) -> Floats:
        """Return since when (n, 4) the transforms of TF frames hold that are known."""
        return self._since[self._places_of(names).slots]

    def unknown(self, names: TransformNames, rows: Indices) -> set[str]:
        """Return the children of some rows of a message of which there is no transform."""
        return {names.pairs[k][1] for k in rows[self._places_of(names).slots[rows] < 0].tolist()}

    def stamps(self, names: TransformNames, rows: Indices) -> Floats:
        """Return the stamps (n,) [s] that are known of the children of some rows; nan: none."""
        slots = self._places_of(names).slots[rows]
        return np.where(slots < 0, math.nan, self._stamps[slots])

    def take(
        self,
        heard: HeardTransforms,
        rows: Indices,
        change_parent: Callable[[str, str, str], object],
    ) -> tuple[Indices, bool]:
        """Take some rows of a message, which name no child twice, where they are no older.

        Return which were taken, and whether the tree has changed. ``change_parent(child, parent,
        previous_parent)`` is called where a child has another parent now.
        """
        names = heard.transforms.names
        before = self.stamps(names, rows)
        rows = rows[~(heard.stamps[rows] < before) | (before == math.inf)]
        fresh = rows[self._places_of(names).have_other_parents[rows]].tolist()
        for k in fresh:
            parent, child = names.pairs[k]
            if child in self.parents:
                change_parent(child, parent, self.parents[child])
            self._link(child, parent)
        slots = self._places_of(names).slots[rows]
        self._write(heard, rows, slots)
        return rows, bool(fresh)

    def _write(self, heard: HeardTransforms, rows: Indices, slots: Indices) -> None:
        since, stamps, numbers = heard.since, heard.stamps, heard.transforms.rows
        if len(rows) < len(stamps):
            since, stamps, numbers = since[rows], stamps[rows], numbers[rows]
        again = (self._stamps[slots] == stamps) & (stamps != 0.0)
        if again.any():
            since = since.copy()
            since[again] = _said_again(since[again], self._since[slots[again]])
        self._rows[slots], self._stamps[slots], self._since[slots] = numbers, stamps, since

    def forget_moving(self) -> None:
        """Keep static transforms alone."""
        static = [child for child, k in self._slots.items() if self._stamps[k] == math.inf]
        slots = [self._slots[child] for child in static]
        for column in (self._rows, self._stamps, self._since):
            column[: len(static)] = column[slots]
        self._slots = {child: k for k, child in enumerate(static)}
        self.parents = {child: self.parents[child] for child in static}
        self._version += 1

    def _link(self, child: str, parent: str) -> None:
        """Have a child hang on a parent; a child that is new has no numbers yet."""
        self._version += 1
        self.parents[child] = parent
        if child in self._slots:
            return
        slot = self._slots[child] = len(self._slots)
        if slot >= len(self._stamps):
            self._rows, self._stamps, self._since = (
                np.concatenate((column, np.zeros_like(column)))
                for column in (self._rows, self._stamps, self._since)
            )
        self._stamps[slot] = math.nan

    def _places_of(self, names: TransformNames) -> _Places:
        """Return where the transforms of a list of names stand now."""
        places = self._places.get(names)
        if places is None or places.version != self._version:
            slots = [self._slots.get(child, -1) for _, child in names.pairs]
            others = [self.parents.get(child) != parent for parent, child in names.pairs]
            places = _Places(
                self._version,
                np.array(slots, dtype=np.int64),
                np.array(others, dtype=np.bool_),
            )
            if len(self._places) >= _MOST_LISTS:
                self._places.clear()
            self._places[names] = places
        return places


def moments_of(arrival: Arrival, stamps: Floats) -> Floats:
    """Return since when (n, 4) poses hold with stamps (n,) [s]; inf: they do for good."""
    if not stamps.size:
        return np.zeros((0, 4))
    if (stamps == stamps[0]).all():
        since = np.array(_moment(arrival, float(stamps[0])))
        return np.broadcast_to(since, (len(stamps), 4))
    different, which = np.unique(stamps, return_inverse=True)
    return np.array([_moment(arrival, stamp) for stamp in different.tolist()])[which]


def _moment(arrival: Arrival, stamp: float) -> Since:
    return ALWAYS if stamp == math.inf else arrival.since(stamp)


def _said_again(since: Floats, first: Floats) -> Floats:
    """Return since when (n, 4) poses hold that were said ``first``: see ``Since.said_again``."""
    held = np.minimum(since[:, HELD], first[:, HELD])
    again = np.column_stack((since[:, EPOCH], since[:, HEARD], held, first[:, OFFSET]))
    return np.where(first[:, EPOCH, np.newaxis] == since[:, EPOCH, np.newaxis], again, since)
