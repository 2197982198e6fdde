"""What is usually asked is prepared once; whatever changes in between, answers are of now."""

import copy
import gc
import weakref

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
from drake_geom_ros.geometry._proximity.engine import prepared
from drake_geom_ros.geometry.queries import context_state as states
from drake_geom_ros.geometry.queries.context import state_of
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


def test_a_list_that_is_too_long_to_be_kept_is_gone_though_the_query_is_usual(monkeypatch):
    """What context and engine prepared for the query holds it no longer, and is prepared anew."""
    lists = []

    class Listed(prepared.NeighbourList):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            lists.append(weakref.ref(self))

    monkeypatch.setattr(prepared, '_LONG', 10)
    monkeypatch.setattr(prepared, 'NeighbourList', Listed)
    scene = Balls(3)
    for turn in range(3):
        scene.moved()
        every = scene.query.ComputeSignedDistancePairwiseClosestPoints()
        assert len(every) == COUNT * (COUNT - 1) // 2
        gc.collect()
        assert [there() for there in lists] == [None] * (turn + 1)


def test_queries_without_end_are_answered_as_of_now():
    """More of them than are kept, in a row and again."""
    scene = Balls(4)
    for _ in range(2):
        scene.moved()
        for reach in np.linspace(0.0, 1.0, 40):
            near = scene.query.ComputeSignedDistancePairwiseClosestPoints(float(reach))
            fresh = copy.copy(scene.query)
            expected = fresh.ComputeSignedDistancePairwiseClosestPoints(float(reach))
            np.testing.assert_array_equal(near.distance, expected.distance)
    assert len(state_of(scene.context)._prepared) <= states._MAX_PREPARED


def held(scene):
    """Return all that is handed out for the poses of now, results and arrays of them."""
    query = scene.query
    near = query.ComputeSignedDistancePairwiseClosestPoints(0.2)
    every = query.ComputeSignedDistancePairwiseClosestPoints()
    points = query.ComputeSignedDistanceToPoint(scene.rng.normal(size=(40, 3)))
    overlaps = query.ComputePointPairPenetration()
    in_time = query.ComputeSignedDistancePairwiseClosestPoints(time_budget=1e-9)
    results = near, every, points, overlaps, in_time, every.penetrations()
    return results, [array for each in results for array in each._batch]


@pytest.mark.parametrize('kept', ['results', 'arrays', 'parts'])
def test_what_was_handed_out_is_never_written_again(kept):
    """Whoever holds results, their arrays or parts of these has them as they were, for ever."""
    scene, holders, shown, copies = Balls(0), [], [], []
    for _ in range(25):
        scene.moved()
        results, arrays = held(scene)
        copies.append([array.copy() for array in arrays])
        if kept == 'parts':
            arrays, copies[-1] = ([a[::2].T for a in each] for each in (arrays, copies[-1]))
        holders.append(results if kept == 'results' else arrays)
        del results, arrays
    for each in holders:
        shown.append([a for r in each for a in r._batch] if kept == 'results' else each)
    for arrays, expected in zip(shown, copies, strict=True):
        for array, its_copy in zip(arrays, expected, strict=True):
            np.testing.assert_array_equal(array, its_copy)


def test_arrays_of_answers_are_of_their_own():
    """None shares memory with another, or with what the world and the engine work on."""
    scene, arrays = Balls(0), []
    for _ in range(5):
        scene.moved()
        arrays.append(scene.query.ComputePointPairPenetration().depth)
    for k, array in enumerate(arrays):
        assert not any(np.shares_memory(array, other) for other in arrays[:k])
