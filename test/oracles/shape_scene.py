"""Scenes of a few public shapes, for tests that ask about them."""

from types import SimpleNamespace as Plain

from drake_geom_ros.evidence.asking import BodyScene
from drake_geom_ros.geometry import ProximityProperties
from drake_geom_ros.math import RigidTransform


class ShapeScene(BodyScene):
    """Shapes, each on a frame of its own but the anchored ones, with a context and its query.

    ``anchored`` holds a shape and X_WG each; meshes are solids where ``solid`` is given.
    """

    def __init__(self, *shapes, anchored=(), solid=None):
        properties = ProximityProperties()
        if solid is not None:
            properties.AddProperty('mesh', 'solid', solid)
        bodies = [(shape, RigidTransform()) for shape in shapes]
        moving, standing = (
            [Plain(shape=shape, pose=X_WG, properties=properties) for shape, X_WG in some]
            for some in (bodies, anchored)
        )
        super().__init__(moving, standing)
        self.context = self.graph.CreateDefaultContext()
        self.query = self.asked(self.context)

    def posed(self, *poses):
        """Pose the frames, each by a position or a RigidTransform, and return the scene."""
        poses = [p if isinstance(p, RigidTransform) else RigidTransform(p) for p in poses]
        self.pose(self.context, poses)
        return self

    def pair(self, *poses, accuracy='exact'):
        """Return the distance of the two shapes that there are, at poses."""
        query = self.posed(*poses).query
        return query.ComputeSignedDistancePairClosestPoints(*self.ids, accuracy=accuracy)
