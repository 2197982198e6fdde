"""Derivatives of distances to points, by the motion of frames, of points, and of joints."""

import numpy as np
import pytest
from oracles.shape_scenes import SHAPES, MovingPair, moved

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_directions, random_rotation


def asked(pair, p_WQs):
    """Return the distances of both geometries to points, and the place of each frame's rows."""
    found = pair.query.ComputeSignedDistanceToPoint(p_WQs)
    return found, [found.id_G == g.get_value() for g in pair.ids]


@pytest.mark.parametrize('name', SHAPES)
def test_it_foretells_what_moving_the_frame_and_the_point_does(name):
    rng = np.random.default_rng(len(name))
    pair = MovingPair(SHAPES[name], SHAPES['sphere'])
    X_WF = RigidTransform(RotationMatrix(random_rotation(rng)), rng.normal(size=3))
    pair.place(X_WF, RigidTransform())
    p_FGo = np.array([0.1, -0.2, 0.3])
    p_WQs = X_WF @ p_FGo + random_directions(rng, 12) * rng.uniform(0.02, 0.5, (12, 1))
    V, v_Qs = rng.normal(size=6), rng.normal(size=(12, 3))
    found, (of_A, _) = asked(pair, p_WQs)
    J_Qs = np.zeros((len(found), 3, 1))
    J_Qs[:, :, 0] = v_Qs[found.point_index]
    rates = found.distance_jacobian(V[:, None], J_Qs)[of_A, 0]
    steps = []
    for t in (1e-5, -1e-5):
        pair.place(moved(X_WF, V, t), RigidTransform())
        steps.append(asked(pair, p_WQs + t * v_Qs)[0].distance[of_A])
    off = np.abs((steps[0] - steps[1]) / 2e-5 - rates)
    # Where the nearest feature changes within the step, half of the jump is left.
    assert (off[found.is_grad_W_unique[of_A]] < 1e-7).mean() > 0.8
    assert np.median(off) < 1e-8
    # Results keep what they were asked for.
    np.testing.assert_array_equal(found.distance_jacobian(V[:, None], J_Qs)[of_A, 0], rates)


def test_a_point_that_stays_and_wrong_shapes():
    pair = MovingPair(SHAPES['box'], SHAPES['sphere'])
    found, _ = asked(pair, [1.0, 0.2, 0.3])
    J = np.eye(6)
    np.testing.assert_allclose(found.distance_jacobian(J), found.gradients, rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.gradients[:, 3:], -found.grad_W, rtol=0, atol=1e-15)
    with pytest.raises(ArgumentError, match=r'\(2, 3, n\)'):
        found.distance_jacobian(J, np.zeros((6, 6)))
