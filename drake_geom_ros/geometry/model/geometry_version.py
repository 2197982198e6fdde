"""``GeometryVersion``: detects changes of the geometry of a role."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.model.properties import Role

# Numbers are unique within the process, over all scenes and contexts.
_numbers = itertools.count(1)


def fresh_number() -> int:
    """Return a number that no version has yet."""
    return next(_numbers)


class GeometryVersion:
    """The version of the geometry of each role at the time of ``geometry_version()``.

    Versions are the same as long as nothing of that role is registered, removed or changed (a new
    name is no change; collision filters count for the proximity role). A context starts with the
    version of its scene. A version made without a scene equals itself only.
    """

    __slots__ = ('_numbers',)

    def __init__(self, other: GeometryVersion | None = None) -> None:
        self._numbers: Mapping[Role, int] = other._numbers if other else fresh_marks()

    def IsSameAs(self, other: GeometryVersion, role: Role) -> bool:
        """Return whether nothing of a role changed; raises RuntimeError for kUnassigned."""
        if role not in self._numbers:
            raise ArgumentError(f'IsSameAs: {role!r} has no versions; ask for one of the others')
        return self._numbers[role] == other._numbers[role]


def version_of(numbers: Mapping[Role, int]) -> GeometryVersion:
    """Return the version with these numbers."""
    version = GeometryVersion.__new__(GeometryVersion)
    version._numbers = dict(numbers)
    return version


def fresh_marks() -> dict[Role, int]:
    """Return a new number for each role."""
    return {role: fresh_number() for role in Role if role is not Role.kUnassigned}
