"""Queries for contact surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import UNABLE
from drake_geom_ros.geometry._contact_surfaces.limits import UNLIMITED, Limit
from drake_geom_ros.geometry._proximity.pairs.answer_rows import ANSWER_WIDTH
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.checks import checked_budget, checked_type
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
from drake_geom_ros.math.array_types import Indices

if TYPE_CHECKING:  # with its kernels
    from drake_geom_ros.geometry._contact_surfaces.asking import Answer


class Contacts(NamedTuple):
    """Contact surfaces, the overlapping pairs without one, and their NoSurface reasons (p,)."""

    surfaces: ContactSurfaceResults
    others: PenetrationResults
    reasons: Indices

    def late(self) -> int:
        """Return how many of the others may have a surface that there was no time for."""
        return int((self.reasons == NoSurface.OUT_OF_TIME).sum())

    def pair(self, k: int) -> tuple[Indices, int]:
        """Return the ids (2,) of a pair without a surface, and the reason."""
        ids = np.array([self.others.id_A[k], self.others.id_B[k]])
        return ids, int(self.reasons[k])


class CandidateSurfaces(NamedTuple):
    """Surfaces and states of candidate pairs (k, 2), given by places in ``all_ids`` (n,)."""

    all_ids: Indices
    pairs: Indices
    answer: Answer
    surfaces: ContactSurfaceResults

    @property
    def ids(self) -> Indices:
        """The ids of the pairs (k, 2), the lower one first."""
        return np.sort(self.all_ids[self.pairs], axis=1)

    def states(self, bodies: ContactBodies, with_coarse: bool) -> Indices | None:
        """Return the state (k,) of each pair, None if each has a surface or NOTHING.

        ``with_coarse`` marks the pairs of the latter whose meshes may be too coarse to meet.
        """
        # Both counts are at hand; the code below costs as much as a small surface.
        count, answer = len(self.pairs), self.answer
        if with_coarse and answer.counts.surfaces + answer.left < count:
            states = bodies.judged(self.ids, answer.states)
            return None if states is answer.states and not answer.left else states
        return answer.states if answer.left else None


def contacts_of(
    bodies: ContactBodies,
    candidates: CandidateSurfaces,
    endless: EndlessOverlaps,
    overlaps: Callable[[], PenetrationResults],
    with_coarse: bool = True,
) -> Contacts:
    """Return the contacts of candidate pairs, and those of half spaces.

    ``overlaps`` is called only if a pair may lack a surface.
    """
    others, reasons = PenetrationResults(np.zeros((0, ANSWER_WIDTH))), np.zeros(0, dtype=np.int64)
    states = candidates.states(bodies, with_coarse)
    if states is not None:
        others, reasons = _without_surface(bodies, candidates.ids, states, overlaps())
    if len(endless.ids):
        others = with_endless(others, endless)
        endings = np.full(len(endless.ids), NoSurface.HALF_SPACES.value)
        order = np.lexsort((others.id_B, others.id_A))
        others, reasons = others.of(order), np.concatenate((reasons, endings))[order]
    return Contacts(candidates.surfaces, others, reasons)


def _without_surface(
    bodies: ContactBodies, ids: Indices, states: Indices, overlaps: PenetrationResults
) -> tuple[PenetrationResults, Indices]:
    """Return the overlaps without a surface and their NoSurface reasons (p,).

    ``ids`` (k, 2) and ``states`` (k,) are those of the candidate pairs.
    """
    without = states >= UNABLE
    rows = zip(ids[without].tolist(), states[without].tolist(), strict=True)
    left = {tuple(pair): state for pair, state in rows}
    overlapping = np.column_stack((overlaps.id_A, overlaps.id_B))
    overlap_states = np.array(
        [left.get(tuple(pair), 0) for pair in overlapping.tolist()], np.int64
    )
    # Surfaces have no padding, so an overlap of paddings alone is not due to coarse meshes.
    bare = overlaps.depth + overlaps.error_bound > bodies.padding_between(overlapping)
    lacking = (overlap_states >= UNABLE) & ((overlap_states != COARSE) | bare)
    reasons = _reasons_of(bodies, overlapping[lacking], overlap_states[lacking])
    return overlaps.of(lacking), reasons


def _reasons_of(bodies: ContactBodies, ids: Indices, states: Indices) -> Indices:
    """Return the NoSurface reasons of pairs of ids (k, 2) with ``states`` (k,)."""
    M, N = np.searchsorted(bodies.ids, ids).T
    return bodies.why_not(M, N, states)


class ContactQueries:
    """Base of ``QueryObject`` with the queries for contact surfaces."""

    _state: ContextState

    if TYPE_CHECKING:  # members of QueryObject

        def ComputePointPairPenetration(self) -> PenetrationResults:
            """Return the pairs that overlap."""

        def _candidates(self) -> tuple[World, Indices]:
            """Return the world, brought up to date, and pairs (k, 2) that may overlap."""

        def _names_of_ids(self, ids: Indices) -> list[str]:
            """Return the names of geometries by their id values (k,)."""

    def ComputeContactSurfaces(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> ContactSurfaceResults:
        """Return the contact surfaces of all unfiltered pairs that press each other.

        Pressures are those of the hydroelastic properties (Elandt, Drumwright, Sherman, Ruina, A
        pressure field model for fast, robust approximation of net contact force and moment, IROS
        2019). A surface is the set of points where both pressures are equal, or the part of a
        rigid surface inside a compliant body. Touching is no contact. Padding is ignored. Sorted
        by (id_M, id_N).

        Raises GeometryError, which names the pair, where an overlapping pair has no surface:

        - one body has no hydroelastic properties;
        - both are rigid (with padding, as in ComputePointPairPenetration);
        - both are half spaces, which overlap unless their normals are opposed and they are apart;
        - one body is so deep inside the other that their pressures are equal nowhere;
        - all faces are left out, as in Drake, because a pressure does not grow along their
          normals.

        Exclude such pairs by collision filters, or use ``ComputeContactSurfacesWithFallback``,
        which answers with point pairs. As in Drake, nothing is raised where the meshes of round
        shapes are so coarse that they miss each other though the shapes touch.
        """
        # Coarse meshes raise nothing, and to detect them would take long.
        contacts = self._contacts(
            self._candidate_surfaces(representation), None, with_coarse=False
        )
        self.refuse_others(contacts)
        return contacts.surfaces

    def refuse_others(self, contacts: Contacts) -> None:
        """Raise GeometryError where pairs overlap without a surface, as ComputeContactSurfaces."""
        refused = np.flatnonzero(contacts.reasons != NoSurface.TOO_COARSE)
        if len(refused):
            raise self._refusal('ComputeContactSurfaces', *contacts.pair(refused[0]))

    def ComputeContactSurfacesWithFallback(
        self,
        representation: HydroelasticContactRepresentation = (
            HydroelasticContactRepresentation.kPolygon
        ),
    ) -> tuple[ContactSurfaceResults, list[PenetrationAsPointPair]]:
        """Return the contact surfaces, and the penetrations of overlapping pairs without one.

        These are the pairs for which ``ComputeContactSurfaces`` raises. Two half spaces that
        overlap have no penetration: for them this raises, too. Only ``contacts`` reports round
        shapes that overlap though their meshes do not.
        """
        candidates = self._candidate_surfaces(representation)
        # Most scenes end here: the code below costs as much as a small surface.
        if not candidates.answer.left and not len(self._state.endless_overlaps().ids):
            return candidates.surfaces, []
        contacts = self._contacts(candidates, None, with_coarse=False)
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
        *,
        time_budget: float | None = None,
        at_once: bool = False,
        must_stop: Callable[[], bool] | None = None,
    ) -> Contacts:
        """Return the result of ComputeContactSurfacesWithFallback as arrays, with reasons.

        It also has round shapes that overlap though their inscribed meshes do not: a finer
        ``resolution_hint`` gives them a surface. To detect them takes a third as long as the
        surfaces of 20 bodies in a heap. Half spaces that overlap are among the others, infinitely
        deep, with an infinite error bound where they are opposed within rounding. Pass the result
        of ComputePointPairPenetration as ``overlaps`` if you have it.

        Pairs that overlap are among the others, with the reason OUT_OF_TIME, where there is no
        time for their surfaces: ``time_budget`` [s] is spent (None or 0: none), ``must_stop()``
        is true, or they are wanted ``at_once`` and are not known after 10 ms of work. The limits
        are checked after each 10 ms or so. Raises ArgumentError for a negative time_budget.
        """
        limit = Limit(
            0.0 if at_once else math.inf,
            checked_budget(time_budget) or math.inf,
            must_stop or UNLIMITED.must_stop,
        )
        candidates = self._candidate_surfaces(representation, limit)
        return self._contacts(candidates, overlaps, with_coarse=True)

    def _contacts(
        self,
        candidates: CandidateSurfaces,
        overlaps: PenetrationResults | None,
        *,
        with_coarse: bool,
    ) -> Contacts:
        """Return the surfaces, and the pairs that overlap without one."""
        return contacts_of(
            self._state.contact_bodies(),
            candidates,
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
        """Return the contact surfaces, and ignore pairs that can have none.

        This is the first part of ``ComputeContactSurfacesWithFallback``, without the cost of the
        second. Raises GeometryError for an overlapping pair that could have a surface and has
        none, see ``ComputeContactSurfaces``.
        """
        candidates = self._candidate_surfaces(representation)
        answer = candidates.answer
        if answer.left and (overlap := answer.states > UNABLE).any():
            at = int(np.argmax(overlap))
            (reason,) = self._reasons(candidates.ids[at : at + 1], answer.states[at : at + 1])
            raise self._refusal('contact_surfaces', candidates.ids[at], int(reason))
        return candidates.surfaces

    def _reasons(self, ids: Indices, states: Indices) -> Indices:
        """Return the NoSurface reasons of pairs of ids (k, 2) with ``states`` (k,)."""
        return _reasons_of(self._state.contact_bodies(), ids, states)

    def _refusal(self, call: str, pair: Indices, reason: int) -> GeometryError:
        """Return the error for a pair of ids (2,) that overlaps and has no surface."""
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

    def _candidate_surfaces(
        self, representation: HydroelasticContactRepresentation, limit: Limit = UNLIMITED
    ) -> CandidateSurfaces:
        """Return the surfaces of all candidate pairs, and the states of these."""
        # Imported here: other queries need not load these kernels, nor those of solids.
        from drake_geom_ros.geometry._contact_surfaces.asking import surfaces_of

        checked_type(representation, HydroelasticContactRepresentation, 'representation')
        world, pairs = self._candidates()
        answer = surfaces_of(self._state.posed_bodies(world), pairs, limit)
        surfaces = ContactSurfaceResults(answer, representation)
        surfaces.know_names(self._names_of_ids)
        return CandidateSurfaces(world.geometries.ids, pairs, answer, surfaces)
