"""What is carried over from cycle to cycle changes no answer: a fresh engine agrees, always."""

import copy
import math

import numpy as np
import pytest
from numba import config

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Convex,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from truth.bodies.random_bodies import random_directions

BODIES = 24
CYCLES = 12 if config.DISABLE_JIT else 400
REACH = 0.1  # [m]


def random_shape(rng, mesh):
    """Return a shape of about 0.1 m."""
    a, b, c = rng.uniform(0.04, 0.15, 3)
    return [
        Sphere(a),
        Box(a, b, c),
        Capsule(a / 2, b),
        Cylinder(a, b),
        Ellipsoid(a, b, c),
        Convex(mesh),
    ][rng.integers(6)]


class Life:
    """A scene to which random things happen."""

    def __init__(self, seed, mesh):
        self.rng = np.random.default_rng(seed)
        self.mesh = mesh
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('life')
        self.add(self.graph.world_frame_id(), HalfSpace(), RigidTransform([0, 0, -0.3]))
        for _ in range(8):
            self.add(self.graph.world_frame_id(), random_shape(self.rng, mesh), self.random_pose())
        frames = [
            self.graph.RegisterFrame(self.source, GeometryFrame(f'frame {k}'))
            for k in range(BODIES)
        ]
        # A chain of three, to see that what hangs on a moving frame moves.
        for k in range(2):
            frames.append(
                self.graph.RegisterFrame(self.source, frames[-1], GeometryFrame(f'child {k}'))
            )
        for frame in frames:
            self.add(frame, random_shape(self.rng, mesh), RigidTransform([0, 0, 0.02]))
        self.frames = frames
        self.context = self.graph.CreateDefaultContext()
        self.query = self.graph.get_query_output_port().Eval(self.context)
        self.X_PFs = {frame: self.random_pose() for frame in frames}
        self.transient = []
        self.pose()

    def random_pose(self):
        return RigidTransform(
            RollPitchYaw(*self.rng.uniform(-3, 3, 3)), self.rng.uniform(-0.35, 0.35, 3)
        )

    def add(self, frame, shape, X_FG, context=None):
        instance = GeometryInstance(X_FG, shape, f'geometry {self.rng.integers(10**12)}')
        instance.set_proximity_properties(ProximityProperties())
        where = () if context is None else (context,)
        return self.graph.RegisterGeometry(*where, self.source, frame, instance)

    def pose(self):
        self.context.UpdateFramePoses(FramePoseVector(self.X_PFs))

    def moving_geometries(self):
        inspector = self.query.inspector()
        return [
            g
            for g in inspector.GetAllGeometryIds()
            if inspector.GetFrameId(g) != inspector.world_frame_id()
        ]

    # What can happen.

    def creep(self):
        for frame in self.rng.choice(self.frames, 5, replace=False):
            step = RigidTransform(
                RollPitchYaw(*self.rng.normal(0, 0.01, 3)), self.rng.normal(0, 0.001, 3)
            )
            self.X_PFs[frame] = self.X_PFs[frame] @ step
        self.pose()

    def stride(self):
        for frame in self.frames:
            step = RigidTransform(
                RollPitchYaw(*self.rng.normal(0, 0.1, 3)), self.rng.normal(0, 0.02, 3)
            )
            self.X_PFs[frame] = self.X_PFs[frame] @ step
        self.pose()

    def rest(self):
        pass

    def teleport(self):
        for frame in self.rng.choice(self.frames, 2, replace=False):
            self.X_PFs[frame] = self.random_pose()
        self.pose()

    def far_and_back(self):
        frame = self.frames[self.rng.integers(len(self.frames))]
        X = self.X_PFs[frame]
        self.X_PFs[frame] = RigidTransform(X.rotation(), [1e6, 0, 0])
        self.pose()
        self.query.ComputePointPairPenetration()
        self.X_PFs[frame] = X
        self.pose()

    def filter(self):
        some = self.rng.choice(self.moving_geometries(), 4, replace=False)
        manager = self.graph.collision_filter_manager(self.context)
        declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(list(some)))
        if self.transient and self.rng.random() < 0.5:
            manager.RemoveDeclaration(self.transient.pop())
        else:
            self.transient.append(manager.ApplyTransient(declaration))

    def reshape(self):
        g = self.moving_geometries()[self.rng.integers(5)]
        self.graph.ChangeShape(self.context, self.source, g, random_shape(self.rng, self.mesh))

    def replace(self):
        g = self.moving_geometries()[self.rng.integers(5)]
        frame = self.query.inspector().GetFrameId(g)
        self.graph.RemoveGeometry(self.context, self.source, g)
        self.add(frame, random_shape(self.rng, self.mesh), RigidTransform(), self.context)

    def anything(self):
        ways = [self.creep, self.stride, self.rest, self.teleport, self.far_and_back]
        ways += [self.filter, self.reshape, self.replace]
        chances = np.array([50, 10, 10, 8, 2, 3, 1, 1], dtype=float)
        ways[self.rng.choice(len(ways), p=chances / chances.sum())]()


