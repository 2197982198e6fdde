"""The truth about solid meshes, where it is plain, and against boxes in 50 digits."""

import numpy as np
import pytest
from mpmath import mp, mpf
from oracles import closed_forms

from drake_geom_ros.cross_check.bodies import Body
from truth.bodies.mesh_bodies import UNIT, mesh_body
from truth.references.meshes import point_distance, signed_distance

L, BALL = mesh_body('L', 1300), mesh_body('Ball', 1300)


def at(body, *p):
    return body.at(np.array(p, dtype=float))


@pytest.mark.parametrize(('p', 'distance'), [
    ((0.2, -0.05, 0.0), 0.1),  # before the end of an arm
    ((0.03, 0.05, 0.0), 0.03),  # in the notch, where the hull says it is inside
    ((-0.04, -0.06, 0.0), -0.04),
    ((0.13, -0.05, 0.09), 0.05),  # an edge, 3 and 4 away
    ((-0.1, 0.05, 0.01), 0.0),
])  # fmt: skip
def test_points(p, distance):
    assert signed_distance(at(Body('Point'), *p), L) == pytest.approx(distance, abs=1e-17)


def test_points_of_boxes_in_fifty_digits():
    rng = np.random.default_rng(3)
    for q in rng.uniform(-0.2, 0.2, (40, 3)):
        least = min(
            closed_forms.point_distance(2, np.array(box.size) / 2, list(map(mpf, q - box.p)))
            for box in L.parts
        )
        found, _ = point_distance(L.corners, list(map(mpf, q)))
        # Within the union no box tells how far its surface is, but that it is as deep.
        assert found <= least + 1e-16
        assert least <= 0.0 or found >= least - 1e-16


def test_a_vertex_of_the_ball_is_told_in_forty_digits():
    vertices = BALL.corners.reshape(-1, 3)
    vertex = vertices[np.argmax(np.linalg.norm(vertices, axis=1))]
    far = list(map(mpf, 2.0 * vertex))
    with mp.workdps(40):
        found, foot = point_distance(BALL.corners, far)
        length = mp.sqrt(sum(mpf(x) ** 2 for x in vertex))
        assert abs(found - length) < mpf(10) ** -35
    np.testing.assert_allclose(foot, vertex, rtol=0, atol=1e-16)


def test_spheres_go_straight_out_or_nothing_is_known():
    ball = Body('Sphere', (0.02,))
    assert signed_distance(at(ball, -0.095, 0.03, 0.0), L) == pytest.approx(-0.025)
    assert signed_distance(at(ball, -0.06, 0.0, 0.0), L) == pytest.approx(-0.06)
    # In the inner corner, in both walls: straight out of one is into the other.
    assert signed_distance(at(ball, 0.01, 0.01, 0.0), L) is None


def test_boxes_and_the_l_itself():
    box = Body('Box', (0.02, 0.02, 0.02))
    assert signed_distance(at(box, 0.05, 0.06, 0.0), L) == pytest.approx(0.04)
    assert signed_distance(at(box, -0.1, 0.03, 0.0), L) == pytest.approx(-0.01)
    assert signed_distance(at(box, 0.005, 0.005, 0.0), L) is None
    assert signed_distance(at(L, 2 * UNIT, 0.0, 0.01), L) == pytest.approx(0.0, abs=1e-17)
    assert signed_distance(at(L, 0.19, 0.0, 0.0), L) == pytest.approx(-0.01)
    half_turn = np.diag([-1.0, -1.0, 1.0])
    turned = L.placed(half_turn, np.array([0.11, 0.11, 0.0]))
    assert signed_distance(turned, L) == pytest.approx(0.01 * 2**0.5)
