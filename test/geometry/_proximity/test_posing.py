"""What a step of a pose is told to have moved a body by, at most."""

import math

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity import posing
from drake_geom_ros.geometry._proximity.tolerances import ROTATION_DEFECT


@pytest.mark.parametrize('angle', [0.0, 1e-15, 1e-9, 0.3, math.pi])
@pytest.mark.parametrize('radius', [0.0, 0.5, 1e6])
@pytest.mark.parametrize('moved', [0.0, 2.0])
def test_a_way_is_no_shorter_than_that_of_any_point(angle, radius, moved):
    """A point at right angles to the axis goes 2 sin(angle / 2) of its distance from it.

    The rotations that are meant are next to their matrices, both by as much as the defect.
    """
    turned = 2.0 * (2.0 * math.sin(0.5 * angle)) ** 2  # the squared Frobenius norm
    told = posing._way(turned, moved**2, radius)
    truth = moved + radius * 2.0 * math.sin(0.5 * angle)
    noise = 2.0 * radius * ROTATION_DEFECT if angle > 0.0 else 0.0
    assert truth + noise <= told <= (truth + 1.001 * noise) * (1.0 + 1e-14)


def test_the_frobenius_norm_of_a_turn_is_that_of_its_sine():
    c, s = math.cos(0.3), math.sin(0.3)
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    turned = np.linalg.norm(R - np.eye(3)) ** 2
    assert turned == pytest.approx(2.0 * (2.0 * math.sin(0.15)) ** 2, rel=1e-14)