def by_pair(results):
    pairs = zip(results.id_A.tolist(), results.id_B.tolist(), strict=True)
    return dict(zip(pairs, results, strict=True))


def assert_same_distances(carried, fresh, reach):
    """The same pairs, but those at the edge of reach, and each within both certified bounds."""
    ours, theirs = by_pair(carried), by_pair(fresh)
    for pair in ours.keys() ^ theirs.keys():
        answer = ours.get(pair) or theirs[pair]
        assert reach - answer.distance <= 3 * answer.error_bound, pair
    for pair in ours.keys() & theirs.keys():
        a, b = ours[pair], theirs[pair]
        assert abs(a.distance - b.distance) <= a.error_bound + b.error_bound, pair
        assert a.error_bound <= 1e-8
        np.testing.assert_allclose(np.linalg.norm(a.nhat_BA_W), 1.0, rtol=0, atol=1e-12)
    assert list(ours) == sorted(ours)


@pytest.fixture(scope='module')
def mesh(tmp_path_factory):
    """Return an OBJ file of a small polyhedron."""
    vertices = 0.08 * random_directions(np.random.default_rng(0), 24)
    path = tmp_path_factory.mktemp('mesh') / 'body.obj'
    faces = '\n'.join(f'f {k} {k + 1} {k + 2}' for k in range(1, 23))
    path.write_text('\n'.join(f'v {x} {y} {z}' for x, y, z in vertices) + '\n' + faces + '\n')
    return str(path)


@pytest.mark.parametrize('seed', range(6))
def test_a_fresh_engine_agrees_after_whatever_happened(seed, mesh):
    life = Life(seed, mesh)
    made, cached, far = 0, 0, 0
    for cycle in range(CYCLES):
        life.anything()
        fresh = copy.copy(life.query)
        near = life.query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        effects = life.query.effects()
        made += effects.near_list_made
        cached += effects.cached_pairs
        far += effects.far_pairs
        again = fresh.ComputeSignedDistancePairwiseClosestPoints(REACH)
        assert_same_distances(near, again, REACH)
        if cycle % 3 == 0:
            overlapping = life.query.ComputePointPairPenetration()
            expected = fresh.ComputePointPairPenetration()
            for pair in by_pair(overlapping).keys() ^ by_pair(expected).keys():
                depth = (by_pair(overlapping).get(pair) or by_pair(expected)[pair]).depth
                assert depth <= 1e-8
            assert life.query.HasCollisions() == bool(len(overlapping))
            assert life.query.FindCollisionCandidates() == fresh.FindCollisionCandidates()
        if cycle % 40 == 0:
            everything = life.query.ComputeSignedDistancePairwiseClosestPoints()
            expected = fresh.ComputeSignedDistancePairwiseClosestPoints()
            assert_same_distances(everything, expected, math.inf)
    # It was a test of something.
    assert CYCLES / 20 < made <= CYCLES
    assert cached > CYCLES
    assert far > CYCLES
