"""Many states of hulls, solids and a half space; what a packed scene is, and what it is called."""

import pickle

import numpy as np
import pytest
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    Box,
    Convex,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    Mesh,
    PoseError,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.state_queries import StateError, StateQueries
from drake_geom_ros.math import RigidTransform

GO_ON = np.zeros(1, dtype=np.int64)
SHAPES = (
    HalfSpace(),
    Box(1.0, 0.6, 0.8),
    Ellipsoid(0.5, 0.8, 0.3),
    Convex.FromMeshData(surface_of('L')),
    Mesh.FromMeshData(surface_of('L')),
    Mesh.FromMeshData(surface_of('ring')),
)


class Bodies:
    """Shapes on a frame each, meshes as solids, and random states in which some overlap."""

    def __init__(self, count):
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('s')
        self.ids = []
        for k, shape in enumerate(SHAPES):
            frame = self.graph.RegisterFrame(source, GeometryFrame(f'f{k}'))
            instance = GeometryInstance(RigidTransform(), shape, 'g')
            properties = ProximityProperties()
            properties.AddProperty('mesh', 'solid', True)
            instance.set_proximity_properties(properties)
            self.graph.RegisterGeometry(source, frame, instance)
            self.ids.append(frame.get_value())
        rng = np.random.default_rng(4)
        self.poses = rng.normal(size=(count, len(SHAPES), 7))
        self.poses[:, :, :3] *= 2.0
        self.poses[:, 0, :3] -= [0.0, 0.0, 4.0]
        self.poses[:, :, 3:] /= np.linalg.norm(self.poses[:, :, 3:], axis=2, keepdims=True)

    def packed(self):
        return PackedScene.of(self.graph.CreateDefaultContext(), np.array(self.ids))

    def fresh(self, poses):
        context = self.graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(np.array(self.ids), poses))
        return self.graph.get_query_output_port().Eval(context)


@pytest.fixture(scope='module')
def bodies():
    return Bodies(40)


@pytest.mark.parametrize('accuracy', ['bound', 'fast', 'exact'])
def test_hulls_and_solids_keep_the_law_too(bodies, accuracy):
    scene, ids = bodies.packed()
    queries, poses = StateQueries(scene), bodies.poses
    counts, within = queries.within(poses, accuracy, 0.3, GO_ON)
    _, nearest = queries.nearest(poses, accuracy, np.inf, 1, GO_ON)
    collide = queries.has_collisions(poses, accuracy, GO_ON)
    near = queries.has_collisions(poses, accuracy, GO_ON, 0.1)
    offsets = np.concatenate(([0], np.cumsum(counts)))
    for k, pose in enumerate(poses):
        some = slice(*offsets[k : k + 2])
        expected = bodies.fresh(pose).ComputeSignedDistancePairwiseClosestPoints(
            0.3, accuracy=accuracy
        )
        every = bodies.fresh(pose).ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
        first = np.argmin(every.distance - every.error_bound)
        for name in ('distance', 'error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb', 'method'):
            np.testing.assert_array_equal(getattr(within, name)[some], getattr(expected, name))
            np.testing.assert_array_equal(getattr(nearest, name)[k], getattr(every, name)[first])
        np.testing.assert_array_equal(ids[within.id_A[some]], expected.id_A)
        assert ids[nearest.id_B[k]] == every.id_B[first]
        assert collide[k] == bodies.fresh(pose).HasCollisions(accuracy=accuracy)
        assert near[k] == (every.distance - every.error_bound <= 0.1).any()
    assert (nearest.distance < 0.0).any()


def test_a_digest_names_the_content_and_no_ids(bodies):
    scene, _ = bodies.packed()
    again = pickle.loads(pickle.dumps(scene))
    assert again.digest == scene.digest == Bodies(1).packed()[0].digest
    other = Bodies(1)
    other.graph.ChangeShape(
        other.graph.model_inspector().GetAllSourceIds()[-1],
        other.graph.model_inspector().GetAllGeometryIds()[1],
        Box(1.0, 0.6, 0.81),
    )
    assert other.packed()[0].digest != scene.digest


def test_a_stop_ends_a_call(bodies):
    queries = StateQueries(bodies.packed()[0])
    with pytest.raises(InterruptedError, match='after 0 of 40'):
        queries.within(bodies.poses, 'bound', 0.3, np.ones(1, dtype=np.int64))


def test_a_state_that_is_none_is_told_by_its_number(bodies):
    poses = bodies.poses.copy()
    poses[7, 2, 1] = np.inf
    with pytest.raises(StateError, match='all finite') as caught:
        StateQueries(bodies.packed()[0]).has_collisions(poses, 'bound', GO_ON)
    assert caught.value.number == 7
    assert isinstance(caught.value, PoseError)
