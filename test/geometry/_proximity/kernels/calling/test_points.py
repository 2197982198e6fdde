"""What is taken of a closed form into the rows of a point query."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.calling import points
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import NearestOnSurface


@pytest.mark.parametrize(
    ('distance', 'taken'), [(0.5, True), (1.0, True), (1.0 + 1e-15, True), (1.0 + 1e-12, False)]
)
def test_a_point_as_far_as_the_threshold_is_within_it(distance, taken):
    rows, found = np.zeros((2, points.POINT_WIDTH)), np.zeros(2, dtype=np.bool_)
    answers = points.PointAnswers(rows, found, np.zeros(4, dtype=np.int64))
    body = points.PointedBody(np.ones(1), np.eye(3), np.zeros(3), 1.0, 0.0, 0.0)
    nearest = NearestOnSurface(distance, (0.0, 0.0, 1.0), (0.0, 0.0, 2.0), True)
    points.take(answers, 1, body, 1.0, 2.0, 0.0, nearest)
    assert found.tolist() == [False, taken]
    assert answers.counts.sum() == taken
    assert rows[1, points.POINT_DISTANCE] == (distance if taken else 0.0)
