"""What is usually asked is prepared once; whatever changes in between, answers are of now."""

import copy

import numpy as np
import pytest
from oracles.poses import random_poses

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

COUNT = 8


class Balls:
    """Balls in a crowd, which move, change, come and go, and are filtered."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('crowd')
        self.frames = [
            self.graph.RegisterFrame(self.source, GeometryFrame(f'f{k}')) for k in range(COUNT)
        ]
        self.balls = [self._ball(self.graph, frame) for frame in self.frames]
        self.context = self.graph.CreateDefaultContext()
        self.query = self.graph.get_query_output_port().Eval(self.context)
        self.moved()

    def _ball(self, graph, frame, *context):
        shape = Sphere(self.rng.uniform(0.3, 0.6))
        ball = GeometryInstance(RigidTransform(), shape, f'ball {self.rng.random()}')
        ball.set_proximity_properties(ProximityProperties())
        return graph.RegisterGeometry(*context, self.source, frame, ball)

    def moved(self):
        values = np.array([frame.get_value() for frame in self.frames])
        poses = random_poses(COUNT, seed=int(self.rng.integers(2**31)))
        poses[:, :3] = self.rng.uniform(-1.0, 1.0, (COUNT, 3))
        vector = FramePoseVector.FromArrays(values, poses)
        self.graph.get_source_pose_port(self.source).FixValue(self.context, vector)

    def filtered(self):
        pair = GeometrySet(list(self.rng.choice(self.balls, 3, replace=False)))
        manager = self.graph.collision_filter_manager(self.context)
        manager.Apply(CollisionFilterDeclaration().ExcludeWithin(pair))

    def allowed(self):
        manager = self.graph.collision_filter_manager(self.context)
        manager.Apply(CollisionFilterDeclaration().AllowWithin(GeometrySet(self.balls)))

    def reshaped(self):
        ball = self.balls[self.rng.integers(len(self.balls))]
        self.graph.ChangeShape(self.context, self.source, ball, Sphere(self.rng.uniform(0.2, 0.7)))

    def grown(self):
        frame = self.frames[self.rng.integers(COUNT)]
        self.balls.append(self._ball(self.graph, frame, self.context))

    def coarser(self):
        self.context.set_default_accuracy(str(self.rng.choice(['bound', 'fast', 'exact'])))

    def copied(self):
        self.context = self.context.copy()
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def copied_deeply(self):
        self.context = copy.deepcopy(self.context)
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def nothing(self):
        pass


STEPS = [
    *('moved', 'moved', 'moved', 'nothing', 'filtered', 'allowed', 'reshaped', 'grown'),
    *('coarser', 'copied', 'copied_deeply'),
]


def answers(query):
    """Return all answers, as arrays of their own."""
    overlaps = query.ComputePointPairPenetration()
    near = query.ComputeSignedDistancePairwiseClosestPoints(0.2)
    return [
        *(overlaps.id_A.copy(), overlaps.id_B.copy(), overlaps.depth.copy()),
        *(near.id_A.copy(), near.id_B.copy(), near.distance.copy(), near.p_ACa.copy()),
        np.array(query.HasCollisions()),
        query.collision_candidates().copy(),
    ]


@pytest.mark.parametrize('seed', range(6))
def test_answers_are_those_of_who_asks_for_the_first_time(seed):
    scene = Balls(seed)
    for step in scene.rng.choice(STEPS, 60):
        getattr(scene, step)()
        fresh = copy.copy(scene.query)
        for found, expected in zip(answers(scene.query), answers(fresh), strict=True):
            np.testing.assert_array_equal(found, expected, err_msg=str(step))


def test_answers_that_are_held_stay_as_they_were():
    """Who asks in a loop has the last answer while the next is computed, or all of them."""
    scene, held, expected = Balls(0), [], []
    for _ in range(10):
        scene.moved()
        held.append(scene.query.ComputePointPairPenetration())
        expected.append((held[-1].id_A.copy(), held[-1].p_WCa.copy()))
        for results, (ids, points) in zip(held, expected, strict=True):
            np.testing.assert_array_equal(results.id_A, ids)
            np.testing.assert_array_equal(results.p_WCa, points)


def test_a_loop_that_holds_the_last_answer_takes_turns_in_two_places():
    scene, places = Balls(0), []
    results = None
    for _ in range(12):
        scene.moved()
        results = scene.query.ComputePointPairPenetration()
        places.append(results.depth.ctypes.data)
    assert len(set(places[4:])) == 2
