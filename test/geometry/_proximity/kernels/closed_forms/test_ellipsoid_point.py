"""Points and an ellipsoid: the same in every octant and for every order of the axes."""

import itertools

import numpy as np
import pytest
from oracles import closed_forms

from drake_geom_ros.geometry._proximity.kernels.closed_forms.ellipsoid_point import (
    ellipsoid_point,
)

ORDERS = [list(order) for order in itertools.permutations(range(3))]
SIGNS = [np.array(signs) for signs in itertools.product((1.0, -1.0), repeat=3)]
SLACK = 1e-15


def answer(e, q, slack=SLACK):
    distance, grad, p_GN, unique = ellipsoid_point(tuple(e), tuple(q), slack)
    return distance, np.array(grad), np.array(p_GN), unique


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize(
    'q',
    [
        *((0.25, 0.15, 0.2), (0.05, 0.04, 0.03), (0.31, 0.01, 0.001), (2.0, 3.0, 5.0)),
        *((0.25, 0.1, 0.0), (0.0, 0.19, 0.0), (0.28, 0.0, 0.0)),  # beyond the focal ellipse
    ],
)
def test_every_octant_and_order_of_the_axes(q, order):
    """Where (q - N) is along the normal at N of the surface, and N is the nearest such point."""
    e, q = np.array([0.3, 0.2, 0.1]), np.array(q)
    truth = float(closed_forms.point_distance(closed_forms.ELLIPSOID, e, q))
    for signs in SIGNS:
        distance, grad, p_GN, unique = answer(e[order], (signs * q)[order])
        assert distance == pytest.approx(truth, rel=1e-15, abs=1e-15)
        np.testing.assert_allclose((signs * q)[order] - p_GN, distance * grad, rtol=0, atol=4e-15)
        normal = p_GN / e[order] ** 2
        np.testing.assert_allclose(grad, normal / np.linalg.norm(normal), rtol=0, atol=1e-14)
        assert np.sum((p_GN / e[order]) ** 2) == pytest.approx(1.0, abs=1e-14)
        assert unique


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize(
    ('q', 'image'),
    [
        # x = e_x^2 q_x / (e_x^2 - e_z^2) in the plane across the shortest axis.
        ((0.16, 0.0, 0.0), (0.18, 0.0, 0.08)),
        ((0.16, 0.0, 1e-300), (0.18, 0.0, 0.08)),
        ((0.0, 0.06, 0.0), (0.0, 0.08, 0.1 * 0.84**0.5)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.1)),
    ],
)
def test_of_two_mirror_images_the_positive_side_is_taken(q, image, order):
    e, q, image = np.array([0.3, 0.2, 0.1]), np.array(q), np.array(image)
    distance, grad, p_GN, unique = answer(e[order], q[order])
    assert distance == pytest.approx(-np.linalg.norm(q - image), abs=1e-15)
    np.testing.assert_allclose(p_GN, image[order], rtol=0, atol=2e-15)
    np.testing.assert_allclose(
        grad, (image - q)[order] / np.linalg.norm(image - q), rtol=0, atol=1e-14
    )
    assert not unique


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize('off', [1e-9, -1e-9])
def test_a_mirror_image_counts_as_equal_within_the_slack_only(off, order):
    e, q = np.array([0.3, 0.2, 0.1])[order], np.array([0.16, 0.03, off])[order]
    assert answer(e, q)[3]
    # The images differ by 2 |off| n_z in distance, n_z being about 0.8.
    assert answer(e, q, 1.2e-9)[3]
    assert not answer(e, q, 3e-9)[3]
    outside = np.array([0.16, 0.03, 1.0])[order]
    assert answer(e, outside, 0.1)[3]


def test_of_equal_shortest_axes_the_first_is_taken():
    for e, axis in (
        ((1, 1, 1), 0),
        ((2, 1, 1), 1),
        ((1, 2, 1), 0),
        ((1, 1, 2), 0),
        ((2, 2, 1), 2),
    ):
        distance, grad, p_GN, unique = answer(np.array(e, dtype=float), (0.0, 0.0, 0.0))
        assert (distance, unique) == (-1.0, False)
        assert grad.tolist() == p_GN.tolist() == np.eye(3)[axis].tolist()


@pytest.mark.parametrize('order', ORDERS)
@pytest.mark.parametrize('ratio', [1e-3, 1e-6, 1e-9])
def test_needles_and_disks_keep_their_digits(ratio, order):
    """On the way from the middle of a face the answer is known: the semi-axis."""
    for e in (np.array([1.0, 1.0, ratio]), np.array([1.0, ratio, ratio])):
        for height in (0.5 * ratio, 2.0 * ratio, 1.0):
            distance, grad, _, _ = answer(e[order], np.array([0.0, 0.0, height])[order])
            assert distance == pytest.approx(height - ratio, rel=1e-14, abs=1e-16 * ratio)
            np.testing.assert_allclose(grad, np.array([0.0, 0.0, 1.0])[order], rtol=0, atol=1e-15)
