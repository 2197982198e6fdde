"""Collision filters of a scene: which pairs may be reported, and the reasons otherwise.

The candidates are ``C = (G x G) - (A x A) - F - I``: pairs of geometries with the proximity
role, without those of two anchored geometries, of one frame, and of a geometry with itself.
Within these limits groups, cliques and declarations change C, and the last statement about a pair
counts. An allowed pair is reported even if a group or clique excluded it earlier, and a group
defined later excludes it again. A deactivated geometry is in no pair; all statements about it
apply again once it is activated. A new geometry starts with the invariants only, except for
groups that ignore the universal group, to which every geometry belongs.

Four files: ``matrix`` holds the outcome and answers queries, ``log`` holds the statements,
``groups`` the bit masks of groups, and this one keeps the three consistent.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.copied_late import CopiedLate
from drake_geom_ros.common.packed_bits import set_bits
from drake_geom_ros.geometry._proximity.filters import matrix as filter_matrix
from drake_geom_ros.geometry._proximity.filters.groups import UNIVERSAL, FilterGroups
from drake_geom_ros.geometry._proximity.filters.log import (
    Entry,
    FilterLog,
    Keys,
    Statement,
    clique,
    group_relation,
)
from drake_geom_ros.geometry._proximity.filters.matrix import (
    BASE,
    CURRENT,
    NO_ROW,
    BitRows,
    Flags,
    Slots,
)

_FEW_MEMBERS = 8  # of a clique whose pairs are listed
_ANCHORED = 0  # the body of all anchored geometries; a frame's is its id, and ids start at 1


class FilterState:
    """The collision filters of one scene; geometries and frames are plain int ids (keys).

    ``version`` changes whenever ``mask`` may give other answers than before. A geometry has the
    same slot for as long as it is in the state. Unknown keys raise KeyError: the callers that take
    ids from users check them.
    """

    def __init__(self) -> None:
        self.version = 0
        self.groups = FilterGroups()
        self._log = FilterLog()
        self._slot_of: dict[int, int] = {}
        self._free: list[int] = []
        self._bits = CopiedLate(filter_matrix.empty_bits())
        self._bodies: Slots = np.zeros(0, dtype=np.int64)
        self._bit_rows: BitRows = np.zeros(0, dtype=np.int32)
        self._free_rows: list[int] = []
        none = np.zeros(0, dtype=np.int64)
        self._table: tuple[NDArray[np.int64], Slots] = none, none
        self._table_lacks: set[int] = set()  # keys that came or went since it was made
        # Frames welded to the world, with the first pose of each (POSE_WIDTH,) once it has one.
        self.welded: dict[int, NDArray[np.float64] | None] = {}

    def copy(self) -> FilterState:
        """Return an independent copy of the state."""
        return self._with_bits(self._bits.copy(), self._bit_rows.copy())

    def _with_bits(self, bits: CopiedLate[np.uint8], bit_rows: BitRows) -> FilterState:
        """Return an independent copy with other bits."""
        other = copy.copy(self)
        other.groups = self.groups.copy()
        other._log = self._log.copy()
        other._slot_of = dict(self._slot_of)
        other._free = list(self._free)
        other._bits, other._bit_rows = bits, bit_rows
        other._bodies = self._bodies.copy()
        other._free_rows = list(self._free_rows)
        other._table_lacks = set(self._table_lacks)
        other.welded = dict(self.welded)
        return other

    def become(self, other: FilterState) -> None:
        """Take over the content of a copy of this state, which must not be used afterwards.

        First poses of welded frames are retained, since this state may have received some since.
        """
        welded = {frame: self.welded.get(frame, pose) for frame, pose in other.welded.items()}
        self.__dict__.update(other.__dict__)
        self.welded = welded

    def narrowed(self, kinds: NDArray[np.int64], considered: Flags) -> FilterState:
        """Return a copy that excludes all pairs but those of kinds that are ``considered`` (k, k).

        ``kinds`` (n,) are those of the geometries, by ascending keys. The copy is for queries
        only: it does not see later statements. Geometries of one kind share a row, unless they
        have filters of their own.
        """
        slots = self.table()[1]
        excluded = np.zeros((len(considered), len(self._bodies)), dtype=np.bool_)
        excluded[:, slots] = ~considered[:, kinds]
        shared = np.packbits(excluded, axis=1, bitorder='little')
        filtered = np.flatnonzero(self._bit_rows[slots] != NO_ROW)
        bits = np.zeros((2, len(shared) + len(filtered), shared.shape[1]), dtype=np.uint8)
        bits[CURRENT, : len(shared)] = shared
        own = bits[CURRENT, len(shared) :]
        np.take(shared, kinds[filtered], axis=0, out=own)
        own |= self._bits.array[CURRENT, self._bit_rows[slots[filtered]]]
        bit_rows = np.full_like(self._bit_rows, NO_ROW)
        bit_rows[slots] = kinds
        bit_rows[slots[filtered]] = len(shared) + np.arange(len(filtered))
        other = self._with_bits(CopiedLate(bits), bit_rows)
        other.version += 1
        return other

    # Geometries come and go.

    def add(self, key: int, frame: int, anchored: bool) -> None:
        """Add a geometry that gets the proximity role."""
        if not self._free:
            self._grow()
        slot = self._free.pop()
        self._slot_of[key] = slot
        self._bodies[slot] = _ANCHORED if anchored or frame in self.welded else frame
        self._table_lacks.add(key)
        self.version += 1
        self._log.register(key)
        for name in self.groups.ignoring(UNIVERSAL):
            entry = group_relation(name, self.groups.members(name), UNIVERSAL, (key,))
            self._write(entry, BASE)

    def remove(self, key: int) -> None:
        """Remove a geometry that loses the proximity role, with all statements about it."""
        slot = self._slot_of.pop(key)
        if (bit_row := int(self._bit_rows[slot])) != NO_ROW:
            filter_matrix.clear_slot(self._bits.writable(), self._bit_rows, slot)
            self._bit_rows[slot] = NO_ROW
            self._free_rows.append(bit_row)
        self._free.append(slot)
        self._table_lacks.add(key)
        self.groups.forget(key)
        self._log.forget(key)
        self.version += 1

    def weld(self, frame: int, keys: Iterable[int]) -> None:
        """Anchor the geometries of a frame: those of ``keys`` and those added later."""
        self.welded.setdefault(frame, None)
        self._join(keys, _ANCHORED)

    def unweld(self, frame: int, keys: Iterable[int]) -> None:
        """Make the geometries of a welded frame those of a moving body again."""
        del self.welded[frame]
        self._join(keys, frame)

    def _join(self, keys: Iterable[int], body: int) -> None:
        for key in keys:
            slot = self._slot_of[key]
            self._bodies[slot] = body if self._bodies[slot] >= 0 else ~body
        self.version += 1

    def all_keys(self) -> list[int]:
        """Return the keys of all geometries, ascending."""
        return sorted(self._slot_of)

    def knows(self, keys: Iterable[int]) -> bool:
        """Return whether all keys are those of geometries in this state."""
        return all(map(self._slot_of.__contains__, keys))

    # Reads by queries.

    def table(self) -> tuple[NDArray[np.int64], Slots]:
        """Return the keys of all geometries, ascending, and the slot of each."""
        if self._table_lacks:
            changed, (keys, slots) = sorted(self._table_lacks), self._table
            at = np.searchsorted(keys, changed)
            former = at[np.append(keys, -1)[at] == changed]
            new = [key for key in changed if key in self._slot_of]
            if keys[former].tolist() == new:  # roles that were removed and assigned again
                slots = slots.copy()
                slots[former] = self._slots_of(new)
            else:
                if len(former):
                    keys, slots = np.delete(keys, former), np.delete(slots, former)
                if new:
                    places = np.searchsorted(keys, new)
                    keys = np.insert(keys, places, new)
                    slots = np.insert(slots, places, self._slots_of(new))
            self._table = keys, slots
            self._table_lacks = set()
        return self._table

    def slots(self, keys: NDArray[np.int64]) -> Slots:
        """Return the slot of each geometry."""
        sorted_keys, slots = self.table()
        if np.array_equal(sorted_keys, keys):
            return slots
        return slots[np.searchsorted(sorted_keys, keys)]

    def mask(self, slots_a: Slots, slots_b: Slots) -> Flags:
        """Return whether each pair of slots may be reported."""
        flags: Flags = filter_matrix.reportable(*self.matrix, slots_a, slots_b)
        return flags

    @property
    def matrix(self) -> tuple[filter_matrix.Bits, Slots, BitRows]:
        """The bits, bodies and rows by slot, for compiled code; valid until the next change."""
        return self._bits.array, self._bodies, self._bit_rows

    def filtered(self, key_a: int, key_b: int) -> bool:
        """Return whether a pair is not reported, for whatever reason."""
        return not self.mask(self._slots_of((key_a,)), self._slots_of((key_b,)))[0]

    def explain(self, key_a: int, key_b: int) -> list[str]:
        """Return all reasons why a pair is filtered, each sufficient alone; empty if it is not.

        First ``self``, ``anchored`` or ``same frame`` (which nothing can change) and
        ``deactivated``. Then the statements that exclude the pair since it was last allowed,
        newest first: ``transient declaration ID``, ``persistent declaration N`` (counted from 0),
        ``group NAME`` (the group that ignores the other's) and ``clique NAME``. Of declarations
        about exactly the same sets the last one is named.
        """
        body_a, body_b = self._bodies[self._slots_of((key_a, key_b))].tolist()
        reasons = []
        if key_a == key_b:
            reasons.append('self')
        elif _body(body_a) == _body(body_b):
            reasons.append('anchored' if _body(body_a) == _ANCHORED else 'same frame')
        if body_a < 0 or body_b < 0:
            reasons.append('deactivated')
        return reasons + self._log.reasons(key_a, key_b)

    def filtered_pairs(self) -> int:
        """Return the number of pairs that are filtered and not invariant."""
        slots = self._slots_of(self._slot_of)
        return int(filter_matrix.count_filtered(*self.matrix, slots))

    # Declarations, groups and cliques.

    def apply(self, statements: Iterable[Statement]) -> None:
        """Make a persistent declaration; later statements override earlier ones."""
        for entry in self._log.declare(statements):
            self._write(entry, BASE)

    def add_group(self, name: str, members: Iterable[int], ignored: Iterable[str]) -> None:
        """Define a group, or extend it, and declare all its relations."""
        self.groups.define(name, members, ignored)
        for ignoring, other in self.groups.relations(name):
            ignored_members = None if other == UNIVERSAL else self.groups.members(other)
            ignoring_members = self.groups.members(ignoring)
            if ignoring_members and ignored_members != ():
                self._relate(group_relation(ignoring, ignoring_members, other, ignored_members))

    def add_clique(self, name: str, members: Iterable[int]) -> None:
        """Define a clique, or extend it: no two of its members are reported."""
        self.add_cliques(((name, members),))

    def add_cliques(self, cliques: Iterable[tuple[str, Iterable[int]]]) -> None:
        """Do as ``add_clique`` does for each name and its members."""
        entries = []
        for name, members in cliques:
            if joined := tuple(sorted({*members, *self._log.clique_members(name)})):
                entries.append(clique(name, joined))
                self._log.relate(entries[-1])
        self._write_cliques(entries)
        if entries and self.has_transient_history:
            self._replay(entries)

    def cliques(self) -> dict[str, Keys]:
        """Return the members of each clique by its name."""
        return self._log.cliques()

    def declarations(self) -> list[list[Statement]]:
        """Return the persistent declarations, to be applied after defining groups and cliques."""
        return self._log.declarations(tuple(self.all_keys()))

    def activate(self, keys: Iterable[int]) -> None:
        """Let geometries be reported again."""
        self._switch(keys, active=True)

    def deactivate(self, keys: Iterable[int]) -> None:
        """Keep geometries from being reported in any pair."""
        self._switch(keys, active=False)

    def deactivated(self) -> list[int]:
        """Return the geometries that are deactivated, ascending."""
        return sorted(key for key, slot in self._slot_of.items() if self._bodies[slot] < 0)

    # The transient history.

    def apply_transient(self, statements: Iterable[Statement], filter_id: int) -> None:
        """Make a transient declaration on top of all others, under an unused id."""
        for entry in self._log.push(filter_id, statements):
            self._write(entry, CURRENT)

    def remove_declaration(self, filter_id: int) -> bool:
        """Remove a transient declaration; return whether one with that id existed."""
        return bool(self.remove_declarations((filter_id,)))

    def remove_declarations(self, filter_ids: Iterable[int]) -> list[int]:
        """Remove transient declarations; return the ids of those that existed.

        Only the rows of geometries that they mention are rebuilt, from the other transient
        declarations about these geometries, in one pass for all removed ones.
        """
        gone = list(filter(self.is_active, dict.fromkeys(filter_ids)))
        if gone:
            said = [entry for filter_id in gone for entry in self._log.pull(filter_id)]
            self._replay(said)
        return gone

    def flatten(self) -> None:
        """Make the current configuration the persistent one, and clear the transient history."""
        touched = self._rows_of(self._mentioned(self._log.history()))
        bits = self._bits.writable()
        bits[BASE, touched] = bits[CURRENT, touched]
        self._log.flatten()

    def is_active(self, filter_id: int) -> bool:
        """Return whether a transient declaration is in the history."""
        return self._log.is_active(filter_id)

    @property
    def has_transient_history(self) -> bool:
        """True if there are transient declarations."""
        return self._log.has_history()

    @property
    def active_ids(self) -> list[int]:
        """The ids of the transient declarations, first to last."""
        return self._log.active_ids()

    # From statements to bits.

    def _relate(self, entry: Entry) -> None:
        """Add an entry to the persistent base, below the transient history."""
        self._log.relate(entry)
        self._write(entry, BASE)
        if self.has_transient_history:
            self._replay([entry])

    def _write(self, entry: Entry, first_layer: int) -> None:
        slots_a, slots_b = self._sides(entry)
        self.version += filter_matrix.write_pairs(
            self._bits.writable(), self._bit_rows, first_layer, slots_a, slots_b, entry.excludes
        )

    def _write_cliques(self, entries: Iterable[Entry]) -> None:
        """Write cliques, those of a few members all at once.

        A robot of 4000 links has as many cliques of two. A compiled call for each gives Python's
        interpreter up and takes it back microseconds later: a thread that waits for it is woken
        each time, and comes too late. So cycles stood still for 50 ms and more.
        """
        pairs: list[tuple[int, ...]] = []
        for entry in entries:
            if len(entry.keys_a) > _FEW_MEMBERS:
                self._write(entry, BASE)
            else:
                slots = [self._slot_of[key] for key in entry.keys_a]
                pairs += product(slots, repeat=2)
        if pairs:
            slots_a, slots_b = np.array(pairs, dtype=np.int64).T
            self._give_rows(slots_a)
            for layer in self._bits.writable():
                self.version += set_bits(layer, self._bit_rows[slots_a], slots_b)

    def _replay(self, said: Collection[Entry]) -> None:
        """Rebuild the rows that entries mention from the base and from what else is about them."""
        touched = self._mentioned(said)
        bit_rows = self._rows_of(touched)
        bits = self._bits.writable()
        bits[CURRENT, bit_rows] = bits[BASE, bit_rows]
        is_touched = np.zeros(len(self._bodies), dtype=np.bool_)
        is_touched[touched] = True
        for entry in self._log.history_about(said):
            a, b = self._sides(entry)
            matrix = self._bits.writable(), self._bit_rows, CURRENT
            filter_matrix.write_rows(*matrix, a[is_touched[a]], b, entry.excludes)
            filter_matrix.write_rows(*matrix, b[is_touched[b]], a, entry.excludes)
        self.version += 1

    def _sides(self, entry: Entry) -> tuple[Slots, Slots]:
        """Return the slots of both sets of an entry; if it excludes, they are given rows."""
        slots_a = slots_b = self._slots_of(entry.keys_a)
        if entry.keys_b is not entry.keys_a:
            slots_b = self._slots_of(self._slot_of if entry.keys_b is None else entry.keys_b)
        if entry.excludes and slots_a.size and slots_b.size:
            self._give_rows(slots_a)
            self._give_rows(slots_b)
        return slots_a, slots_b

    def _give_rows(self, slots: Slots) -> None:
        """Give a row of the matrix to each slot that has none."""
        without_row = slots[self._bit_rows[slots] == NO_ROW]
        if not without_row.size:
            return  # soon, for a history is replayed by this
        lacking = np.unique(without_row)
        if (more := len(lacking) - len(self._free_rows)) > 0:
            bits = self._bits.array
            former = bits.shape[1]
            capacity = filter_matrix.capacity_for(former + more, former)
            self._bits = CopiedLate(filter_matrix.grown_bits(bits, capacity, len(self._bodies)))
            self._free_rows += range(former, capacity)
        for slot in lacking:
            self._bit_rows[slot] = self._free_rows.pop()

    def _rows_of(self, slots: Slots) -> BitRows:
        """Return the rows of those slots that have one."""
        bit_rows: BitRows = self._bit_rows[slots]
        existing_rows: BitRows = bit_rows[bit_rows != NO_ROW]
        return existing_rows

    def _mentioned(self, said: Iterable[Entry]) -> Slots:
        """Return the slots that some entries mention, each once."""
        sides = [side for entry in said for side in self._sides(entry)]
        return np.unique(np.concatenate(sides)) if sides else np.zeros(0, dtype=np.int64)

    def _slots_of(self, keys: Collection[int]) -> Slots:
        return np.fromiter(map(self._slot_of.__getitem__, keys), np.int64, len(keys))

    def _switch(self, keys: Iterable[int], active: bool) -> None:
        for key in keys:
            slot = self._slot_of[key]
            if (self._bodies[slot] >= 0) != active:
                self._bodies[slot] = ~self._bodies[slot]
                self.version += 1

    def _grow(self) -> None:
        """Grow the capacity; the lowest slots are used first."""
        former = len(self._bodies)
        capacity = filter_matrix.capacity_for(former + 1, former)
        bits = self._bits.array
        self._bits = CopiedLate(filter_matrix.grown_bits(bits, bits.shape[1], capacity))
        more = capacity - former
        self._bodies = np.concatenate((self._bodies, np.zeros(more, dtype=np.int64)))
        self._bit_rows = np.concatenate((self._bit_rows, np.full(more, NO_ROW, dtype=np.int32)))
        self._free = list(range(capacity - 1, former - 1, -1))


def _body(number: int) -> int:
    """Return the body number of a slot, whether it is deactivated or not."""
    return max(number, ~number)
