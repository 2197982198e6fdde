"""Gaps and overlaps of pairs of half spaces, which no kernel answers.

Two half spaces always intersect, except when they face each other with a gap (judged within
rounding). Where they do not face each other, no translation separates them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    UNIQUE,
)
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM, HALF_SPACE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    DEPTH,
    OVERLAPS,
    PROMISED,
    PairBatch,
)
from drake_geom_ros.geometry._proximity.tolerances import POSITION_STEP
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.queries.padding import Paddings
from drake_geom_ros.geometry.queries.query_results import PenetrationResults
from drake_geom_ros.math.array_types import Floats, Indices


class HalfSpaceGaps(NamedTuple):
    """Distances of pairs of half spaces, ``ids`` (k, 2), the lower one first, ascending.

    Opposed ones have a distance, negative where they overlap. That of all others is minus
    infinity: they intersect, and no translation separates them.
    """

    ids: Indices
    distance: Floats  # (k,) [m]
    error_bound: Floats  # (k,) [m]

    @property
    def lower(self) -> Floats:
        """Certified lower bounds (k,) [m] of the distances: pairs overlap unless it is above 0."""
        bounds: Floats = self.distance - self.error_bound
        return bounds

    @property
    def overlapping(self) -> Indices:
        """The ids (p, 2) of those that overlap, or touch within rounding."""
        return self.ids[~(self.lower > 0.0)]

    def are_beyond(self, margin: float) -> bool:
        """Return whether all are certified to be farther apart than a margin [m]."""
        return bool((self.lower > margin).all())


class EndlessOverlaps(NamedTuple):
    """Pairs of half spaces that overlap, ``ids`` (p, 2), the lower one first, ascending.

    Their depth counts as infinite. Its ``error_bound`` (p,) [m] is 0, but infinite where they are
    opposed within rounding, since a translation may then separate them.
    """

    ids: Indices
    error_bound: Floats


NO_PAIRS = np.zeros((0, 2), dtype=np.int64)
NO_GAPS = HalfSpaceGaps(NO_PAIRS, np.zeros(0), np.zeros(0))
NONE_ENDLESS = EndlessOverlaps(NO_PAIRS, np.zeros(0))


def pairs_of_half_spaces(world: World, filters: FilterState) -> Indices:
    """Return the unfiltered pairs of half spaces (k, 2), by their places in a world, ascending."""
    if not world.has_plane_pairs:
        return NO_PAIRS
    planes = np.flatnonzero(world.geometries.types == HALF_SPACE)
    pairs = planes[np.column_stack(np.triu_indices(len(planes), 1))]
    slots = filters.slots(world.geometries.ids)
    return pairs[filters.mask(slots[pairs[:, 0]], slots[pairs[:, 1]])]


def gaps_of(world: World, pairs: Indices, paddings: Paddings | None) -> HalfSpaceGaps:
    """Return the gaps of such pairs (k, 2) in a world that is up to date.

    Pairs that wait for a pose are left out.
    """
    pairs = pairs[~world.waiting[pairs].any(axis=1)]
    a, b = pairs.T
    nhat_AW, nhat_BW = world.R_WGs[a, :, 2], world.R_WGs[b, :, 2]
    p_AB_W = world.p_WGs[b] - world.p_WGs[a]
    rounding, tilt = (world.roundings[pairs, column].sum(axis=1) for column in (RADIUS, TILT))
    opposed = np.linalg.norm(nhat_AW + nhat_BW, axis=1) <= tilt
    gap = np.einsum('ki,ki->k', nhat_AW, p_AB_W)
    if paddings is not None:
        gap -= paddings.radii[pairs].sum(axis=1)
    slack = rounding + (tilt + POSITION_STEP) * np.abs(p_AB_W).sum(axis=1)
    ids = world.geometries.ids[pairs]
    return HalfSpaceGaps(ids, np.where(opposed, gap, -np.inf), np.where(opposed, slack, 0.0))


def endless_overlaps(world: World, pairs: Indices, paddings: Paddings | None) -> EndlessOverlaps:
    """Return those of such pairs (k, 2) that overlap in a world that is up to date.

    Pairs that wait for a pose are left out.
    """
    if not len(pairs):  # as in most scenes; the code below costs as much as a small surface
        return NONE_ENDLESS
    gaps = gaps_of(world, pairs, paddings)
    overlap = ~(gaps.lower > 0.0)
    opposed = np.isfinite(gaps.distance[overlap])
    return EndlessOverlaps(gaps.ids[overlap], np.where(opposed, np.inf, 0.0))


def with_endless(others: PenetrationResults, endless: EndlessOverlaps) -> PenetrationResults:
    """Return ``others`` followed by ``endless`` ones, which lack witness points and a normal."""
    rows = np.full((len(endless.ids), BATCH_WIDTH), np.nan)
    rows[:, DISTANCE], rows[:, DEPTH] = -np.inf, np.inf
    rows[:, ERROR_BOUND], rows[:, PROMISED] = endless.error_bound, np.inf
    rows[:, METHOD], rows[:, UNIQUE], rows[:, OVERLAPS] = CLOSED_FORM, 0.0, 1.0
    if others.is_padded:
        rows = np.hstack((rows, rows))
    return others.and_others(PairBatch(endless.ids, rows))
