"""What is wider than promised is counted, and nothing else."""

import numpy as np
import pytest

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.math import RollPitchYaw
from truth.judging.asking import PairScene

PAIRS = {
    # Almost a ball, and in it something small: every direction is almost as good.
    'wide': (
        Body('Ellipsoid', (0.6, 0.6000006, 0.6012), np.eye(3), np.zeros(3)),
        Body(
            'Ellipsoid',
            (1e-5, 0.99e-5, 0.3e-5),
            RollPitchYaw(0.3, 0, 0).ToRotationMatrix().matrix(),
            np.zeros(3),
        ),
    ),
    'kept': (
        Body('Ellipsoid', (0.3, 0.2, 0.1), np.eye(3), np.zeros(3)),
        Body('Cylinder', (0.1, 0.3), np.eye(3), np.array([0.25, 0.1, 0.0])),
    ),
}


@pytest.mark.parametrize('name', PAIRS)
def test_pairs_that_break_the_promise_are_counted(name):
    scene = PairScene(*PAIRS[name])
    results = scene.distance()
    assert bool(results.breaks_promise()[0]) == (name == 'wide')
    assert scene.query.effects().wide_pairs == (name == 'wide')
