"""Who is asked, and how: bodies in a scene of ours, by every query that there is, and peers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.geometry import ACCURACY_LEVELS as LEVELS
from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    PenetrationResults,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform
from truth.judging import laws
from truth.peers import PENETRATION, SIGNED_DISTANCE, PairAnswer, installed, load

OURS = 'ours'
POINTS = 'points'
QUERIES = (SIGNED_DISTANCE, PENETRATION, POINTS)


class BodyScene:
    """A scene graph with a frame for each body, but for those that are anchored in World.

    ``frames`` are those of the bodies that move, ``ids`` the geometries of all: first those that
    move, then the anchored ones.
    """

    def __init__(self, bodies: Sequence[Body], anchored: Sequence[Body] = ()) -> None:
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('evidence')
        self.frames: list[FrameId] = []
        self.ids: list[GeometryId] = []
        self._bodies = bodies
        for body in bodies:
            self._add(body)
        for body in anchored:
            self._register(self.graph.world_frame_id(), body, body.pose)

    def _add(self, body: Body, X_FG: RigidTransform | None = None) -> None:
        """Register a body with a frame of its own, at its origin unless it is told."""
        frame = GeometryFrame(f'body {len(self.frames)}')
        self.frames.append(self.graph.RegisterFrame(self.source, frame))
        self._register(self.frames[-1], body, X_FG or RigidTransform())

    def _register(self, frame: FrameId, body: Body, X_FG: RigidTransform) -> None:
        instance = GeometryInstance(X_FG, body.shape, f'geometry {len(self.ids)}')
        instance.set_proximity_properties(body.properties)
        self.ids.append(self.graph.RegisterGeometry(self.source, frame, instance))

    def new_context(self) -> SceneGraphContext:
        """Return a context that has no earlier answers, with the bodies at their poses."""
        context = self.graph.CreateDefaultContext()
        self.pose(context, [body.pose for body in self._bodies])
        return context

    def pose(self, context: SceneGraphContext, X_WFs: Sequence[RigidTransform]) -> None:
        """Pose all bodies that move."""
        poses = FramePoseVector(dict(zip(self.frames, X_WFs, strict=True)))
        self.graph.get_source_pose_port(self.source).FixValue(context, poses)

    def asked(self, context: SceneGraphContext | None = None) -> QueryObject:
        """Return the query object of a context, of a new one unless it is given."""
        return self.graph.get_query_output_port().Eval(context or self.new_context())


class PairScene(BodyScene):
    """A scene of A and B with a context of its own."""

    def __init__(self, a: Body, b: Body) -> None:
        super().__init__((a, b))
        self._context = self.new_context()
        self.query = self.asked(self._context)

    def place(self, a: Body, b: Body) -> None:
        """Pose the shapes as two bodies are."""
        self.pose(self._context, (a.pose, b.pose))

    def distance(self, accuracy: str = 'exact') -> SignedDistanceResults:
        """Return the pair's signed distance, asked for by name."""
        return self.query.signed_distance_of_pair(*self.ids, accuracy=accuracy)

    def pairwise(self, max_distance: float) -> SignedDistanceResults:
        """Return the pairs no farther apart than a distance: this one, or none."""
        return self.query.ComputeSignedDistancePairwiseClosestPoints(max_distance)

    def penetration(self) -> PenetrationResults:
        """Return the pair if it overlaps."""
        return self.query.ComputePointPairPenetration()

    def collides(self) -> bool:
        """Return whether the pair overlaps."""
        return bool(self.query.HasCollisions())


def names() -> tuple[str, ...]:
    """Return this project's name and those of the installed peers."""
    return (OURS, *installed())


def asking(name: str, query: str) -> Callable[[Pair], PairAnswer | None]:
    """Return what asks one of them a query about a pair; a peer is imported here."""
    if name == OURS:
        return lambda pair: ask_ours(pair, query)
    peer = load(name)
    return lambda pair: peer.pair(query, pair.a.shape, pair.b.shape)(pair.a.pose, pair.b.pose)


def ask_ours(pair: Pair, query: str) -> PairAnswer | None:
    """Return our answer in the form of a peer's."""
    scene = PairScene(pair.a, pair.b)
    if query == SIGNED_DISTANCE:
        row = scene.distance()
        return PairAnswer(float(row.distance[0]), row.nhat_BA_W[0], row.p_WCa[0], row.p_WCb[0])
    found = scene.penetration()
    if not len(found):
        return None
    return PairAnswer(-float(found.depth[0]), found.nhat_BA_W[0], found.p_WCa[0], found.p_WCb[0])


class Certified(NamedTuple):
    """A signed distance and its certificate [m], and whether that is wider than promised."""

    distance: float
    error_bound: float
    is_wide: bool


def certified(pair: Pair, query: str, levels: Sequence[str] = LEVELS) -> list[Certified | None]:
    """Return our answer at each level, of a new scene; None: no penetration is reported."""
    scene = BodyScene((pair.b,) if query == POINTS else (pair.a, pair.b))
    return [_certified(scene.asked(), pair, query, level) for level in levels]


def _certified(asked: QueryObject, pair: Pair, query: str, level: str) -> Certified | None:
    if query == POINTS:
        found = asked.ComputeSignedDistanceToPoint(pair.a.p, accuracy=level)
        distance, bound = float(found.distance[0]), float(found.error_bound[0])
        return Certified(distance, bound, laws.is_wide_to_a_point(bound, pair.b))
    found, distances = asked_for(asked, query, level)
    return rows(found, distances)[0] if len(found) else None


def asked_for(asked: QueryObject, query: str, level: str, most: float = np.inf) -> tuple[Any, Any]:
    """Return what a query of pairs finds, and the signed distances (k,) [m]."""
    if query == PENETRATION:
        overlaps = asked.ComputePointPairPenetration(accuracy=level)
        return overlaps, -overlaps.depth
    pairs = asked.ComputeSignedDistancePairwiseClosestPoints(most, accuracy=level)
    return pairs, pairs.distance


def rows(found: Any, distances: Any) -> list[Certified]:
    """Return the answers of a query of pairs."""
    columns = distances, found.error_bound, found.breaks_promise()
    return [Certified(*row) for row in zip(*(x.tolist() for x in columns), strict=True)]
