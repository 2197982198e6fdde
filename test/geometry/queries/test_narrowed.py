"""A query object that considers some pairs only: the same answers about these, and no other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    ArgumentError,
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

COUNT = 7


def scene(filtered=()):
    graph = SceneGraph()
    source = graph.RegisterSource('balls')
    frames, balls = [], []
    for k in range(COUNT):
        frames.append(graph.RegisterFrame(source, GeometryFrame(f'{k}')))
        ball = GeometryInstance(RigidTransform(), Sphere(0.1 + 0.01 * k), 'ball')
        ball.set_proximity_properties(ProximityProperties())
        balls.append(graph.RegisterGeometry(source, frames[-1], ball))
    for a, b in filtered:
        declaration = CollisionFilterDeclaration().ExcludeBetween(
            GeometrySet(balls[a]), GeometrySet(balls[b])
        )
        graph.collision_filter_manager().Apply(declaration)
    context = graph.CreateDefaultContext()
    return graph, context, frames


def pose(graph, context, frames, p_WFs):
    poses = FramePoseVector({f: RigidTransform(p) for f, p in zip(frames, p_WFs, strict=True)})
    graph.get_source_pose_port(graph.model_inspector().GetAllSourceIds()[-1])
    context.UpdateFramePoses(poses)
    return graph.get_query_output_port().Eval(context)


def told(results):
    return [
        (int(a), int(b), float(d)) for a, b, d in
        zip(results.id_A, results.id_B, results.distance, strict=True)
    ]  # fmt: skip


pairs = st.sets(st.tuples(st.integers(0, COUNT - 1), st.integers(0, COUNT - 1)), max_size=12)
places = st.lists(
    st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=COUNT, max_size=COUNT),
    min_size=1,
    max_size=4,
)


@settings(max_examples=60, deadline=None)
@given(pairs, pairs, places)
def test_it_answers_about_its_pairs_as_the_whole_does_while_both_are_asked(some, filtered, moves):
    graph, context, frames = scene(filtered)
    query = pose(graph, context, frames, moves[0])
    ids, reported = query.inspector().candidate_matrix()
    considered = np.zeros((COUNT, COUNT), dtype=bool)
    for a, b in some:
        considered[a, b] = True
    narrow = query.narrowed(considered)
    row = {int(value): k for k, value in enumerate(ids)}
    both = considered | considered.T
    for p_WFs in moves:
        query = pose(graph, context, frames, p_WFs)
        for cutoff in (0.3, np.inf):
            whole = told(query.ComputeSignedDistancePairwiseClosestPoints(cutoff))
            expected = [t for t in whole if both[row[t[0]], row[t[1]]]]
            assert told(narrow.ComputeSignedDistancePairwiseClosestPoints(cutoff)) == expected
            assert all(reported[row[a], row[b]] for a, b, _ in whole)


@settings(max_examples=60, deadline=None)
@given(
    pairs,
    st.lists(st.integers(0, 2), min_size=COUNT, max_size=COUNT),
    st.lists(st.booleans(), min_size=9, max_size=9),
)
def test_pairs_of_kinds_are_those_of_the_matrix_that_they_stand_for(filtered, kinds, flags):
    graph, context, frames = scene(filtered)
    query = pose(graph, context, frames, np.random.default_rng(0).uniform(-1, 1, (COUNT, 3)))
    between = np.reshape(flags, (3, 3))[: max(kinds) + 1, : max(kinds) + 1]
    by_kinds = query.narrowed(between, kinds)
    by_pairs = query.narrowed(between[np.ix_(kinds, kinds)])
    answers = [
        told(each.ComputeSignedDistancePairwiseClosestPoints(np.inf))
        for each in (by_kinds, by_pairs)
    ]
    assert answers[0] == answers[1]
    some = by_kinds.inspector(), by_pairs.inspector()
    assert some[0].GetCollisionCandidates() == some[1].GetCollisionCandidates()


def test_a_matrix_of_another_size_is_refused():
    graph, context, frames = scene()
    query = pose(graph, context, frames, np.zeros((COUNT, 3)))
    with pytest.raises(ArgumentError, match=r'matrix \(2, 2\); it must be \(7, 7\)'):
        query.narrowed(np.eye(2))
    for kinds in ([0] * 6, [0, 1, 2, 0, 0, 0, 0], [-1, 1, 0, 0, 0, 0, 0]):
        with pytest.raises(ArgumentError, match=r'kinds \(\d,\), from 0 on, must be \(7,\)'):
            query.narrowed(np.eye(2), kinds)


def test_the_matrix_of_candidates_is_the_set_of_candidates():
    graph, context, frames = scene([(0, 1), (2, 5)])
    inspector = pose(graph, context, frames, np.zeros((COUNT, 3))).inspector()
    ids, reported = inspector.candidate_matrix()
    assert reported.sum() == 2 * (COUNT * (COUNT - 1) // 2 - 2)
    values = {(a.get_value(), b.get_value()) for a, b in inspector.GetCollisionCandidates()}
    rows = np.argwhere(np.triu(reported))
    assert values == {(int(ids[a]), int(ids[b])) for a, b in rows}
