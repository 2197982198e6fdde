"""The queries for contact surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.pairs.answer_rows import ANSWER_WIDTH
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._records import named
from drake_geom_ros.geometry.queries.contact_bodies import ContactBodies, NoSurface
from drake_geom_ros.geometry.queries.contact_surfaces import (
    ContactSurfaceResults,
    HydroelasticContactRepresentation,
)
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.query_records import PenetrationAsPointPair
from drake_geom_ros.geometry.queries.query_results import PenetrationResults

Indices = NDArray[np.int64]


class Contacts(NamedTuple):
    """Contact surfaces; and the pairs that overlap and have none, and why (p,): a NoSurface."""

    surfaces: ContactSurfaceResults
    others: PenetrationResults
    reasons: Indices


class ContactQueries:
    """What a query object answers about contact surfaces; it has all other queries too."""

    _state: ContextState

    if TYPE_CHECKING:  # which a query object has

        def ComputePointPairPenetration(self) -> PenetrationResults:
            """Return the pairs that overlap."""

        def collision_candidates(self) -> Indices:
            """Return the pairs of ids (k, 2) that bounds alone do not keep apart."""

    def ComputeContactSurfaces(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> ContactSurfaceResults:
        """Return the contact surfaces of all unfiltered pairs that press each other.

        Pressures are those of the hydroelastic properties (Elandt, Drumwright, Sherman, Ruina, A
        pressure field model for fast, robust approximation of net contact force and moment, IROS
        2019): a surface is where both are equal, or where a rigid one is in a compliant one.
        Touching is no contact. Padding is no part of it. Sorted by (id_M, id_N).

        Raises GeometryError, which names the pair, where one overlaps that can have no surface:
        one without hydroelastic properties, two rigid ones, two half spaces (their padding counts,
        as in ComputePointPairPenetration); and where one body is so deep within the other that
        their pressures are equal nowhere. Collision filters leave pairs out, and
        ``ComputeContactSurfacesWithFallback`` answers for them by points.
        """
        contacts = self.contacts(representation)
        self.refuse_others(contacts)
        return contacts.surfaces

    def refuse_others(self, contacts: Contacts) -> None:
        """Raise GeometryError where pairs overlap that have no surface: see above."""
        if contacts.others:
            first = contacts.others[0]
            raise self._refusal('ComputeContactSurfaces', first.id_A, first.id_B)

    def ComputeContactSurfacesWithFallback(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> tuple[ContactSurfaceResults, list[PenetrationAsPointPair]]:
        """Return the contact surfaces, and the penetration of pairs that overlap and have none.

        These are the pairs for which ``ComputeContactSurfaces`` raises.
        """
        surfaces, others, _ = self.contacts(representation)
        return surfaces, list(others)

    def contacts(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
        overlaps: PenetrationResults | None = None,
    ) -> Contacts:
        """Return what ComputeContactSurfacesWithFallback does, as arrays, with the reasons.

        ``overlaps`` are those of ComputePointPairPenetration, where these are known already.
        """
        candidates, rows, able = self._candidates()
        surfaces, swallowed = self._surfaces(candidates[able], rows[able], representation)
        left = ~able
        left[able] = swallowed
        if not left.any():
            none = np.zeros(0, dtype=np.int64)
            return Contacts(surfaces, PenetrationResults(np.zeros((0, ANSWER_WIDTH))), none)
        if overlaps is None:
            overlaps = self.ComputePointPairPenetration()
        those = {tuple(ids) for ids in candidates[left].tolist()}
        ids = np.column_stack((overlaps.id_A, overlaps.id_B))
        kept = np.fromiter((tuple(pair) in those for pair in ids.tolist()), np.bool_, len(ids))
        bodies = self._state.contact_bodies()
        reasons = bodies.why_not(*bodies.rows(ids[kept]).T)
        return Contacts(surfaces, overlaps.of(kept), reasons)

    def hydroelastic_geometries(self) -> Indices:
        """Return the values of the ids (b,) of all geometries with hydroelastic properties."""
        return self._state.contact_bodies().ids

    def contact_surfaces(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> ContactSurfaceResults:
        """Return the surfaces of pairs that can have one; nothing is said of the others.

        What ``ComputeContactSurfacesWithFallback`` returns first, without the work of the rest.
        Raises GeometryError where one body is so deep within the other that they have none.
        """
        candidates, rows, able = self._candidates()
        surfaces, swallowed = self._surfaces(candidates[able], rows[able], representation)
        if swallowed.any():
            a, b = candidates[able][int(np.argmax(swallowed))].tolist()
            raise self._refusal('contact_surfaces', GeometryId(a), GeometryId(b))
        return surfaces

    def _refusal(self, call: str, M: GeometryId, N: GeometryId) -> GeometryError:
        """Return what is raised for a pair that overlaps and has no surface."""
        bodies = self._state.contact_bodies()
        a, b = bodies.rows(np.array([[M.get_value()], [N.get_value()]]))
        reason = NoSurface(int(bodies.why_not(a, b)[0]))
        names = ' and '.join(named(self._state.model.geometry(id)) for id in (M, N))
        return GeometryError(
            f'{call}: {names} overlap and have no surface: {reason.in_words()}. Filter the '
            'pair, or use ComputeContactSurfacesWithFallback.'
        )

    def _candidates(self) -> tuple[Indices, Indices, NDArray[np.bool_]]:
        """Return pairs of ids (k, 2), M first, their bodies, and whether they can have one."""
        bodies = self._state.contact_bodies()
        candidates = np.sort(self.collision_candidates(), axis=1)
        rows = bodies.rows(candidates)
        return candidates, rows, bodies.have_a_surface(rows[:, 0], rows[:, 1])

    def _surfaces(
        self,
        ids: Indices,
        rows: Indices,
        representation: HydroelasticContactRepresentation,
    ) -> tuple[ContactSurfaceResults, NDArray[np.bool_]]:
        """Return the surfaces of pairs (k, 2) that can have one, and which overlap without."""
        # Only who asks for surfaces loads their kernels, and those of solids behind them.
        from drake_geom_ros.geometry._contact_surfaces.pairs import surfaces_of

        checked_type(representation, HydroelasticContactRepresentation, 'representation')
        bodies: ContactBodies = self._state.contact_bodies()
        world = self._state.posed_world()
        world.update()
        places = world.geometry_rows(bodies.ids)
        out = surfaces_of(
            bodies.bodies, np.ascontiguousarray(rows), world.R_WGs[places], world.p_WGs[places]
        )
        compliant = bodies.is_compliant[rows].reshape(-1, 2)
        surfaces = ContactSurfaceResults(ids.reshape(-1, 2), compliant, out, representation)
        return surfaces, out.swallowed
