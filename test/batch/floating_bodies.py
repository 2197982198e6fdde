"""Bodies that float, each on a frame of its own, and random states of them."""

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform


class Floating:
    """A scene of bodies, meshes as solids, and the ids of their frames."""

    def __init__(self, shapes):
        properties = ProximityProperties()
        properties.AddProperty('mesh', 'solid', True)
        self.graph, self.ids = SceneGraph(), []
        source = self.graph.RegisterSource('floating')
        for k, shape in enumerate(shapes):
            frame = self.graph.RegisterFrame(source, GeometryFrame(f'f{k}'))
            body = GeometryInstance(RigidTransform(), shape, 'body')
            body.set_proximity_properties(properties)
            self.graph.RegisterGeometry(source, frame, body)
            self.ids.append(frame)

    @classmethod
    def random(cls, rng, count):
        """Return some bodies of random kinds and sizes; the first of five is a half space."""
        kinds = (
            lambda: Sphere(rng.uniform(0.05, 0.5)),
            lambda: Box(*rng.uniform(0.05, 1.0, 3)),
            lambda: Capsule(rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.5)),
            lambda: Cylinder(rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.5)),
            lambda: Ellipsoid(*rng.uniform(0.05, 0.5, 3)),
        )
        shapes = [kinds[rng.integers(len(kinds))]() for _ in range(count)]
        if rng.integers(5) == 0:
            shapes[0] = HalfSpace()
        return cls(shapes)

    def states(self, rng, count, spread):
        """Return random poses (count, n, 7), within ``spread`` [m] of the origin."""
        poses = rng.normal(size=(count, len(self.ids), 7))
        poses[..., :3] = rng.uniform(-spread, spread, poses[..., :3].shape)
        poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
        return poses
