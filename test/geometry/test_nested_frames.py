"""Chains of frames against their exact composition: what rounding costs is in the error bound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.poses import box_distance, composed, length, vector
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

RADIUS = 0.25
HALF = np.array([0.3, 0.2, 0.1])
PROBE = Sphere(RADIUS)
LEVELS = ('bound', 'fast', 'exact')


class Chain:
    """A ball at the end of a chain of frames, and another shape that is anchored at ``p_WB``."""

    def __init__(self, poses, shape, p_WB, X_FG=None):
        self.scene = scene = SceneGraph()
        source, frames = scene.RegisterSource('chain'), []
        for k in range(len(poses)):
            parent = frames[-1] if frames else scene.world_frame_id()
            frames.append(scene.RegisterFrame(source, parent, GeometryFrame(f'f{k}')))
        self.body = instance('body', shape)
        self.body.set_pose(RigidTransform() if X_FG is None else RigidTransform.FromArray(X_FG))
        self.body = scene.RegisterGeometry(source, frames[-1], self.body)
        scene.RegisterAnchoredGeometry(source, instance('other', PROBE, p_WB))
        self.context = scene.CreateDefaultContext()
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(frames, np.array(poses)))
        self.query = scene.get_query_output_port().Eval(self.context)
        self.R_WG, self.p_WG = composed([*poses] if X_FG is None else [*poses, X_FG])
        self.p_WB = vector(p_WB)

    def pair(self, accuracy='exact'):
        return self.query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)[0]

    def to_point(self, p_WQ):
        found = self.query.ComputeSignedDistanceToPoint(p_WQ)
        return next(answer for answer in found if answer.id_G == self.body)

    def position(self, p_W):
        """Return a point of the world in the body's frame, exactly."""
        return self.R_WG.T * (p_W - self.p_WG)


def pose(p, q=(0, 0, 0, 1)):
    return [*p, *(np.array(q) / np.linalg.norm(q))]


def random_chain(rng, depth, link):
    return [pose(link * rng.normal(size=3), rng.normal(size=4)) for _ in range(depth)]


def cancelling(rng, link):
    """Two links that lead back to the origin, nearly."""
    first = pose(link * rng.normal(size=3), rng.normal(size=4))
    R_WF, p_WF = composed([first])
    back = np.array([float(x) for x in -(R_WF.T * p_WF)])
    return [first, pose(back, rng.normal(size=4))]


CHAINS = {
    'ten links of 10 m': lambda rng: random_chain(rng, 10, 10.0),
    'two links of 1 km that cancel': lambda rng: cancelling(rng, 1e3),
    'links of 1e7 m that cancel': lambda rng: cancelling(rng, 1e7),
    'a thousand links of 1 m': lambda rng: random_chain(rng, 1000, 1.0),
    'one frame': lambda rng: random_chain(rng, 1, 1.0),
}


# A shape, and the distance of the point ``p_WB`` from it.
SHAPES = {
    'ball': (Sphere(0.5), lambda chain: length(chain.p_WG - chain.p_WB) - 0.5),
    # Of a box the rotation counts too.
    'box': (Box(*(2 * HALF)), lambda chain: box_distance(HALF, chain.position(chain.p_WB))),
}


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('name', CHAINS)
def test_distances_hold(name, shape):
    shape, distance_of = SHAPES[shape]
    for seed in range(3 if 'thousand' in name else 12):
        rng = np.random.default_rng(seed)
        poses = CHAINS[name](rng)
        near = np.array([float(x) for x in composed(poses)[1]]) + rng.normal(size=3)
        chain = Chain(poses, shape, near)
        truth = distance_of(chain)
        for level in LEVELS:
            answer = chain.pair(level)
            assert abs(answer.distance - truth + RADIUS) <= answer.error_bound
        answer = chain.to_point(near)
        assert abs(answer.distance - truth) <= answer.error_bound


@pytest.mark.parametrize('apart', [1.0, 1e3, 1e7])
@pytest.mark.parametrize('name', CHAINS)
def test_distances_to_a_half_space_hold(name, apart):
    # It has no size: its turn counts by how far away the other body is.
    for seed in range(2 if 'thousand' in name else 8):
        rng = np.random.default_rng(seed)
        poses = CHAINS[name](rng)
        near = np.array([float(x) for x in composed(poses)[1]]) + apart * rng.normal(size=3)
        chain = Chain(poses, HalfSpace(), near)
        truth = chain.position(chain.p_WB)[2]
        for level in LEVELS:
            answer = chain.pair(level)
            assert abs(answer.distance - truth + RADIUS) <= answer.error_bound
        answer = chain.to_point(near)
        assert abs(answer.distance - truth) <= answer.error_bound


