"""Where boxes meet, part by part, against figures drawn on paper and an independent distance."""

import numpy as np
import pytest
from oracles.forms import signed_distance

from drake_geom_ros.geometry._proximity.kernels.closed_forms import box_contact
from drake_geom_ros.geometry._proximity.kinds import BOX
from truth.bodies.random_bodies import random_rotation

ALONG_X, ALONG_Y = (1.0, 0.0), (0.0, 1.0)
ALIGNED = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CUBE = (1.0, 1.0, 1.0)


def axes_of(R):
    """Return the axes of a frame as the kernels take them: three vectors."""
    return tuple(tuple(axis) for axis in R.T.tolist())


def test_vectors_go_from_frame_to_frame_and_back():
    R = random_rotation(np.random.default_rng(1))
    b, v = axes_of(R), (0.3, -0.5, 0.7)
    np.testing.assert_allclose(box_contact.to_first(b, v), R @ v, rtol=0, atol=1e-16)
    np.testing.assert_allclose(box_contact.to_second(b, v), R.T @ v, rtol=0, atol=1e-16)
    a, p = box_contact.seen_from_other(b, v)
    np.testing.assert_array_equal(a, R)
    np.testing.assert_allclose(p, -(R.T @ v), rtol=0, atol=1e-16)


@pytest.mark.parametrize(
    ('c', 'd', 'half_length', 'interval'),
    [
        ((0, 0), ALONG_X, 5.0, (-2.0, 2.0)),
        ((0, 0), ALONG_X, 1.5, (-1.5, 1.5)),
        ((0, 0), (-1.0, 0.0), 5.0, (-2.0, 2.0)),
        ((1, 0.5), ALONG_Y, 5.0, (-1.5, 0.5)),
        ((1, 0.5), (0.6, 0.8), 5.0, (-1.875, 0.625)),
        ((1, 0.5), (0.6, -0.8), 5.0, (-0.625, 1.0 / 0.6)),
        ((0, 1), ALONG_X, 5.0, (-2.0, 2.0)),  # along an edge
        ((2, 0), ALONG_Y, 5.0, (-1.0, 1.0)),
        ((1.5, 0), (1.0, 1e-15), 5.0, (-3.5, 0.5)),  # parallel to rounding
    ],
)
def test_a_line_is_clipped_by_a_rectangle_of_4_by_2(c, d, half_length, interval):
    found = box_contact._clip(tuple(map(float, c)), d, (2.0, 1.0), half_length)
    np.testing.assert_allclose(found, interval, rtol=1e-15)


@pytest.mark.parametrize(
    ('c', 'd'),
    [((0, 1.5), ALONG_X), ((-2.5, 0), ALONG_Y), ((3, 1.5), (0.8, -0.6)), ((9, 0), ALONG_X)],
)
def test_a_line_beside_a_rectangle_is_nowhere_in_it(c, d):
    low, high = box_contact._clip(tuple(map(float, c)), d, (2.0, 1.0), 5.0)
    assert high < low


def test_the_outline_is_what_of_a_rectangle_is_in_another():
    square = (1.0, 1.0)
    assert box_contact._outline(square, square, ALONG_X, ALONG_Y, (0.0, 0.0)) == (8.0, 0.0, 0.0)
    # The left edge, x = 0, and half of the upper and lower ones.
    assert box_contact._outline(square, square, ALONG_X, ALONG_Y, (1.0, 0.0)) == (4.0, 1.0, 0.0)
    # The lower edge, y = 1/4, three quarters of its length, and the left one, x = 0.25.
    found = box_contact._outline(square, square, ALONG_X, ALONG_Y, (1.25, 1.25))
    assert found == pytest.approx((1.5, 0.75 * (0.625 + 0.25), 0.75 * (0.25 + 0.625)))
    # A bar of 4 by 1 across the square, turned by a right angle: its long edges, cut.
    found = box_contact._outline(square, (2.0, 0.5), ALONG_Y, (-1.0, 0.0), (0.25, 0.5))
    assert found == pytest.approx((4.0, 2.0 * 0.75 + 2.0 * -0.25, 0.0))
    assert box_contact._outline(square, square, ALONG_X, ALONG_Y, (3.0, 0.0)) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize('seed', range(6))
def test_the_outline_of_a_turned_rectangle_against_points_on_its_edges(seed):
    rng = np.random.default_rng(seed)
    h, g, c, angle = *rng.uniform(0.5, 1.0, (2, 2)), rng.uniform(-0.7, 0.7, 2), rng.uniform(0, 7)
    u, v = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    t = (np.arange(-5000, 5000) + 0.5) / 5000
    length, moment = 0.0, np.zeros(2)
    for side in (-1.0, 1.0):
        for d, e, along, across in ((u, v, g[0], g[1]), (v, u, g[1], g[0])):
            points = c + side * across * e + along * t[:, None] * d
            within = points[(np.abs(points) <= h).all(axis=1)]
            length += len(within) * along / 5000
            moment += within.sum(axis=0) * along / 5000
    found = box_contact._outline(tuple(h), tuple(g), tuple(u), tuple(v), tuple(c))
    assert found == pytest.approx((length, *moment), abs=2e-3)


