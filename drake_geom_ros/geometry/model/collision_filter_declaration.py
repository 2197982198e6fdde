"""Declarations of collision filters: lists of statements about pairs, of which later ones win."""

from __future__ import annotations

import enum
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentTypeError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.geometry_set import GeometrySet, members_of


class CollisionFilterScope(enum.Enum):
    """The geometries that a declaration affects; without deformable ones both are the same."""

    kAll = 0
    kOmitDeformable = 1


class SetSnapshot(NamedTuple):
    """Snapshot of a GeometrySet as plain numbers, which need no hashing again."""

    geometries: tuple[int, ...]  # ascending
    frames: tuple[FrameId, ...]

    @staticmethod
    def of(geometry_set: GeometrySet, argument: str) -> SetSnapshot:
        """Return the snapshot of a set; raises ArgumentTypeError for other types."""
        checked_type(geometry_set, GeometrySet, f'CollisionFilterDeclaration: {argument}')
        geometry_ids, frame_ids = members_of(geometry_set)
        return SetSnapshot(
            tuple(sorted([id.get_value() for id in geometry_ids])), tuple(frame_ids)
        )


class CollisionFilterDeclaration:
    """A change of the candidate pairs C, for ``CollisionFilterManager`` to apply.

    Its statements are applied in order. Sets are copied at the call, and resolved against a scene
    when the declaration is applied. Each method returns the declaration itself, so that
    statements can be chained:

        >>> from drake_geom_ros.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet
        >>> hand, cup = GeometrySet(GeometryId(3)), GeometrySet(GeometryId(4))
        >>> declaration = CollisionFilterDeclaration().ExcludeBetween(hand, cup)
    """

    __slots__ = ('_scope', '_statements')

    def __init__(self, scope: CollisionFilterScope = CollisionFilterScope.kAll) -> None:
        """Make a declaration without statements; raises RuntimeError for an invalid scope."""
        self._scope = checked_type(scope, CollisionFilterScope, 'scope')
        self._statements: list[tuple[FilterOperation, SetSnapshot, SetSnapshot]] = []

    def AllowBetween(self, set_A: GeometrySet, set_B: GeometrySet) -> CollisionFilterDeclaration:
        """Put the pairs (a, b) of the two sets into C, except invariant ones; return self."""
        return self.Declare(FilterOperation.ALLOW_BETWEEN, set_A, set_B)

    def AllowWithin(self, geometry_set: GeometrySet) -> CollisionFilterDeclaration:
        """Put all pairs of the set into C, except invariant ones; return self."""
        return self.Declare(FilterOperation.ALLOW_WITHIN, geometry_set)

    def ExcludeBetween(self, set_A: GeometrySet, set_B: GeometrySet) -> CollisionFilterDeclaration:
        """Take the pairs (a, b) of the two sets out of C; return self."""
        return self.Declare(FilterOperation.EXCLUDE_BETWEEN, set_A, set_B)

    def ExcludeWithin(self, geometry_set: GeometrySet) -> CollisionFilterDeclaration:
        """Take all pairs of the set out of C; return self."""
        return self.Declare(FilterOperation.EXCLUDE_WITHIN, geometry_set)

    def Declare(
        self, operation: FilterOperation, set_A: GeometrySet, set_B: GeometrySet | None = None
    ) -> CollisionFilterDeclaration:
        """Add the statement of an operation about one set or two, and return self.

        Raises ArgumentTypeError where it takes another number of sets.
        """
        checked_type(operation, FilterOperation, 'operation')
        if operation.takes_two_sets != (set_B is not None):
            sets = 'set_A and set_B' if operation.takes_two_sets else 'one set'
            raise ArgumentTypeError(f'CollisionFilterDeclaration: {operation.value} takes {sets}')
        if set_B is None:
            snapshot = SetSnapshot.of(set_A, 'geometry_set')
            self._statements.append((operation, snapshot, snapshot))
        else:
            snapshots = SetSnapshot.of(set_A, 'set_A'), SetSnapshot.of(set_B, 'set_B')
            self._statements.append((operation, *snapshots))
        return self
