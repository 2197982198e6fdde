"""Scenes of public shapes; of two that move, the derivative of their distance by differences."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    MeshData,
    ProximityProperties,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import (
    box_corners,
    random_directions,
    random_rotation,
)
from truth.judging.asking import BodyScene

HULL = Convex.FromMeshData(
    MeshData(random_directions(np.random.default_rng(5), 24) * [0.2, 0.15, 0.1], ())
)
SHAPES = {
    'sphere': Sphere(0.12),
    'box': Box(0.3, 0.2, 0.4),
    'capsule': Capsule(0.08, 0.3),
    'cylinder': Cylinder(0.1, 0.3),
    'ellipsoid': Ellipsoid(0.1, 0.15, 0.2),
    'half_space': HalfSpace(),
    'convex': HULL,
}
BLOCK = box_corners((0.2, 0.2, 0.4))
LATTICE_SHAPES = {
    'sphere': Sphere(0.1),
    'box': Box(0.2, 0.2, 0.4),
    'capsule': Capsule(0.1, 0.2),
    'cylinder': Cylinder(0.1, 0.2),
    'ellipsoid': Ellipsoid(0.1, 0.1, 0.2),
    'half_space': HalfSpace(),
    'convex': Convex.FromMeshData(MeshData(BLOCK, ())),
}
QUARTERS = Rotation.create_group('O').as_matrix()
PAIRS = [
    (a, b)
    for k, a in enumerate(SHAPES)
    for b in list(SHAPES)[k:]
    if (a, b) != ('half_space', 'half_space')
]


def moved(X, V, t):
    """Return the pose after the spatial velocity V = [w, v] for the time t, to first order."""
    R = Rotation.from_rotvec(t * np.asarray(V[:3])).as_matrix() @ X.rotation().matrix()
    return RigidTransform(RotationMatrix(R), X.translation() + t * np.asarray(V[3:]))


class _Posed(NamedTuple):
    """What a scene wants to know of a body."""

    shape: Shape
    pose: RigidTransform
    properties: ProximityProperties


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
            [_Posed(shape, X_WG, properties) for shape, X_WG in some]
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


class MovingPair(ShapeScene):
    """Shapes A and B, each off the origin of its frame."""

    def __init__(self, A, B, X_FaA=None, X_FbB=None, solid=False):
        """``solid``: a mesh counts as the body within its surface, not as its hull."""
        X_FaA = X_FaA or RigidTransform([0.1, -0.2, 0.3])
        self._X_FGs = iter((X_FaA, X_FbB or RigidTransform([0, 0.2, 0])))
        super().__init__(A, B, solid=solid or None)
        self.place(RigidTransform(), RigidTransform())

    def _add(self, body):
        super()._add(body, next(self._X_FGs))

    def place(self, X_WA, X_WB):
        """Pose both frames."""
        self.poses = X_WA, X_WB
        self.pose(self.context, self.poses)
        return self

    def ask(self, **options):
        """Return the results of the one pair."""
        return self.query.signed_distance_of_pair(*self.ids, **options)

    def bring_to(self, distance):
        """Move B along the normal until the bodies are as far apart."""
        found = self.ask()
        step = (found.distance[0] - distance) * found.nhat_BA_W[0]
        X_WA, X_WB = self.poses
        return self.place(X_WA, RigidTransform(X_WB.rotation(), X_WB.translation() + step))

    def after(self, V, t):
        """Pose both after the spatial velocities V (12,) for the time t; back by ``place``."""
        X_WA, X_WB = self.poses
        self.place(moved(X_WA, V[:6], t), moved(X_WB, V[6:], t))
        found = self.ask()
        self.place(X_WA, X_WB)
        return found

    def remainder(self, gradient, V, t):
        """Return how far a gradient (12,) is off in foretelling the distance after time t [m]."""
        now, then = self.ask().distance[0], self.after(V, t).distance[0]
        return abs(then - now - t * (gradient @ V))

    def foretells(self, gradient, V, t=1e-4):
        """Tell whether what a gradient leaves over falls with the square of the time.

        That is Taylor's test: a wrong gradient leaves over what falls with the time itself, and so
        does any where there is a kink. Distances are exact to 1e-10 m at the worst.
        """
        return all(
            self.remainder(gradient, V, 0.1 * s) <= 0.03 * self.remainder(gradient, V, s) + 1e-10
            for s in (t, -t)
        )


def random_pair(rng, names, distance):
    """Return a pair at random poses, brought to a distance."""
    pair = MovingPair(*(SHAPES[name] for name in names))
    X_WA, X_WB = (RigidTransform(RotationMatrix(random_rotation(rng)), p) for p in 2 * [[0, 0, 0]])
    direction = random_directions(rng, 1)[0]
    if 'half_space' in names:
        sign = 1.0 if names[0] == 'half_space' else -1.0
        direction = sign * (X_WA if sign > 0 else X_WB).rotation().matrix()[:, 2]
    pair.place(X_WA, RigidTransform(X_WB.rotation(), 2.0 * direction))
    # Out of an overlap bodies come by a face or by crossing edges, not by corners alone.
    return pair.bring_to(0.05).bring_to(-0.01 if distance == 0.0 else distance).bring_to(distance)


def lattice_pair(names, turns, place):
    """Return a pair of blunt shapes, turned by right angles, whose sizes are multiples of 0.1 m.

    So features lie parallel, in line and concentric. ``turns`` are two numbers below 24, and B is
    at ``place``, three whole numbers, in steps of 0.1 m from A.
    """
    pair = MovingPair(*(LATTICE_SHAPES[name] for name in names), *2 * [RigidTransform()])
    X_WA, X_WB = (RigidTransform(RotationMatrix(QUARTERS[k])) for k in turns)
    return pair.place(X_WA, RigidTransform(X_WB.rotation(), 0.1 * np.array(place)))
