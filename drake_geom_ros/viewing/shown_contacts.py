"""Contact surfaces of a posed scene for display, with remarks about them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import QueryObject
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.viewing.patches import Patches, in_pascals


class ShownContacts(NamedTuple):
    """Surfaces to draw, remarks about them, and remarks about contacts that they do not show.

    A picture without patches does not prove that nothing touches.
    """

    patches: Patches
    remarks: list[str]
    missing: list[str]

    @classmethod
    def none(cls) -> ShownContacts:
        """Return no contacts, for a display that shows none."""
        return cls(Patches.none(), [], [])

    @classmethod
    def of(cls, patches: Patches, participants: int, surfaces: int, left: Left) -> ShownContacts:
        """Return contacts with counts of surfaces and of geometries with hydroelastic properties.

        ``left`` describes the pairs that overlap without a surface.
        """
        if not participants:
            words = 'no contact surfaces: no geometry has hydroelastic properties'
            return cls(patches, [], [words])
        remark = counted(surfaces, 'contact surface')
        if surfaces:
            remark += (
                f', from no pressure (dark blue) to {in_pascals(patches.max_pressure)} (yellow)'
            )
        return cls(patches, [remark], left.in_words())


class Left(NamedTuple):
    """Number of pairs that overlap without a surface, with names and NoSurface of the first."""

    pairs: int
    names: tuple[str, str] = ('', '')
    reason: int = 0

    def in_words(self) -> list[str]:
        """Return a remark about these pairs, or none."""
        if not self.pairs:
            return []
        overlap = 'overlaps' if self.pairs == 1 else 'overlap'
        why = NoSurface(self.reason).in_words()
        return [
            f'NOT SHOWN: {counted(self.pairs, "pair")} that {overlap} without a contact surface: '
            f'{self.names[0]} and {self.names[1]}: {why}'
        ]


def contacts_of(query: QueryObject, name_of: Callable[[int], str]) -> ShownContacts:
    """Return the current contact surfaces; nothing is computed without hydroelastic geometries.

    ``name_of`` returns the name of a geometry by its id's value.
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
