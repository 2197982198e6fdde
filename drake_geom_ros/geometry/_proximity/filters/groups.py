"""Collision filter groups: two bit masks an element, as wide as there are groups.

Bit k of an element's *membership* says that it belongs to group k, bit k of its *ignore* mask
that it ignores group k. A pair is filtered when the membership of either meets the ignore mask
of the other. All elements belong to the universal group, bit 0, so an element that ignores it
is invisible to all others. Groups take bits in the order in which they are first named, even if
only as ignored: ignoring a group that is not defined yet is no error.

Source: Drake's page on collision filter groups. Its masks have a fixed width; here they are
Python's unbounded integers. Queries never evaluate the masks, because ``FilterState`` writes their
effect to its matrix whenever they change.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

UNIVERSAL = 'universal'


class FilterGroups:
    """Membership of elements (plain int keys) in groups, and the groups that each ignores."""

    def __init__(self) -> None:
        self._bits = {UNIVERSAL: 0}
        self._ignored: dict[str, int] = {}  # masks by group, defined groups only
        self._membership: dict[int, int] = {}  # without the universal bit

    def copy(self) -> FilterGroups:
        """Return an independent copy of the groups."""
        other = FilterGroups()
        other._bits = dict(self._bits)
        other._ignored = dict(self._ignored)
        other._membership = dict(self._membership)
        return other

    def define(self, name: str, members: Iterable[int], ignored: Iterable[str]) -> None:
        """Add members and ignored groups to a group; it is created if it does not exist."""
        bit = self._bit(name)
        for key in members:
            self._membership[key] = self._membership.get(key, 0) | 1 << bit
        mask = self._ignored.get(name, 0)
        for other in ignored:
            mask |= 1 << self._bit(other)
        self._ignored[name] = mask

    def forget(self, key: int) -> None:
        """Take an element out of all groups."""
        self._membership.pop(key, None)

    def membership(self, key: int) -> int:
        """Return the mask of the groups that an element belongs to."""
        return self._membership.get(key, 0) | 1

    def ignore(self, key: int) -> int:
        """Return the mask of the groups that an element ignores."""
        membership = self._membership.get(key, 0)
        mask = 0
        for name, ignored in self._ignored.items():
            if membership >> self._bits[name] & 1:
                mask |= ignored
        return mask

    def members(self, name: str) -> tuple[int, ...]:
        """Return the elements of a group, ascending; not valid for the universal group."""
        bit = self._bits[name]
        return tuple(sorted(key for key, mask in self._membership.items() if mask >> bit & 1))

    def names(self) -> list[str]:
        """Return the names of the defined groups in the order of their definition."""
        return list(self._ignored)

    def ignored(self, name: str) -> list[str]:
        """Return the names of the groups that a defined group ignores, by bit."""
        mask = self._ignored[name]
        return [other for other, bit in self._bits.items() if mask >> bit & 1]

    def ignoring(self, name: str) -> list[str]:
        """Return the names of the defined groups that ignore a group."""
        bit = self._bits[name]
        return [other for other, mask in self._ignored.items() if mask >> bit & 1]

    def relations(self, name: str) -> Iterator[tuple[str, str]]:
        """Yield (ignoring, ignored) for all relations of a defined group."""
        for other in self.ignored(name):
            yield name, other
        for other in self.ignoring(name):
            if other != name:
                yield other, name

    def _bit(self, name: str) -> int:
        return self._bits.setdefault(name, len(self._bits))
