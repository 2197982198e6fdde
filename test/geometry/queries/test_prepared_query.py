"""A prepared query answers as a query object does: the same bits, errors and later changes."""

import math

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    ArgumentError,
    Box,
    Capsule,
    Ellipsoid,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    PoseError,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

SHAPES = Sphere(0.1), Box(0.2, 0.1, 0.3), Capsule(0.05, 0.2), Ellipsoid(0.1, 0.05, 0.2)
ASKED = 'penetrations', 'distances', 'collision'


class Bodies:
    """A scene of moving bodies and anchored ones, and two contexts of it."""

    def __init__(self, *anchored):
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('source')
        self.frames, self.ids = [], []
        for k, shape in enumerate(SHAPES * 2):
            self.frames.append(self.graph.RegisterFrame(self.source, GeometryFrame(f'{k}')))
            self.add(self.frames[-1], shape)
        for shape in anchored:
            self.add(self.graph.world_frame_id(), shape)
        self.contexts = [self.graph.CreateDefaultContext() for _ in range(2)]

    def add(self, frame, shape, *contexts):
        instance = GeometryInstance(RigidTransform(), shape, f'body {len(self.ids)}')
        instance.set_proximity_properties(ProximityProperties())
        for context in contexts or ((),):
            on = (context,) if context else ()
            self.ids.append(self.graph.RegisterGeometry(*on, self.source, frame, instance))

    def poses(self, seed, count=None):
        rng, count = np.random.default_rng(seed), count or len(self.frames)
        quaternions = rng.normal(size=(count, 4))
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
        return np.hstack((rng.uniform(-0.25, 0.25, (count, 3)), quaternions))

    def usual(self, asked, poses, frames=None, **arguments):
        """Return the answer of the second context's query object."""
        vector = FramePoseVector.FromArrays(frames or self.frames, poses)
        self.contexts[1].UpdateFramePoses(vector)
        query = self.graph.get_query_output_port().Eval(self.contexts[1])
        names = 'ComputePointPairPenetration', 'ComputeSignedDistancePairwiseClosestPoints'
        name = dict(zip(ASKED, (*names, 'HasCollisions'), strict=True))[asked]
        return getattr(query, name)(**arguments)


def assert_same(answer, usual):
    if isinstance(usual, bool):
        assert answer is usual
        return
    for name in (
        'id_A',
        'id_B',
        'distance',
        'depth',
        'error_bound',
        'p_WCa',
        'p_WCb',
        'nhat_BA_W',
    ):
        if hasattr(usual, name):
            np.testing.assert_array_equal(getattr(answer, name), getattr(usual, name))


def arguments_of(asked, accuracy=None):
    return {'accuracy': accuracy} | ({'max_distance': 0.2} if asked == 'distances' else {})


@pytest.mark.parametrize('accuracy', [None, *ACCURACY_LEVELS])
@pytest.mark.parametrize('asked', ASKED)
@pytest.mark.parametrize('anchored', [(Box(1, 1, 0.1),), (HalfSpace(), Sphere(0.2))])
def test_answers_are_those_of_a_query_object(asked, accuracy, anchored):
    bodies = Bodies(*anchored)
    arguments = arguments_of(asked, accuracy)
    call = bodies.contexts[0].prepare(bodies.frames, asked, **arguments)
    for seed in range(20):
        poses = bodies.poses(seed)
        assert_same(call(poses), bodies.usual(asked, poses, **arguments))
        assert_same(call(poses.tolist()), bodies.usual(asked, poses, **arguments))


@pytest.mark.parametrize('asked', ASKED)
def test_frames_come_in_any_order_and_others_stay(asked):
    bodies = Bodies()
    bodies.contexts[0].UpdateFramePoses(
        FramePoseVector.FromArrays(bodies.frames, bodies.poses(100))
    )
    bodies.usual(asked, bodies.poses(100))
    frames, arguments = bodies.frames[5:2:-1], arguments_of(asked)
    call = bodies.contexts[0].prepare(frames, asked, **arguments)
    for seed in range(5):
        poses = bodies.poses(seed, 3)
        assert_same(call(poses), bodies.usual(asked, poses, frames, **arguments))