@pytest.mark.parametrize(
    ('h', 'g', 'turned', 'c', 'centre'),
    [
        ((1.0, 1.0), (1.0, 1.0), False, (1.0, 0.0), (0.5, 0.0)),
        ((1.0, 1.0), (1.0, 1.0), False, (-1.25, 0.5), (-0.625, 0.25)),
        ((2.0, 0.5), (2.0, 0.25), True, (1.0, 0.2), (1.0, 0.0)),  # two bars that cross
        ((2.0, 0.5), (0.25, 0.125), True, (-1.0, 0.2), (-1.0, 0.2)),  # one in the other
        ((0.25, 0.125), (2.0, 0.5), True, (0.125, 0.2), (0.0, 0.0)),
        ((2.0, 0.5), (0.25, 0.125), False, (2.0, 0.5), (1.875, 0.4375)),
    ],
)
def test_the_centre_of_a_patch(h, g, turned, c, centre):
    u, v = (ALONG_Y, (-1.0, 0.0)) if turned else (ALONG_X, ALONG_Y)
    found, at = box_contact._patch_centre(h, g, u, v, c, 0.0)
    assert found
    np.testing.assert_allclose(at, centre, rtol=0, atol=1e-15)


def test_rectangles_that_touch_count_by_the_slack():
    arguments = (1.0, 1.0), (1.0, 1.0), ALONG_X, ALONG_Y, (2.0 + 1e-12, 0.5)
    assert box_contact._patch_centre(*arguments, 0.0) == (False, (2.0 + 1e-12, 0.5))
    found, at = box_contact._patch_centre(*arguments, 1e-11)
    assert found
    np.testing.assert_allclose(at, (1.0, 0.25), rtol=0, atol=1e-10)


@pytest.mark.parametrize('seed', range(12))
def test_closest_points_are_as_far_as_the_boxes(seed):
    rng = np.random.default_rng(seed)
    h, g = 10 ** rng.uniform(-1, 0, (2, 3))
    R, c = random_rotation(rng), rng.normal(size=3)
    c *= (np.linalg.norm(h) + np.linalg.norm(g)) / np.linalg.norm(c)
    truth, _ = signed_distance((BOX, h), (np.eye(3), np.zeros(3)), (BOX, g), (R, c))
    gap, start = box_contact.closest_points(tuple(h), tuple(g), axes_of(R), tuple(c), 0.0)
    assert np.linalg.norm(gap) == pytest.approx(float(truth), abs=1e-12)
    end = R.T @ (np.add(start, gap) - c)
    assert np.abs(start) / h == pytest.approx(np.minimum(np.abs(start) / h, 1.0), abs=1e-14)
    assert np.abs(end) / g == pytest.approx(np.minimum(np.abs(end) / g, 1.0), abs=1e-14)


def test_closest_points_need_be_no_closer_than_asked():
    far = box_contact.closest_points(CUBE, CUBE, ALIGNED, (2.5, 0.25, 0.0), 0.75)
    assert np.linalg.norm(far[0]) <= 0.75


@pytest.mark.parametrize(
    ('c', 'n', 'point'),
    [
        ((2.0, 0.5, 0.25), (1.0, 0.0, 0.0), (1.0, 0.25, 0.125)),  # face on face
        ((-2.0, 0.5, 0.25), (-1.0, 0.0, 0.0), (-1.0, 0.25, 0.125)),
        ((0.5, 2.0, -0.25), (0.0, 1.0, 0.0), (0.25, 1.0, -0.125)),
        ((0.5, 0.25, -2.0), (0.0, 0.0, -1.0), (0.25, 0.125, -1.0)),
    ],
)
def test_faces_meet_at_the_centre_of_what_they_share(c, n, point):
    found, missed = box_contact.common_point(CUBE, CUBE, ALIGNED, c, n, True, 1e-14)
    np.testing.assert_allclose(found, point, rtol=0, atol=1e-15)
    assert missed <= 1e-15


@pytest.mark.parametrize('slide', [0.0, 0.5, -1.5])
def test_an_edge_on_a_face_meets_it_at_the_middle_of_what_they_share(slide):
    """The second cube stands on an edge along x, which sticks out by what it is slid."""
    s = 2.0**-0.5
    b = (1.0, 0.0, 0.0), (0.0, s, s), (0.0, -s, s)
    c = (slide, 0.25, 1.0 + 2.0**0.5)
    found, missed = box_contact.common_point(CUBE, CUBE, b, c, (0.0, 0.0, 1.0), True, 1e-14)
    np.testing.assert_allclose(found, (0.5 * slide, 0.25, 1.0), rtol=0, atol=1e-14)
    assert missed <= 1e-14


def test_a_corner_on_a_face_meets_it_there():
    R = random_rotation(np.random.default_rng(3))
    lowest = -np.sign(R[2]) @ R.T  # the corner of the cube that is extreme along -z
    c = np.array([0.3, -0.2, 1.0]) - lowest
    found, missed = box_contact.common_point(
        CUBE, CUBE, axes_of(R), tuple(c), (0.0, 0.0, 1.0), True, 1e-14
    )
    np.testing.assert_allclose(found, (0.3, -0.2, 1.0), rtol=0, atol=1e-14)
    assert missed <= 1e-14
