"""The queries for contact surfaces."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import UNABLE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import ANSWER_WIDTH
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._records import named
from drake_geom_ros.geometry.queries.contact_bodies import COARSE, ContactBodies, NoSurface
from drake_geom_ros.geometry.queries.contact_surfaces import (
    ContactSurfaceResults,
    HydroelasticContactRepresentation,
)
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.half_space_pairs import EndlessOverlaps, with_endless
from drake_geom_ros.geometry.queries.query_records import PenetrationAsPointPair
from drake_geom_ros.geometry.queries.query_results import PenetrationResults

if TYPE_CHECKING:  # with its kernels
    from drake_geom_ros.geometry._contact_surfaces.asking import Answer

Indices = NDArray[np.int64]


class Contacts(NamedTuple):
    """Contact surfaces; and the pairs that overlap and have none, and why (p,): a NoSurface."""

    surfaces: ContactSurfaceResults
    others: PenetrationResults
    reasons: Indices

    def pair(self, k: int) -> tuple[Indices, int]:
        """Return the ids (2,) of a pair without a surface, and the reason."""
        ids = np.array([self.others.id_A[k], self.others.id_B[k]])
        return ids, int(self.reasons[k])


class Found(NamedTuple):
    """What was found of pairs (k, 2), by the places of geometries among ids (n,)."""

    all_ids: Indices
    pairs: Indices
    answer: Answer
    surfaces: ContactSurfaceResults

    @property
    def ids(self) -> Indices:
        """The ids of the pairs (k, 2), the lower one first."""
        return np.sort(self.all_ids[self.pairs], axis=1)

    def states(self, bodies: ContactBodies, with_coarse: bool) -> Indices | None:
        """Return what there is of each pair (k,), None where all of them press or have nothing.

        ``with_coarse`` those of which meshes may be too coarse to meet are told from the latter.
        """
        # Both counts are there already, and what follows takes as long as a small surface.
        count, answer = len(self.pairs), self.answer
        if with_coarse and answer.counts.surfaces + answer.left < count:
            states = bodies.judged(self.ids, answer.states)
            return None if states is answer.states and not answer.left else states
        return answer.states if answer.left else None


def contacts_of(
    bodies: ContactBodies,
    found: Found,
    endless: EndlessOverlaps,
    overlaps: Callable[[], PenetrationResults],
    with_coarse: bool = True,
) -> Contacts:
    """Return the contacts of pairs by what was found of them, and those of half spaces.

    ``overlaps`` are asked for where a pair may be without a surface.
    """
    others, reasons = PenetrationResults(np.zeros((0, ANSWER_WIDTH))), np.zeros(0, dtype=np.int64)
    states = found.states(bodies, with_coarse)
    if states is not None:
        others, reasons = _without_surface(bodies, found.ids, states, overlaps())
    if len(endless.ids):
        others = with_endless(others, endless)
        endings = np.full(len(endless.ids), NoSurface.HALF_SPACES.value)
        order = np.lexsort((others.id_B, others.id_A))
        others, reasons = others.of(order), np.concatenate((reasons, endings))[order]
    return Contacts(found.surfaces, others, reasons)


def _without_surface(
    bodies: ContactBodies, ids: Indices, states: Indices, overlaps: PenetrationResults
) -> tuple[PenetrationResults, Indices]:
    """Return the overlaps that have no surface, and why (p,): a NoSurface.

    Of pairs of ids (k, 2) by what there is of them (k,).
    """
    without = states >= UNABLE
    rows = zip(ids[without].tolist(), states[without].tolist(), strict=True)
    left = {tuple(pair): state for pair, state in rows}
    overlapping = np.column_stack((overlaps.id_A, overlaps.id_B))
    found = np.array([left.get(tuple(pair), 0) for pair in overlapping.tolist()], np.int64)
    # Padding is no part of a surface: what overlaps by it alone has been missed by no mesh.
    bare = overlaps.depth + overlaps.error_bound > bodies.padding_between(overlapping)
    kept = (found >= UNABLE) & ((found != COARSE) | bare)
    return overlaps.of(kept), _reasons_of(bodies, overlapping[kept], found[kept])


def _reasons_of(bodies: ContactBodies, ids: Indices, states: Indices) -> Indices:
    """Return why pairs of ids (k, 2) of these states have no surface."""
    M, N = np.searchsorted(bodies.ids, ids).T
    return bodies.why_not(M, N, states)


class ContactQueries:
    """What a query object answers about contact surfaces; it has all other queries too."""

    _state: ContextState

    if TYPE_CHECKING:  # which a query object has

        def ComputePointPairPenetration(self) -> PenetrationResults:
            """Return the pairs that overlap."""

        def _candidates(self) -> tuple[World, Indices]:
            """Return the world, brought up to date, and pairs (k, 2) that may overlap."""

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
        one without hydroelastic properties, two rigid ones (their padding counts, as in
        ComputePointPairPenetration), two half spaces, which overlap unless their normals are
        opposed and they are apart; where one body is so deep within the other that
        their pressures are equal nowhere; and where all faces are left out, as in Drake, because
        a pressure does not grow along their normals. Collision filters leave pairs out, and
        ``ComputeContactSurfacesWithFallback`` answers for them by points. As in Drake nothing is
        raised where the meshes of round shapes are so coarse that they miss what the shapes touch.
        """
        # Where only meshes miss one another nothing is raised, and it would take long to know.
        contacts = self._contacts(self._found(representation), None, with_coarse=False)
        self.refuse_others(contacts)
        return contacts.surfaces

    def refuse_others(self, contacts: Contacts) -> None:
        """Raise GeometryError where pairs overlap that have no surface: see above."""
        refused = np.flatnonzero(contacts.reasons != NoSurface.TOO_COARSE)
        if len(refused):
            raise self._refusal('ComputeContactSurfaces', *contacts.pair(refused[0]))

    def ComputeContactSurfacesWithFallback(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> tuple[ContactSurfaceResults, list[PenetrationAsPointPair]]:
        """Return the contact surfaces, and the penetration of pairs that overlap and have none.

        These are the pairs for which ``ComputeContactSurfaces`` raises. Of two half spaces that
        overlap there is no penetration: for them this raises, too. Round ones that overlap though
        the meshes which stand for them do not are told by ``contacts`` alone: see there.
        """
        found = self._found(representation)
        # Most scenes end here: what follows takes as long as a small surface.
        if not found.answer.left and not len(self._state.endless_overlaps().ids):
            return found.surfaces, []
        contacts = self._contacts(found, None, with_coarse=False)
        endless = np.flatnonzero(contacts.reasons == NoSurface.HALF_SPACES)
        if len(endless):
            raise self._refusal('ComputeContactSurfacesWithFallback', *contacts.pair(endless[0]))
        return contacts.surfaces, list(contacts.others)

    def contacts(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
        overlaps: PenetrationResults | None = None,
    ) -> Contacts:
        """Return what ComputeContactSurfacesWithFallback does, as arrays, with the reasons.

        And round shapes that overlap though the meshes which stand for them, within the shapes, do
        not: there a finer ``resolution_hint`` gives a surface. To know that takes a third as long
        as the surfaces of 20 bodies in a heap. Half spaces that overlap are among the others:
        infinitely deep, and where they are opposed within rounding with an infinite error bound.
        ``overlaps`` are those of ComputePointPairPenetration, where these are known already.
        """
        return self._contacts(self._found(representation), overlaps, with_coarse=True)

    def _contacts(
        self, found: Found, overlaps: PenetrationResults | None, *, with_coarse: bool
    ) -> Contacts:
        """Return the surfaces, and the pairs that overlap without one."""
        return contacts_of(
            self._state.contact_bodies(),
            found,
            self._state.endless_overlaps(),
            lambda: self.ComputePointPairPenetration() if overlaps is None else overlaps,
            with_coarse,
        )

    def hydroelastic_geometries(self) -> Indices:
        """Return the values of the ids (b,) of all geometries with hydroelastic properties."""
        bodies = self._state.contact_bodies()
        return bodies.ids[bodies.body_of >= 0]

    def contact_surfaces(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> ContactSurfaceResults:
        """Return the surfaces of pairs that can have one; nothing is said of the others.

        What ``ComputeContactSurfacesWithFallback`` returns first, without the work of the rest.
        Raises GeometryError where two overlap and have none that could: see
        ``ComputeContactSurfaces``.
        """
        found = self._found(representation)
        if found.answer.left and (overlap := found.answer.states > UNABLE).any():
            at = int(np.argmax(overlap))
            (reason,) = self._reasons(found.ids[at : at + 1], found.answer.states[at : at + 1])
            raise self._refusal('contact_surfaces', found.ids[at], int(reason))
        return found.surfaces

    def _reasons(self, ids: Indices, states: Indices) -> Indices:
        """Return why pairs of ids (k, 2) of these states have no surface."""
        return _reasons_of(self._state.contact_bodies(), ids, states)

    def _refusal(self, call: str, pair: Indices, reason: int) -> GeometryError:
        """Return what is raised for a pair of ids (2,) that overlaps and has no surface."""
        names = ' and '.join(
            named(self._state.model.geometry(GeometryId(id))) for id in pair.tolist()
        )
        instead = ', or use ComputeContactSurfacesWithFallback'
        if reason == NoSurface.HALF_SPACES:
            instead = ''
        return GeometryError(
            f'{call}: {names} overlap and have no surface: {NoSurface(reason).in_words()}. Filter '
            f'the pair{instead}.'
        )

    def _found(self, representation: HydroelasticContactRepresentation) -> Found:
        """Return the surfaces of all candidates, and which of them can have none."""
        # Only who asks for surfaces loads their kernels, and those of solids behind them.
        from drake_geom_ros.geometry._contact_surfaces.asking import surfaces_of

        checked_type(representation, HydroelasticContactRepresentation, 'representation')
        world, pairs = self._candidates()
        answer = surfaces_of(self._state.posed_bodies(world), pairs)
        surfaces = ContactSurfaceResults(answer, representation)
        return Found(world.geometries.ids, pairs, answer, surfaces)
