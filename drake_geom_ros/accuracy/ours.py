"""Our answers to samples, and the time of scenes that hold many of them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros import geometry
from drake_geom_ros.accuracy.cases import PENETRATION, POINTS
from drake_geom_ros.accuracy.samples import Sample
from drake_geom_ros.accuracy.solids import Solid
from drake_geom_ros.accuracy.supports import Floats
from drake_geom_ros.math import RigidTransform, RotationMatrix

SPACING = 4.0  # [m] between the pairs of a timed scene: none of them meets its neighbours
FARTHEST = 0.5  # [m] the distance up to which pairs are asked for there


class Answer(NamedTuple):
    """A signed distance and its certificate [m]; ``method`` as in ``geometry.METHODS``."""

    distance: float
    error_bound: float
    method: int


class Build:
    """A scene graph with one frame for each solid but the anchored ones."""

    def __init__(self) -> None:
        self.graph = geometry.SceneGraph()
        self.source = self.graph.RegisterSource('accuracy')
        self.frames: list[geometry.FrameId] = []
        self.ids: list[geometry.GeometryId] = []

    def add(self, solid: Solid, anchored: bool = False) -> geometry.GeometryId:
        """Register a solid on a frame of its own, or at the world's origin."""
        name = f'{len(self.ids)}'
        instance = geometry.GeometryInstance(RigidTransform(), solid.shape(), name)
        instance.set_proximity_properties(geometry.ProximityProperties())
        frame = self.graph.world_frame_id()
        if not anchored:
            frame = self.graph.RegisterFrame(self.source, geometry.GeometryFrame(name))
            self.frames.append(frame)
        self.ids.append(self.graph.RegisterGeometry(self.source, frame, instance))
        return self.ids[-1]

    def context(self, poses: Sequence[tuple[Floats, Floats]]) -> geometry.QueryObject:
        """Return a query object that knows nothing of earlier answers, at poses (R, p)."""
        context = self.graph.CreateDefaultContext()
        self.pose(context, poses)
        query: geometry.QueryObject = self.graph.get_query_output_port().Eval(context)
        return query

    def pose(self, context: geometry.SceneGraphContext, poses: object) -> None:
        """Set the poses (R, p) of all frames."""
        values = {
            frame: RigidTransform(RotationMatrix(R), p)
            for frame, (R, p) in zip(self.frames, poses, strict=True)  # type: ignore[call-overload]
        }
        port = self.graph.get_source_pose_port(self.source)
        port.FixValue(context, geometry.FramePoseVector(values))


def answers(sample: Sample, query: str, levels: Sequence[str]) -> list[Answer | None]:
    """Return our answer at each level, each from a scene that was never asked before.

    None where a penetration is not reported.
    """
    build = Build()
    solids = [sample.b] if query == POINTS else [sample.a, sample.b]
    for solid in solids:
        build.add(solid)
    poses = [sample.X_WB] if query == POINTS else [sample.X_WA, sample.X_WB]
    return [_asked(build.context(poses), sample, query, level) for level in levels]


def _asked(asked: geometry.QueryObject, sample: Sample, query: str, level: str) -> Answer | None:
    if query == POINTS:
        found = asked.ComputeSignedDistanceToPoint(sample.X_WA[1], accuracy=level)
        return Answer(found.distance[0], found.error_bound[0], int(found.method[0]))
    if query == PENETRATION:
        overlaps = asked.ComputePointPairPenetration(accuracy=level)
        if not len(overlaps):
            return None
        return Answer(-overlaps.depth[0], overlaps.error_bound[0], int(overlaps.method[0]))
    pairs = asked.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
    return Answer(pairs.distance[0], pairs.error_bound[0], int(pairs.method[0]))