@pytest.mark.parametrize('shape', [Sphere(0.5), Box(*(2 * HALF)), HalfSpace()])
def test_a_geometry_far_from_its_frame(shape):
    for seed in range(12):
        rng = np.random.default_rng(seed)
        X_FG = pose(2.7e6 * rng.normal(size=3), rng.normal(size=4))
        _, p_FG = composed([X_FG])
        back = pose(np.zeros(3), rng.normal(size=4))
        R_WF, _ = composed([back])
        back[:3] = [float(x) for x in -(R_WF * p_FG)]
        near = rng.normal(size=3)
        chain = Chain([back], shape, near, X_FG)
        q = chain.position(chain.p_WB)
        truth = q[2] if isinstance(shape, HalfSpace) else length(q) - 0.5
        if isinstance(shape, Box):
            truth = box_distance(HALF, q)
        answer = chain.to_point(near)
        assert abs(answer.distance - truth) <= answer.error_bound
        answer = chain.pair()
        assert abs(answer.distance - truth + RADIUS) <= answer.error_bound


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    links=st.lists(st.floats(-3.0, 7.0), min_size=1, max_size=8),
    apart=st.floats(-2.0, 4.0),
    returns=st.booleans(),
    shape=st.sampled_from([Sphere(0.5), Box(*(2 * HALF)), HalfSpace()]),
)
def test_whatever_the_chain_the_bound_holds(seed, links, apart, returns, shape):
    rng = np.random.default_rng(seed)
    poses = [pose(10.0**link * rng.normal(size=3), rng.normal(size=4)) for link in links]
    if returns:
        R_WF, p_WF = composed(poses)
        poses.append(pose([float(x) for x in -(R_WF.T * p_WF)], rng.normal(size=4)))
    X_FG = pose(10.0**apart * rng.normal(size=3), rng.normal(size=4))
    end = np.array([float(x) for x in composed([*poses, X_FG])[1]])
    near = end + 10.0**apart * rng.normal(size=3)
    chain = Chain(poses, shape, near, X_FG)
    q = chain.position(chain.p_WB)
    truth = q[2] if isinstance(shape, HalfSpace) else length(q) - 0.5
    if isinstance(shape, Box):
        truth = box_distance(HALF, q)
    for level in LEVELS:
        answer = chain.pair(level)
        assert abs(answer.distance - truth + RADIUS) <= answer.error_bound
    answer = chain.to_point(near)
    assert abs(answer.distance - truth) <= answer.error_bound


def test_a_promise_is_kept_along_a_chain():
    poses = random_chain(np.random.default_rng(0), 30, 100.0)
    near = [float(x) + 1.0 for x in composed(poses)[1]]
    chain = Chain(poses, Sphere(0.5), near)
    found = chain.query.ComputeSignedDistancePairwiseClosestPoints()
    assert not found.breaks_promise().any()
    assert found.error_bound[0] > 1e-12  # more than the closed form promises near by


def test_frames_of_a_long_chain_stay_rotations():
    rng = np.random.default_rng(0)
    poses = random_chain(rng, 3000, 1.0)
    chain = Chain(poses, Sphere(0.5), [0, 0, 0])
    R = chain.query.GetPoseInWorld(chain.body).rotation().matrix()
    assert np.abs(R @ R.T - np.eye(3)).max() < 4e-15


def test_what_is_not_turned_costs_nothing():
    # Quarter turns are exact, and so are their products.
    quarter = [0, 0, 1, 1]
    ball = Chain([pose([0, 0, 0], [0, 0, 0, 1])] * 50, Sphere(0.5), [2, 0, 0]).pair()
    once = Chain([pose([0, 0, 0])], Sphere(0.5), [2, 0, 0]).pair()
    assert ball.error_bound == once.error_bound
    turned = Chain([pose([0, 0, 0], quarter)] * 4, Box(*(2 * HALF)), [2, 0, 0]).pair()
    assert turned.distance == pytest.approx(2 - 0.3 - RADIUS, abs=turned.error_bound)


def test_a_geometry_on_a_geometry_is_a_link_too():
    for seed in range(12):
        rng = np.random.default_rng(seed)
        first, second = cancelling(rng, 1e6)
        scene = SceneGraph()
        source = scene.RegisterSource('s')
        frame = scene.RegisterFrame(source, GeometryFrame('f'))
        base = scene.RegisterGeometry(
            source, frame, GeometryInstance(RigidTransform.FromArray(first), PROBE, 'base')
        )
        tip = GeometryInstance(RigidTransform.FromArray(second), Sphere(0.5), 'tip')
        tip.set_proximity_properties(ProximityProperties())
        tip = scene.RegisterGeometry(source, base, tip)
        context = scene.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector({frame: RigidTransform()}))
        query = scene.get_query_output_port().Eval(context)
        near = rng.normal(size=3)
        answer = query.ComputeSignedDistanceToPoint(near)[0]
        truth = length(composed([first, second])[1] - vector(near)) - 0.5
        assert abs(answer.distance - truth) <= answer.error_bound
