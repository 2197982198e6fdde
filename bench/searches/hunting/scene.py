"""Many disjoint pairs in one scene, asked by every query at once."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    METHODS,
    CollisionFilterDeclaration,
    GeometrySet,
    PenetrationResults,
    SignedDistanceResults,
)
from drake_geom_ros.math.array_types import Floats
from truth.judging.asking import BodyScene


class Distances(NamedTuple):
    """Signed distances of n pairs; as in SignedDistanceResults, copied."""

    distance: Floats
    error_bound: Floats
    promised: Floats
    nhat_BA_W: Floats
    p_WCa: Floats
    p_WCb: Floats
    p_ACa: Floats
    p_BCb: Floats
    unique: NDArray[np.bool_]
    by_bounds: NDArray[np.bool_]  # answered from bounding volumes alone


class Depths(NamedTuple):
    """Penetrations of n pairs; NaN where a pair is not reported."""

    depth: Floats
    error_bound: Floats


class Replies(NamedTuple):
    """All answers about n pairs as they are posed."""

    levels: dict[str, Distances]
    fresh: Distances  # exact, of a context that was never asked
    depths: dict[str, Depths]  # by level
    candidates: NDArray[np.bool_]  # (n,) whether FindCollisionCandidates names the pair
    collides: bool  # HasCollisions of all


def _taken(body: Body) -> Body:
    """Return the body with the rotation nearest to its matrix, which answers are about."""
    return body.placed(body.pose.rotation().matrix(), body.p)


class PairsScene(BodyScene):
    """A scene of the shapes of n pairs; the bodies are posed as often as wanted.

    All pairs but these are filtered. What the context learns of a pair it keeps, as it does for
    whoever moves a scene. ``origins`` (n, 3) [m] is where A's are, in extended precision.
    """

    def __init__(self, pairs: Sequence[Pair]) -> None:
        super().__init__([body for pair in pairs for body in (pair.a, pair.b)])
        self.origins = np.zeros((len(pairs), 3), dtype=np.longdouble)
        declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(self.ids))
        for a, b in zip(self.ids[::2], self.ids[1::2], strict=True):
            declaration.AllowBetween(GeometrySet(a), GeometrySet(b))
        self.graph.collision_filter_manager().Apply(declaration)
        self._context = self.graph.CreateDefaultContext()
        self.query = self.asked(self._context)

    def place(self, pairs: Sequence[Pair]) -> Sequence[Pair]:
        """Pose all bodies; return the pairs as they are now, with the rotations taken."""
        self.pose(self._context, [body.pose for pair in pairs for body in (pair.a, pair.b)])
        self.origins[:] = [pair.a.p for pair in pairs]
        return [Pair(_taken(pair.a), _taken(pair.b)) for pair in pairs]

    def replies(self, rng: np.random.Generator) -> Replies:
        """Return all answers about the pairs; the levels are asked for in any order."""
        levels, depths = {}, {}
        for level in rng.permutation(ACCURACY_LEVELS).tolist():
            levels[level] = distances(
                self.query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            )
            depths[level] = self._depths(self.query.ComputePointPairPenetration(accuracy=level))
        fresh = copy.copy(self.query).ComputeSignedDistancePairwiseClosestPoints()
        candidates = np.isin(self._firsts(), self.query.collision_candidates()[:, 0])
        collides = bool(self.query.HasCollisions())
        return Replies(levels, distances(fresh), depths, candidates, collides)

    def hinted(self, hints: Floats) -> Distances:
        """Return exact answers that started from hints (n, 3), which may be bad."""
        answers = [
            distances(self.query.signed_distance_of_pair(a, b, hint=hint))
            for a, b, hint in zip(self.ids[::2], self.ids[1::2], hints, strict=True)
        ]
        return Distances(*map(np.concatenate, zip(*answers, strict=True)))

    def to_points(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the distances (n,) [m] of points (n, 3), one a pair, from A, and their bounds."""
        found = self.query.ComputeSignedDistanceToPoint(points)
        rows = np.arange(len(points)) * (len(self.ids) + 2)
        return found.distance[rows].copy(), found.error_bound[rows].copy()

    def _firsts(self) -> NDArray[np.int64]:
        """Return the id values (n,) of the A's, which ascend."""
        return np.array([id.get_value() for id in self.ids[::2]])

    def _depths(self, found: PenetrationResults) -> Depths:
        firsts = self._firsts()
        rows = np.searchsorted(firsts, found.id_A)
        out = Depths(*np.full((2, len(firsts)), np.nan))
        out.depth[rows], out.error_bound[rows] = found.depth, found.error_bound
        return out


def distances(found: SignedDistanceResults) -> Distances:
    """Return results as arrays of their own."""
    return Distances(
        *(
            np.array(column)
            for column in (
                *(found.distance, found.error_bound, found.promised_error_bound),
                *(found.nhat_BA_W, found.p_WCa, found.p_WCb, found.p_ACa, found.p_BCb),
                *(found.is_nhat_BA_W_unique, found.method == METHODS['bound_only']),
            )
        )
    )
