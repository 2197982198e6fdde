"""Result sequences: read-only, lazy, with arrays of the right shape; records as pydrake's."""

import numpy as np
import pytest
from geometry.test_query_object import Scene

from drake_geom_ros.geometry import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
    Sphere,
)


@pytest.fixture
def scene():
    scene = Scene(Sphere(0.5), Sphere(0.5), Sphere(0.5))
    return scene.pose([0, 0, 0], [0.9, 0, 0], [0, 0.8, 0])


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
                np.testing.assert_allclose(column[k], expected, atol=1e-16)
    assert distances.p_WCa.shape == distances.p_WCb.shape == (3, 3)


def test_records_that_nobody_filled():
    assert PenetrationAsPointPair().depth == -1
    assert not PenetrationAsPointPair().id_A.is_valid()
    assert SignedDistancePair().distance == 0
    assert SignedDistanceToPoint(distance=3.0).distance == 3.0
    with pytest.raises(TypeError):
        PenetrationAsPointPair(1)