@pytest.mark.parametrize('asked', ASKED)
def test_later_changes_count(asked):
    bodies, arguments = Bodies(Box(1, 1, 0.1)), arguments_of(asked)
    call = bodies.contexts[0].prepare(bodies.frames, asked, **arguments)
    padded = ProximityProperties()
    padded.AddProperty('proximity', 'padding', 0.02)
    for seed, change in enumerate(
        (
            lambda context: None,
            lambda context: bodies.graph.ChangeShape(
                context, bodies.source, bodies.ids[0], Sphere(0.3)
            ),
            lambda context: bodies.graph.RemoveGeometry(context, bodies.source, bodies.ids[1]),
            lambda context: bodies.graph.AssignRole(
                context, bodies.source, bodies.ids[2], padded, RoleAssign.kReplace
            ),
            lambda context: bodies.graph.collision_filter_manager(context).WeldToWorld(
                bodies.frames[3:4]
            ),
        )
    ):
        for context in bodies.contexts:
            change(context)
        for step in range(3):
            poses = bodies.poses(10 * seed + step)
            assert_same(call(poses), bodies.usual(asked, poses, **arguments))


def test_answers_of_before_keep_their_poses():
    bodies = Bodies(Box(1, 1, 0.1))
    call = bodies.contexts[0].prepare(bodies.frames, 'distances')
    before = call(bodies.poses(1))
    call(bodies.poses(2))
    usual = bodies.usual('distances', bodies.poses(1))
    np.testing.assert_array_equal(before.gradients, usual.gradients)


@pytest.mark.parametrize('asked', ASKED)
def test_invalid_poses_are_refused_and_change_nothing(asked):
    bodies, arguments = Bodies(), arguments_of(asked)
    call = bodies.contexts[0].prepare(bodies.frames, asked, **arguments)
    usual = bodies.usual(asked, bodies.poses(1), **arguments)
    call(bodies.poses(1))
    for bad in (math.nan, 1e303):
        poses = bodies.poses(2)
        poses[3, 0] = bad
        with pytest.raises(PoseError):
            call(poses)
    for shape in ((1, 7), (8, 6), (7,)):
        with pytest.raises(PoseError):
            call(np.ones(shape))
    first = bodies.contexts[0].prepare(bodies.frames[:1], asked, **arguments)
    assert_same(first(bodies.poses(1)[:1]), usual)


def test_what_cannot_be_prepared_is_refused():
    bodies = Bodies()
    context, frames = bodies.contexts[0], bodies.frames
    with pytest.raises(ArgumentError, match="'depths'; it must be one of penetrations, distances"):
        context.prepare(frames, 'depths')
    for asked, distance in (('distances', math.nan), ('collision', 0.1)):
        with pytest.raises(ArgumentError, match='max_distance'):
            context.prepare(frames, asked, max_distance=distance)
    with pytest.raises(ArgumentError, match='accuracy'):
        context.prepare(frames, 'collision', accuracy='fine')
    with pytest.raises(PoseError, match='more than once'):
        context.prepare([frames[0], frames[0]], 'collision')
    derived = bodies.graph.ToAutoDiffXd().CreateDefaultContext()
    with pytest.raises(ArgumentError, match='context of AutoDiffXd'):
        derived.prepare(frames, 'collision')
    call = context.prepare([FrameId(10**9)], 'collision')
    with pytest.raises(PoseError, match='not in this scene'):
        call(bodies.poses(1, 1))
    some = context.prepare(frames[:2], 'collision')
    with pytest.raises(PoseError, match='never had a pose'):
        some(bodies.poses(1, 2))
