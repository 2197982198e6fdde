"""Results of queries to plain objects: no message class, no ROS."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.live.conversions.results import (
    fill_penetrations,
    fill_point_distances,
    fill_signed_distances,
)


def posed(scene, names, x):
    """Return a query object with the balls x apart."""
    context = scene.CreateDefaultContext()
    frames = [names.frame(name) for name in ('left::arm', 'right::arm', 'hand')]
    rows = np.zeros((3, 7))
    rows[:, 6], rows[1, 0] = 1.0, x
    context.UpdateFramePoses(FramePoseVector.FromArrays(frames, rows))
    return scene.get_query_output_port().Eval(context)


def test_results_fill_flat_arrays(scene, names):
    distances = posed(scene, names, 0.5).ComputeSignedDistancePairwiseClosestPoints()
    message = Plain()
    fill_signed_distances(message, distances, math.inf)
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    assert list(message.id_a) == [a.get_value()]
    assert list(message.id_b) == [b.get_value()]
    assert message.distance[0] == pytest.approx(0.3, abs=1e-15)
    assert list(message.p_aca) == pytest.approx([0.1, 0, 0])
    assert list(message.p_bcb) == pytest.approx([-0.1, 0, 0])
    assert list(message.nhat_ba_w) == [-1.0, 0.0, 0.0]
    assert message.is_nhat_ba_w_unique == [True]
    assert list(message.method) == [1]
    assert [x.typecode for x in (message.id_a, message.distance, message.method)] == list('QdB')
    contact = posed(scene, names, 0.15)
    message = Plain()
    fill_penetrations(message, contact.ComputePointPairPenetration())
    assert message.depth[0] == pytest.approx(0.05, abs=1e-15)
    assert list(message.p_wca) == pytest.approx([0.1, 0, 0])
    assert list(message.p_wcb) == pytest.approx([0.05, 0, 0])
    message = Plain()
    points = contact.ComputeSignedDistanceToPoint([[0, 0, 0.3], [9, 9, 9]], 1.0)
    fill_point_distances(message, [points], 1.0, [np.arange(len(points))])
    assert list(message.point_index) == [0, 0]
    assert list(message.id_g) == [a.get_value(), b.get_value()]
    assert message.distance[0] == pytest.approx(0.2, abs=1e-15)
    assert list(message.p_gn)[:3] == pytest.approx([0, 0, 0.1])
    assert list(message.grad_w)[:3] == pytest.approx([0, 0, 1])


def test_an_empty_result_fills_empty_arrays(scene, names):
    message = Plain()
    results = posed(scene, names, 5.0).ComputePointPairPenetration()
    fill_penetrations(message, results)
    assert [len(v) for v in vars(message).values()] == [0] * 8
