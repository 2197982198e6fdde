"""Half spaces, and other bodies, on a frame each, posed by rotation matrices."""

import numpy as np

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix

UPRIGHT, OVERTURNED = np.eye(3), np.diag([1.0, -1.0, -1.0])


class Planes:
    """Bodies on a frame each, posed by rotations and positions."""

    def __init__(self, poses, shapes=(), padding=0.0, order=None):
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('source')
        shapes = [*shapes, *[HalfSpace()] * (len(poses) - len(shapes))]
        self.frames, self.ids = {}, {}
        for k in order or range(len(poses)):
            properties = ProximityProperties()
            if padding:
                properties.AddProperty('proximity', 'padding', padding)
            body = GeometryInstance(RigidTransform(), shapes[k], f'body{k}')
            body.set_proximity_properties(properties)
            self.frames[k] = self.graph.RegisterFrame(source, GeometryFrame(f'frame{k}'))
            self.ids[k] = self.graph.RegisterGeometry(source, self.frames[k], body)
        self.context = self.graph.CreateDefaultContext()
        self.pose(poses)
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def pose(self, poses):
        there = {k: X for k, X in enumerate(poses) if X is not None}
        vector = {
            self.frames[k]: RigidTransform(RotationMatrix(R), p) for k, (R, p) in there.items()
        }
        self.context.UpdateFramePoses(FramePoseVector(vector))

    def pair(self, a=0, b=1):
        return tuple(sorted((self.ids[a], self.ids[b])))
