"""A frame that never had a pose is nowhere: queries say so, or leave out what hangs on it."""

import copy

import numpy as np
import pytest
from oracles.small_scene import SmallScene, instance

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometrySet,
    HalfSpace,
    PoseError,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

QUESTIONS = {
    'distances': lambda q: q.ComputeSignedDistancePairwiseClosestPoints(),
    'penetrations': lambda q: q.ComputePointPairPenetration(),
    'collide': lambda q: q.HasCollisions(),
    'candidates': lambda q: q.FindCollisionCandidates(),
    'points': lambda q: q.ComputeSignedDistanceToPoint([0, 0, 0]),
    'costs': lambda q: q.cost_of_levels(),
}


class Chain:
    """Balls on frames a, b on a, and c; a floor; filters nothing."""

    def __init__(self, partial):
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('s')
        world = self.graph.world_frame_id()
        self.a = self.frame('a', world)
        self.b = self.frame('b', self.a)
        self.c = self.frame('c', world)
        self.balls = [self.geometry(frame, Sphere(0.1)) for frame in (self.a, self.b, self.c)]
        self.floor = self.geometry(world, HalfSpace())
        self.context = self.graph.CreateSharedContext(partial=partial)
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def frame(self, name, parent):
        return self.graph.RegisterFrame(self.source, parent, GeometryFrame(name))

    def geometry(self, frame, shape):
        body = instance(type(shape).__name__, shape)
        return self.graph.RegisterGeometry(self.source, frame, body)

    def pose(self, *frames, z=1.0):
        poses = {frame: RigidTransform([0, 0, z]) for frame in frames}
        self.context.UpdateFramePoses(FramePoseVector(poses))

    def pairs(self):
        found = self.query.ComputeSignedDistancePairwiseClosestPoints()
        return list(zip(found.id_A.tolist(), found.id_B.tolist(), strict=True))


def pairs_of(*geometries):
    values = sorted(g.get_value() for g in geometries)
    return [(a, b) for k, a in enumerate(values) for b in values[k + 1 :]]


@pytest.mark.parametrize('name', QUESTIONS)
def test_every_query_names_the_frames_that_never_had_a_pose(name):
    scene = Chain(partial=False)
    scene.pose(scene.a)
    for query in (scene.query, copy.copy(scene.query)):
        with pytest.raises(PoseError, match=r"Of 3 frames 2 never .* 'b' .*, 'c' .*FixValue"):
            QUESTIONS[name](query)
    scene.pose(scene.b, scene.c)
    QUESTIONS[name](scene.query)
    # One that comes later has none either.
    late = scene.frame('late', scene.a)
    with pytest.raises(PoseError, match="Of 4 frames 1 never had a pose: 'late'"):
        QUESTIONS[name](scene.query)
    scene.pose(late)
    QUESTIONS[name](scene.query)


def test_so_do_poses_and_pairs():
    scene = Chain(partial=False)
    scene.pose(scene.a, scene.b)
    for call in (
        lambda: scene.query.GetPoseInWorld(scene.a),
        lambda: scene.query.GetPoseInParent(scene.a),
        lambda: scene.query.GetPoseInWorld(scene.floor),
        lambda: scene.query.ComputeSignedDistancePairClosestPoints(*scene.balls[:2]),
    ):
        with pytest.raises(PoseError, match="'c'"):
            call()


def test_a_pose_at_the_identity_is_one_too():
    """It moves nothing, and yet something is known then."""
    scene = Chain(partial=True)
    assert scene.pairs() == []
    scene.pose(scene.a, z=0.0)
    assert scene.pairs() == pairs_of(scene.balls[0], scene.floor)
    scene.pose(scene.c, z=0.0)
    assert scene.pairs() == pairs_of(scene.balls[0], scene.balls[2], scene.floor)


