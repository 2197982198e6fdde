"""Candidate pairs without a matrix: the same as asking the inspector for each pair."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    CandidatePairs,
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

COUNT = 9


def scene(frame_of, excluded=(), inactive=(), removed=()):
    """Return a scene of balls on some of three frames, or on the world, and its balls."""
    graph = SceneGraph()
    source = graph.RegisterSource('balls')
    frames = [graph.RegisterFrame(source, GeometryFrame(f'{k}')) for k in range(3)]
    frames.append(graph.world_frame_id())
    balls = []
    for k, frame in enumerate(frame_of):
        ball = GeometryInstance(RigidTransform(), Sphere(0.1), f'{k}')
        ball.set_proximity_properties(ProximityProperties())
        balls.append(graph.RegisterGeometry(source, frames[frame], ball))
    manager = graph.collision_filter_manager()
    for a, b in excluded:
        sets = GeometrySet(balls[a]), GeometrySet(balls[b])
        manager.Apply(CollisionFilterDeclaration().ExcludeBetween(*sets))
    manager.Deactivate(GeometrySet([balls[k] for k in inactive]))
    for k in removed:
        graph.RemoveGeometry(source, balls[k])
    return graph, [ball for k, ball in enumerate(balls) if k not in removed]


places = st.integers(0, COUNT - 1)
scenes = st.builds(
    scene,
    st.lists(st.integers(0, 3), min_size=COUNT, max_size=COUNT),
    st.sets(st.tuples(places, places), max_size=8),
    st.sets(places, max_size=2),
    st.sets(places, max_size=3),
)


@settings(max_examples=150, deadline=None)
@given(scenes, st.data())
def test_pairs_and_partners_are_those_that_no_filter_takes_out(made, data):
    graph, balls = made
    inspector = graph.model_inspector()
    candidates = inspector.candidate_pairs()
    expected = [[not inspector.CollisionFiltered(a, b) for b in balls] for a in balls]
    assert candidates.ids.tolist() == [ball.get_value() for ball in balls]
    assert candidates.matrix().tolist() == expected
    flags = st.lists(st.booleans(), min_size=len(balls), max_size=len(balls))
    of, among = (np.array(data.draw(flags), dtype=bool) for _ in range(2))
    partners = np.array(expected, dtype=int) @ among * of
    assert candidates.partners(of, among).tolist() == partners.tolist()


@given(scenes)
def test_pairs_stay_as_they_were_while_filters_change_and_match_until_then(made):
    graph, balls = made
    before = graph.model_inspector().candidate_pairs()
    assert before.matches(graph.model_inspector().candidate_pairs())
    matrix = before.matrix()
    everything = GeometrySet(balls)
    graph.collision_filter_manager().Deactivate(everything)
    assert before.matrix().tolist() == matrix.tolist()
    after = graph.model_inspector().candidate_pairs()
    assert not after.matrix().any()
    if matrix.any():
        assert not before.matches(after)


def test_all_pairs_are_those_of_different_geometries():
    every = CandidatePairs.of_all(np.array([3, 5, 8]))
    assert every.matrix().tolist() == (~np.eye(3, dtype=bool)).tolist()
    some = np.array([True, True, False])
    assert every.partners(some, ~some).tolist() == [1, 1, 0]
    assert every.partners(some, some).tolist() == [1, 1, 0]


def test_sixteen_thousand_geometries_take_no_matrix():
    ids = np.arange(16_000)
    every = CandidatePairs.of_all(ids)
    assert sum(part.nbytes for part in every._parts) < 40 * len(ids)