class TimedPairs:
    """Samples of one case side by side in one scene, far from each other.

    Every cycle turns each pair anew, so that no answer and no hint of the last one helps. Half
    spaces would meet all neighbours: there is one for all of them, and pairs turn about its
    normal only.
    """

    def __init__(self, pairs: Sequence[Sample], query: str, level: str) -> None:
        self._query, self._level = query, level
        self._build = Build()
        self._points = query == POINTS
        flat = {'HalfSpace'} & {pairs[0].a.kind, pairs[0].b.kind}
        self._yaw_only = bool(flat)
        poses = []
        if flat:
            self._build.add(Solid('HalfSpace'), anchored=True)
        for sample in pairs:
            base = sample.X_WB if sample.b.kind == 'HalfSpace' else sample.X_WA
            if flat and sample.a.kind == 'HalfSpace':
                base = sample.X_WA
            for solid, X in ((sample.a, sample.X_WA), (sample.b, sample.X_WB)):
                if solid.kind == 'HalfSpace':
                    continue
                if solid.kind != 'Point':
                    self._build.add(solid)
                poses.append(_within(base if flat else (np.eye(3), sample.X_WA[1]), X))
        self._Rs = np.array([R for R, _ in poses])
        self._ps = np.array([p for _, p in poses])
        self._each = len(poses) // len(pairs)
        self._cells = np.repeat(_cells(len(pairs), bool(flat)), self._each, axis=0)
        self._is_point = np.array(
            [s.kind == 'Point' for p in pairs for s in (p.a, p.b) if s.kind != 'HalfSpace']
        )
        self._count = len(pairs)
        self._ids = np.array([frame.get_value() for frame in self._build.frames])
        self._context = self._build.graph.CreateDefaultContext()
        self._port = self._build.graph.get_source_pose_port(self._build.source)
        self._asked = self._build.graph.get_query_output_port().Eval(self._context)

    def cycle(self, rng: np.random.Generator) -> tuple[float, float]:
        """Pose, ask, and return the seconds a pair: all of the query, and its kernels alone."""
        angles = rng.uniform(-np.pi, np.pi, (self._count, 3))
        if self._yaw_only:
            angles[:, :2] = 0.0
        turns = np.repeat(Rotation.from_euler('xyz', angles).as_matrix(), self._each, axis=0)
        ps = self._cells + np.einsum('kij,kj->ki', turns, self._ps)
        quaternions = Rotation.from_matrix(turns @ self._Rs).as_quat()
        poses = np.hstack([ps, quaternions])[~self._is_point]
        points = ps[self._is_point]
        start = time.perf_counter()
        self._port.FixValue(self._context, geometry.FramePoseVector.FromArrays(self._ids, poses))
        self._ask(points)
        taken = time.perf_counter() - start
        kernels = self._asked.effects().seconds['narrowphase']
        return taken / self._count, kernels / self._count

    def _ask(self, points: Floats) -> int:
        """Ask, and read the arrays of the answer."""
        if self._points:
            found = self._asked.ComputeSignedDistanceToPoint(
                points, FARTHEST, accuracy=self._level
            )
            return len(found.distance) + len(found.grad_W)
        if self._query == PENETRATION:
            overlaps = self._asked.ComputePointPairPenetration(accuracy=self._level)
            return len(overlaps.depth) + len(overlaps.nhat_BA_W)
        pairs = self._asked.ComputeSignedDistancePairwiseClosestPoints(
            FARTHEST, accuracy=self._level
        )
        return len(pairs.distance) + len(pairs.nhat_BA_W)


def _within(X_WF: tuple[Floats, Floats], X_WG: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return X_FG."""
    (R_WF, p_WF), (R_WG, p_WG) = X_WF, X_WG
    return R_WF.T @ R_WG, R_WF.T @ (p_WG - p_WF)


def _cells(count: int, flat: bool) -> Floats:
    """Return places (count, 3) [m] of a cubic, or flat, lattice about the origin."""
    dimensions = 2 if flat else 3
    side = int(np.ceil(count ** (1 / dimensions) - 1e-9))
    grid = np.indices((side,) * dimensions).reshape(dimensions, -1).T[:count] - (side - 1) / 2
    cells: Floats = SPACING * np.pad(grid, ((0, 0), (0, 3 - dimensions)))
    return cells