def test_a_port_and_a_question_s_own_poses_count():
    small = SmallScene()
    context = small.scene_graph.CreateDefaultContext()
    query = small.scene_graph.get_query_output_port().Eval(context)
    assert query.waiting_frames() == [small.upper, small.lower]
    poses = FramePoseVector({small.upper: RigidTransform(), small.lower: RigidTransform()})
    what_if = context.what_if()
    what_if.UpdateFramePoses(poses)
    assert small.scene_graph.get_query_output_port().Eval(what_if).waiting_frames() == []
    assert query.waiting_frames() == [small.upper, small.lower]
    small.scene_graph.get_source_pose_port(small.arm).FixValue(context, poses)
    assert query.waiting_frames() == []


def test_a_copy_is_posed_by_the_port_and_waits_for_itself():
    scene = Chain(partial=True)
    scene.pose(scene.a)
    other = scene.context.Clone()
    query = scene.graph.get_query_output_port().Eval(other)
    assert query.num_waiting_pairs() == scene.query.num_waiting_pairs() > 0
    poses = dict.fromkeys((scene.a, scene.b, scene.c), RigidTransform())
    scene.graph.get_source_pose_port(scene.source).FixValue(other, FramePoseVector(poses))
    assert query.num_waiting_pairs() == 0
    assert scene.query.num_waiting_pairs() > 0


def test_a_partial_context_answers_for_the_rest():
    scene = Chain(partial=True)
    scene.pose(scene.b, scene.c)  # b hangs on a, so nobody knows where it is
    assert scene.query.waiting_frames() == [scene.a]
    placed = [scene.query.is_placed(x) for x in (scene.a, scene.b, scene.c, *scene.balls)]
    assert placed == [False, False, True, False, False, True]
    assert scene.query.is_placed(scene.floor)
    assert scene.pairs() == pairs_of(scene.balls[2], scene.floor)
    assert scene.query.FindCollisionCandidates() == []
    assert not scene.query.HasCollisions()
    found = scene.query.ComputeSignedDistanceToPoint(np.zeros((2, 3)))
    assert set(found.id_G) == {scene.balls[2].get_value(), scene.floor.get_value()}
    assert found.point_index.tolist() == [0, 0, 1, 1]
    assert scene.query.X_PF(scene.b).translation().tolist() == [0, 0, 1]
    for ask in (scene.query.X_WF, scene.query.GetPoseInWorld):
        with pytest.raises(PoseError, match=r"'b' .* never had a pose: 'a'"):
            ask(scene.b)
    with pytest.raises(PoseError, match="never had a pose: 'a'"):
        scene.query.ComputeSignedDistancePairClosestPoints(scene.balls[1], scene.floor)
    scene.pose(scene.a)
    assert scene.pairs() == pairs_of(*scene.balls, scene.floor)


def test_half_spaces_that_wait_are_left_out_as_others():
    scene = Chain(partial=True)
    plane = scene.geometry(scene.c, HalfSpace())
    assert not scene.query.HasCollisions()
    assert scene.query.FindCollisionCandidates() == []
    assert len(scene.query.half_space_gaps().ids) == 0
    scene.pose(scene.c)
    assert scene.query.HasCollisions()
    assert scene.query.FindCollisionCandidates() == [(scene.floor, plane)]
    with pytest.raises(PoseError, match='never had a pose'):
        Chain(partial=False).query.half_space_gaps()


def test_what_is_left_out_is_counted_without_what_is_filtered():
    scene = Chain(partial=True)
    assert scene.query.num_waiting_pairs() == 6
    between = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(scene.balls[:2]))
    scene.graph.collision_filter_manager().Apply(between)
    assert scene.query.num_waiting_pairs() == 5
    scene.pose(scene.c)
    assert scene.query.num_waiting_pairs() == 4
    scene.geometry(scene.a, HalfSpace())  # and the floor, which HasCollisions would tell of
    assert scene.query.num_waiting_pairs() == 7
    scene.pose(scene.a, scene.b)
    assert scene.query.num_waiting_pairs() == 0


def test_the_effects_count_what_was_looked_at_only():
    scene = Chain(partial=True)
    scene.pose(scene.c)
    scene.pairs()
    effects = scene.query.effects()
    assert effects.broadphase_pairs == effects.narrowphase_pairs == 1


