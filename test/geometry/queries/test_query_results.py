"""Result sequences: read-only, lazy, with arrays of the right shape; records as pydrake's."""

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
    Sphere,
)


@pytest.fixture
def scene():
    return ShapeScene(*[Sphere(0.5)] * 3).posed([0, 0, 0], [0.9, 0, 0], [0, 0.8, 0])


def test_a_sequence_of_records(scene):
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert len(results) == 3
    assert [type(r) for r in results] == [SignedDistancePair] * 3
    assert results[-1].distance == results[2].distance
    assert [r.distance for r in results[:2]] == results.distance[:2].tolist()
    for index in (3, -4):
        with pytest.raises(IndexError, match='3 results'):
            results[index]
    with pytest.raises(TypeError):
        results[0] = results[1]
    assert repr(results) == '<SignedDistanceResults of 3 results>'


def test_arrays_and_records_agree(scene):
    distances = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    contacts = scene.query.ComputePointPairPenetration()
    points = scene.query.ComputeSignedDistanceToPoint(np.zeros((2, 3)))
    for results in (distances, contacts, points):
        for k, record in enumerate(results):
            for name, value in vars(record).items():
                if name.startswith('_'):
                    continue
                column = getattr(results, name)
                assert len(column) == len(results)
                expected = value.get_value() if name.startswith('id_') else value
                np.testing.assert_allclose(column[k], expected, rtol=0, atol=1e-16)
    assert distances.p_WCa.shape == distances.p_WCb.shape == (3, 3)


def test_sequences_behave_as_lists(scene):
    query = scene.query
    for results in (
        query.ComputeSignedDistancePairwiseClosestPoints(),
        query.ComputePointPairPenetration(),
        query.ComputeSignedDistanceToPoint([1, 2, 3]),
    ):
        records = list(results)
        assert results == records
        assert records == results
        assert results == results[:]
        assert results != records[1:]
        assert results != [*records[1:], records[0]]
        other = [1]
        assert results + other == [*records, 1]
        assert other + results == [1, *records]
        assert results + results == 2 * records
        assert results != 'text'
        with pytest.raises(TypeError):
            results + 3


def test_sorting_takes_the_arrays_along(scene):
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    again = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    results.sort(key=lambda record: -record.distance)
    assert results == sorted(again, key=lambda record: -record.distance)
    assert results.distance.tolist() == sorted(again.distance.tolist(), reverse=True)
    assert [r.id_A.get_value() for r in results] == results.id_A.tolist()
    assert not results.distance.flags.writeable
    results.sort(key=lambda record: record.distance, reverse=True)
    assert results.distance[0] == again.distance.max()
    points = scene.query.ComputeSignedDistanceToPoint([[1, 2, 3], [0, 0, 0]])
    points.sort(key=lambda record: (record.distance, record.point_index))
    assert points.distance.tolist() == sorted(points.distance.tolist())
    assert [r.point_index for r in points] == points.point_index.tolist()
    assert scene.query.ComputeSignedDistancePairwiseClosestPoints() == again


def test_records_compare_by_their_numbers():
    assert SignedDistancePair(p_ACa=np.ones(3)) == SignedDistancePair(p_ACa=np.ones(3))
    assert SignedDistancePair(p_ACa=np.ones(3)) != SignedDistancePair()
    assert PenetrationAsPointPair() != SignedDistancePair()


def test_records_that_nobody_filled():
    assert PenetrationAsPointPair().depth == -1
    assert not PenetrationAsPointPair().id_A.is_valid()
    assert SignedDistancePair().distance == 0
    assert SignedDistanceToPoint(distance=3.0).distance == 3.0
    with pytest.raises(TypeError):
        PenetrationAsPointPair(1)
