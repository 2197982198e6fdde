"""Accuracy as a length: what is taken, what is promised, and that names are shorthands."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    Accuracy,
    ArgumentError,
    Box,
    Cylinder,
    Ellipsoid,
    GeometryError,
    SceneGraph,
    Sphere,
    accuracy_of,
)

NONE = [0, -1e-3, math.nan, math.inf, '-1', 'nan', 'inf', '', 'superb', True, None, [1e-3], 1j]


@pytest.mark.parametrize('wanted', NONE, ids=repr)
def test_what_is_no_accuracy_is_refused(wanted):
    with pytest.raises(ArgumentError) as refusal:
        accuracy_of(wanted)
    assert f'accuracy={wanted!r}' in str(refusal.value)
    assert 'bound, fast, balanced, exact' in str(refusal.value)


@given(st.floats(0.0, exclude_min=True, allow_infinity=False))
def test_a_length_is_its_text(length):
    made = accuracy_of(length)
    assert made.length == length
    for same in (str(made), made, np.float64(length), Accuracy(length)):
        assert accuracy_of(same) == made
        assert accuracy_of(same).length == length


def test_names_and_texts():
    assert [accuracy_of(name) for name in ACCURACY_LEVELS] == list(ACCURACY_LEVELS)
    lengths = {name: accuracy_of(name).length for name in ACCURACY_LEVELS}
    assert lengths == {'bound': math.inf, 'fast': 1e-3, 'balanced': 1e-6, 'exact': 1e-9}
    assert accuracy_of('1e-3') == accuracy_of('0.001') == accuracy_of(1e-3) == '0.001'
    assert accuracy_of(1) == '1.0'
    again = pickle.loads(pickle.dumps(accuracy_of('5e-3')))
    assert (again, again.length, type(again)) == ('0.005', 5e-3, Accuracy)


def test_a_length_is_taken_wherever_a_level_is():
    graph = SceneGraph(accuracy=1e-4)
    assert graph.default_accuracy() == '0.0001'
    graph.set_default_accuracy('2e-4')
    assert graph.default_accuracy().length == 2e-4
    scene = ShapeScene(Ellipsoid(0.2, 0.3, 0.4), Cylinder(0.2, 0.3))
    query = scene.posed([0, 0, 0], [0.5, 0.4, 0.6]).query
    a, b = scene.ids
    answers = [
        query.ComputeSignedDistancePairwiseClosestPoints(accuracy=1e-6)[0],
        query.ComputeSignedDistancePairwiseClosestPoints(accuracy='balanced')[0],
        query.ComputeSignedDistancePairClosestPoints(a, b, accuracy='1e-6'),
    ]
    assert len({answer.distance for answer in answers}) == 1
    assert not query.HasCollisions(accuracy=0.01)
    assert len(query.ComputePointPairPenetration(accuracy=0.01)) == 0
    assert len(query.FindCollisionCandidates(accuracy=0.01)) == 0
    assert len(query.ComputeSignedDistanceToPoint(np.zeros(3), accuracy=0.01)) == 2
    refused = (
        lambda: SceneGraph(accuracy=0.0),
        lambda: graph.set_default_accuracy(-1.0),
        lambda: scene.context.set_default_accuracy(math.inf),
        lambda: query.ComputeSignedDistancePairwiseClosestPoints(accuracy=math.nan),
        lambda: query.HasCollisions(accuracy=-1e-3),
        lambda: query.FindCollisionCandidates(accuracy=0),
        lambda: query.ComputeSignedDistanceToPoint(np.zeros(3), accuracy='far'),
    )
    for call in refused:
        with pytest.raises(GeometryError, match='accuracy='):
            call()
    assert graph.default_accuracy() == '0.0002'


@given(
    length=st.floats(1e-9, 10.0),
    seed=st.integers(0, 2**32 - 1),
    size=st.sampled_from([0.01, 0.2, 3.0]),
)
def test_what_is_apart_is_known_to_that_length(length, seed, size):
    """Whatever the size of the bodies, and not only to a part of it."""
    rng = np.random.default_rng(seed)
    kinds = (
        lambda: Sphere(*rng.uniform(0.1, 0.5, 1)),
        lambda: Box(*rng.uniform(0.1, 1.0, 3)),
        lambda: Ellipsoid(*rng.uniform(0.1, 0.5, 3)),
        lambda: Cylinder(*rng.uniform(0.1, 0.5, 2)),
    )
    shapes = [kinds[k]() for k in rng.integers(0, 4, 2)]
    scaled = [type(s)(*(np.array(_sizes(s)) * size).tolist()) for s in shapes]
    scene = ShapeScene(*scaled).posed([0, 0, 0], rng.uniform(-1.5, 1.5, 3) * size)
    exact = scene.query.ComputeSignedDistancePairwiseClosestPoints(accuracy='exact')
    answer = scene.query.ComputeSignedDistancePairwiseClosestPoints(accuracy=length)
    error = abs(answer.distance[0] - exact.distance[0])
    assert error <= answer.error_bound[0] + exact.error_bound[0]
    if answer.distance[0] > answer.error_bound[0]:
        assert answer.error_bound[0] <= max(length, 1e-13 * size)
        assert answer.error_bound[0] <= answer.promised_error_bound[0]


def _sizes(shape):
    """Return the arguments of a shape's constructor."""
    if isinstance(shape, Sphere):
        return [shape.radius()]
    if isinstance(shape, Box):
        return shape.size().tolist()
    if isinstance(shape, Ellipsoid):
        return [shape.a(), shape.b(), shape.c()]
    return [shape.radius(), shape.length()]