def test_first_poses_are_those_that_later_contexts_begin_with():
    scene = Chain(partial=False)
    poses = {frame: RigidTransform([0, 0, z]) for frame, z in ((scene.a, 2), (scene.c, 5))}
    scene.graph.SetFirstPoses(FramePoseVector(poses))
    assert scene.query.waiting_frames() == [scene.a, scene.b, scene.c]
    later = scene.graph.CreateDefaultContext()
    query = scene.graph.get_query_output_port().Eval(later)
    assert query.waiting_frames() == [scene.b]
    later.UpdateFramePoses(FramePoseVector({scene.b: RigidTransform([0, 0, 1])}))
    places = [query.X_WF(frame).translation()[2] for frame in (scene.a, scene.b, scene.c)]
    assert places == [2, 3, 5]
    for frame, words in ((scene.graph.world_frame_id(), 'world'), (FrameId(10**9), 'not a frame')):
        bad = FramePoseVector({scene.a: RigidTransform(), frame: RigidTransform()})
        with pytest.raises(RuntimeError, match=words):
            scene.graph.SetFirstPoses(bad)
    again = scene.graph.get_query_output_port().Eval(scene.graph.CreateSharedContext(partial=True))
    assert again.X_WF(scene.a).translation().tolist() == [0, 0, 2]


def test_bodies_of_a_crowd_that_are_placed_one_after_the_other_are_near_whom_they_are_near():
    """Those that wait stand nowhere, though all of them have the same place in memory."""
    graph = SceneGraph()
    source = graph.RegisterSource('s')
    frames, rng = [], np.random.default_rng(3)
    for k in range(300):
        frames.append(graph.RegisterFrame(source, GeometryFrame(f'f{k}')))
        graph.RegisterGeometry(source, frames[-1], instance('ball', Sphere(0.1)))
        rests = instance(f'rests {k}', Sphere(0.1), RigidTransform(rng.uniform(-1, 1, 3)))
        graph.RegisterAnchoredGeometry(source, rests)
    context = graph.CreateSharedContext(partial=True)
    query = graph.get_query_output_port().Eval(context)

    def near():
        found = query.ComputeSignedDistancePairwiseClosestPoints(0.05)
        return sorted(zip(found.id_A.tolist(), found.id_B.tolist(), strict=True))

    assert near() == []
    placed = 0
    for frame in rng.permutation(frames).tolist():
        # The first stays where it was nowhere; some rest for long before others come.
        place = rng.uniform(-1, 1, 3) if placed else np.zeros(3)
        context.UpdateFramePoses(FramePoseVector({frame: RigidTransform(place)}))
        placed += 1
        if placed % 20 != 1:
            continue
        everywhere = query.ComputeSignedDistancePairwiseClosestPoints()  # by no list of near ones
        within = everywhere.distance <= 0.05
        pairs = zip(
            everywhere.id_A[within].tolist(), everywhere.id_B[within].tolist(), strict=True
        )
        assert near() == sorted(pairs)
        for _ in range(rng.integers(0, 100)):
            context.UpdateFramePoses(FramePoseVector({frame: RigidTransform(place)}))
            query.HasCollisions()
    assert placed == 300
    assert len(near()) > 300


def test_a_frame_that_is_unposed_waits_again_with_what_hangs_on_it():
    scene = Chain(partial=True)
    scene.pose(scene.a, scene.b, scene.c)
    every = scene.pairs()
    scene.context.UnposeFrames([scene.a])
    assert scene.query.waiting_frames() == [scene.a]
    assert scene.pairs() == pairs_of(scene.balls[2], scene.floor)
    assert not scene.query.is_placed(scene.b)
    scene.pose(scene.a)
    assert scene.pairs() == every


@pytest.mark.parametrize(
    ('partial', 'frames', 'reason'),
    [
        (False, lambda scene: [scene.a], 'CreateSharedContext'),
        (True, lambda scene: [scene.a, FrameId.get_new_id()], 'not in this scene'),
    ],
)
def test_frames_that_cannot_be_unposed_are_refused_and_nothing_changes(partial, frames, reason):
    scene = Chain(partial=partial)
    scene.pose(scene.a, scene.b, scene.c)
    with pytest.raises(PoseError, match=reason):
        scene.context.UnposeFrames(frames(scene))
    assert scene.query.waiting_frames() == []
