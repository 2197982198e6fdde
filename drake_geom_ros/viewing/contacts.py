"""Contact surfaces of a scene as it stands, and what is said beside them. One place for both."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import QueryObject
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.viewing.patches import Patches, in_pascals


class ShownContacts(NamedTuple):
    """Surfaces to be drawn, what is said of them, and what they do not show.

    No patch in a picture is no proof that nothing presses.
    """

    patches: Patches
    said: list[str]
    missing: list[str]

    @classmethod
    def none(cls) -> ShownContacts:
        """Return what there is where nobody asked."""
        return cls(Patches.none(), [], [])

    @classmethod
    def of(cls, patches: Patches, participants: int, surfaces: int, left: Left) -> ShownContacts:
        """Return so many surfaces, of so many geometries with hydroelastic properties."""
        if not participants:
            words = 'no contact surfaces: no geometry has hydroelastic properties'
            return cls(patches, [], [words])
        said = counted(surfaces, 'contact surface')
        if surfaces:
            said += (
                f', from no pressure (dark blue) to {in_pascals(patches.max_pressure)} (yellow)'
            )
        return cls(patches, [said], left.in_words())


class Left(NamedTuple):
    """How many pairs overlap without a surface; the names of the first, and why: a NoSurface."""

    pairs: int
    names: tuple[str, str] = ('', '')
    reason: int = 0

    def in_words(self) -> list[str]:
        """Return what there is to tell."""
        if not self.pairs:
            return []
        overlap = 'overlaps' if self.pairs == 1 else 'overlap'
        why = NoSurface(self.reason).in_words()
        return [
            f'NOT SHOWN: {counted(self.pairs, "pair")} that {overlap} without a contact surface: '
            f'{self.names[0]} and {self.names[1]}: {why}'
        ]


def contacts_of(query: QueryObject, name_of: Callable[[int], str]) -> ShownContacts:
    """Return the contact surfaces of now; nothing is computed where no geometry has any.

    ``name_of`` gives the name of a geometry by its id's value.
    """
    participants = len(query.hydroelastic_geometries())
    if not participants:
        return ShownContacts.of(Patches.none(), 0, 0, Left(0))
    surfaces, others, reasons = query.contacts()
    left = Left(0)
    if others:
        names = name_of(int(others.id_A[0])), name_of(int(others.id_B[0]))
        left = Left(len(others), names, int(reasons[0]))
    return ShownContacts.of(Patches.of(surfaces), participants, len(surfaces), left)
