"""Our answers to samples, each from a scene that was never asked before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from drake_geom_ros import geometry
from drake_geom_ros.evidence.accuracy.cases import PENETRATION, POINTS
from drake_geom_ros.evidence.accuracy.samples import Sample
from drake_geom_ros.evidence.accuracy.solids import Solid
from drake_geom_ros.evidence.truth.supports import Floats
from drake_geom_ros.math import RigidTransform, RotationMatrix

LEVELS = geometry.ACCURACY_LEVELS


class Answer(NamedTuple):
    """A signed distance and its certificate [m]; ``method`` as in ``geometry.METHODS``."""

    distance: float
    error_bound: float
    method: int

    @property
    def promised(self) -> bool:
        """Whether the bound is to be as narrow as the level says: in solids it may stay open."""
        return self.method != geometry.METHODS['mesh'] or self.distance >= 0.0


class Build:
    """A scene graph with a frame for each solid, but for those that are anchored."""

    def __init__(self) -> None:
        self.graph = geometry.SceneGraph()
        self.source = self.graph.RegisterSource('accuracy')
        self.frames: list[geometry.FrameId] = []
        self.ids: list[geometry.GeometryId] = []

    def add(self, solid: Solid, anchored: bool = False) -> None:
        """Register a solid on a frame of its own, or at the world's origin."""
        name = str(len(self.ids))
        instance = geometry.GeometryInstance(RigidTransform(), solid.shape, name)
        instance.set_proximity_properties(solid.properties())
        frame = self.graph.world_frame_id()
        if not anchored:
            frame = self.graph.RegisterFrame(self.source, geometry.GeometryFrame(name))
            self.frames.append(frame)
        self.ids.append(self.graph.RegisterGeometry(self.source, frame, instance))

    def asked(self, poses: Sequence[tuple[Floats, Floats]]) -> geometry.QueryObject:
        """Return a query object that has no earlier answers, with frames at poses (R, p)."""
        context = self.graph.CreateDefaultContext()
        values = {
            frame: RigidTransform(RotationMatrix(R), p)
            for frame, (R, p) in zip(self.frames, poses, strict=True)
        }
        port = self.graph.get_source_pose_port(self.source)
        port.FixValue(context, geometry.FramePoseVector(values))
        return self.graph.get_query_output_port().Eval(context)


def answers(sample: Sample, query: str, levels: Sequence[str] = LEVELS) -> list[Answer | None]:
    """Return our answer at each level; None where a penetration is not reported."""
    build = Build()
    bodies = [(sample.a, sample.X_WA), (sample.b, sample.X_WB)][query == POINTS :]
    for solid, _ in bodies:
        build.add(solid)
    poses = [pose for _, pose in bodies]
    return [_answer(build.asked(poses), sample, query, level) for level in levels]


def _answer(asked: geometry.QueryObject, sample: Sample, query: str, level: str) -> Answer | None:
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
