"""Many disjoint pairs in one scene, asked by every query at once."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.hard_cases.cases import Body, Case, Floats
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    METHODS,
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    PenetrationResults,
    SceneGraph,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform


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


class PairsScene:
    """A scene of the shapes of n pairs; the bodies are posed as often as wanted.

    All pairs but these are filtered. What the context learns of a pair it keeps, as it does for
    whoever moves a scene.
    """

    def __init__(self, cases: Sequence[Case]) -> None:
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('hunt')
        self.origins = np.zeros((len(cases), 3), dtype=np.longdouble)  # p_WA [m], as it truly is
        self.frames: list[FrameId] = []
        self.ids: list[GeometryId] = []
        for case in cases:
            self._add(case.a)
            self._add(case.b)
        declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(self.ids))
        for a, b in zip(self.ids[::2], self.ids[1::2], strict=True):
            declaration.AllowBetween(GeometrySet(a), GeometrySet(b))
        self.graph.collision_filter_manager().Apply(declaration)
        self._context = self.graph.CreateDefaultContext()
        self._port = self.graph.get_source_pose_port(self.source)
        self.query = self.graph.get_query_output_port().Eval(self._context)

    def _add(self, body: Body) -> None:
        name = str(len(self.ids))
        frame = self.graph.RegisterFrame(self.source, GeometryFrame(name))
        self.frames.append(frame)
        self._register(frame, body, RigidTransform())

    def _register(self, frame: FrameId, body: Body, X_FG: RigidTransform) -> None:
        instance = GeometryInstance(X_FG, body.shape, str(len(self.ids)))
        instance.set_proximity_properties(body.properties)
        self.ids.append(self.graph.RegisterGeometry(self.source, frame, instance))

    def pose(self, cases: Sequence[Case]) -> Sequence[Case]:
        """Pose all bodies; return the pairs as they are now."""
        poses = [one.pose for case in cases for one in (case.a, case.b)]
        self._fix(dict(zip(self.frames, poses, strict=True)))
        self.origins[:] = [case.a.p for case in cases]
        return cases

    def _fix(self, poses: dict[FrameId, RigidTransform]) -> None:
        self._port.FixValue(self._context, FramePoseVector(poses))

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
