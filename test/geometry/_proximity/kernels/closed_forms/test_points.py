"""Signed distance from a point to each primitive."""

import numpy as np
import pytest
from numba import config
from oracles import closed_forms
from oracles.forms import PARAMETERS
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.cross_check.surfaces import height_of
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms import points, spheres
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
    ShapeKind,
)
from truth.tolerances import EPS

SAMPLES = 10 if config.DISABLE_JIT else 120
S3 = np.sqrt(3.0)


def _outward_normal(kind, size, p_GN):
    """Normal of a surface that is smooth at p_GN; None where it is not smooth everywhere."""
    if kind == ELLIPSOID:
        n = p_GN / size**2
    elif kind == SPHERE:
        n = p_GN
    elif kind == CAPSULE:
        n = p_GN - [0.0, 0.0, np.clip(p_GN[2], -size[1], size[1])]
    else:
        return None
    return n / np.linalg.norm(n)


def _row(kind, size, q):
    """Return the row of a ball without radius at q against the shape: a point query."""
    out = np.full(PAIR_WIDTH, np.nan)
    kernel = getattr(spheres, f'sphere_{ShapeKind(kind).name.lower()}')
    axes = np.eye(3)
    asked = SPHERE, np.zeros(1), axes, kind, size, axes, -q
    call_for_pair(kernel, *asked, 0.0, np.inf, out)
    return out


def _query(kind, size, q):
    """Call a point kernel, check its row against truth and laws, and return its parts."""
    size, q = np.array(size, dtype=float), np.array(q, dtype=float)
    out = _row(kind, size, q)
    assert np.all(np.isfinite(out)), (kind, size, q)
    distance, grad = out[DISTANCE], out[NORMAL : NORMAL + 3]
    p_GN = q + out[WITNESS_B : WITNESS_B + 3]
    error_bound, unique = out[ERROR_BOUND], bool(out[UNIQUE])
    truth = closed_forms.point_distance(kind, size, q)
    extent = size.sum() + np.linalg.norm(q)
    case = (kind, size, q, out, float(truth))
    assert abs(float(truth - distance)) <= error_bound <= 100 * EPS * extent, case
    assert abs(np.linalg.norm(grad) - 1) <= 1e-14, case
    np.testing.assert_allclose(
        q - p_GN, distance * grad, rtol=0, atol=16 * EPS * extent, err_msg=str(case)
    )
    assert abs(height_of((kind, size), p_GN)) <= 16 * EPS * extent, case
    normal = _outward_normal(kind, size, p_GN)
    if normal is not None:
        # p_GN comes measured from the point, and a far one costs it digits.
        least = size.min() if kind == ELLIPSOID else size[0]
        lost = 16 * EPS * extent * size.max() / least**2
        np.testing.assert_allclose(grad, normal, rtol=0, atol=1e-13 + lost, err_msg=str(case))
    return distance, grad, p_GN, unique


@pytest.mark.parametrize('kind', [1, 2, 3, 4, 5, 6])
def test_truth_and_laws(kind):
    rng = np.random.default_rng(kind)
    for k in range(SAMPLES):
        scale = (1e-6, 1e-3, 1.0, 1e3, 1e6)[k % 5]
        spread = 3.0 if k % 3 == 0 else 0.5
        size = scale * 10 ** rng.uniform(-spread, 0, PARAMETERS[kind])
        q = scale * rng.normal(size=3) * 10 ** rng.uniform(-6, 1 if k % 7 else 6)
        q[rng.random(3) < 0.25] = 0.0
        _query(kind, size, q)


@pytest.mark.parametrize('kind', [1, 2, 3, 4, 5, 6])
def test_close_to_the_surface(kind):
    """From 1e-1 down to 1e-16 on either side of points of the surface, edges included."""
    rng = np.random.default_rng(10 + kind)
    for _ in range(SAMPLES):
        size = 10 ** rng.uniform(-1, 0, PARAMETERS[kind])
        _, _, p_GN, _ = _query(kind, size, rng.normal(size=3))
        _query(kind, size, p_GN + rng.normal(size=3) * 10 ** rng.uniform(-16, -1))


@pytest.mark.parametrize(
    ('kind', 'size', 'q', 'distance', 'grad', 'unique'),
    [
        (SPHERE, [0.25], [0, 0, 0], -0.25, [1, 0, 0], False),
        (SPHERE, [0.25], [0, 1e-300, 0], -0.25, [0, 1, 0], False),
        (SPHERE, [0.25], [0, 0, -1e-12], -0.25, [0, 0, -1], True),
        (SPHERE, [0.25], [0, 0.25, 0], 0.0, [0, 1, 0], True),
        (BOX, [0.5, 0.5, 0.5], [0, 0, 0], -0.5, [1, 0, 0], False),
        (BOX, [0.5, 0.5, 0.5], [0, 0.5, 0], 0.0, [0, 1, 0], True),
        (BOX, [0.5, 0.5, 0.5], [0, 0.5, -0.5], 0.0, [0, 1, 0], False),
        (BOX, [0.5, 0.5, 0.5], [0.5, 0.5, 0.5], 0.0, [1, 0, 0], False),
        (BOX, [0.5, 0.5, 0.5], [0, 0, 1e-9 - 0.5], -1e-9, [0, 0, -1], True),
        (BOX, [0.5, 0.5, 0.5], [0.5 + 2**-50] * 3, 2**-50 * S3, [1 / S3] * 3, False),
        (BOX, [0.5, 0.5, 0.5], [0.5 + 1e-12, 0.5, 0], 1e-12, [1, 0, 0], True),
        (BOX, [1.0, 1.0, 1.0], [3, 2, 2], np.sqrt(6.0), np.array([2, 1, 1]) / 6**0.5, True),
        (CAPSULE, [0.1, 0.5], [0, 0, 0.2], -0.1, [1, 0, 0], False),
        (CAPSULE, [0.1, 0.5], [0, 0, 0.5], -0.1, [1, 0, 0], False),
        (CAPSULE, [0.1, 0.5], [0, 0.1, 0.2], 0.0, [0, 1, 0], True),
        (CAPSULE, [0.1, 0.5], [0, 0, -0.6], 0.0, [0, 0, -1], True),
        (CAPSULE, [0.1, 0.0], [0, 0, 0], -0.1, [1, 0, 0], False),
        (CYLINDER, [0.25, 0.5], [0, 0, 0], -0.25, [1, 0, 0], False),
        (CYLINDER, [0.25, 0.5], [0, 0, 0.4], -0.1, [0, 0, 1], True),
        (CYLINDER, [0.25, 0.5], [0, 0.25, 0.5], 0.0, [0, 1, 0], False),
        (CYLINDER, [0.25, 0.5], [0.25 + 1e-9, 0, 0.5 + 1e-9], 1e-9 * 2**0.5, None, True),
        (CYLINDER, [0.25, 0.1], [0, 0.1, 0], -0.1, [0, 0, 1], False),
        (CYLINDER, [0.25, 0.5], [0.1, 0, 0.5], 0.0, [0, 0, 1], True),
        (HALF_SPACE, [], [1, 2, 0], 0.0, [0, 0, 1], True),
        (HALF_SPACE, [], [0, 0, -1e3], -1e3, [0, 0, 1], True),
    ],
)
def test_documented_choice(kind, size, q, distance, grad, unique):
    found = _query(kind, size, q)
    assert found[0] == pytest.approx(distance, rel=1e-6, abs=1e-16)
    if grad is not None:
        np.testing.assert_allclose(found[1], grad, rtol=0, atol=1e-15)
    assert found[3] == unique


@pytest.mark.parametrize(
    ('q', 'on_box', 'on_cylinder'),
    [
        ((0.1, 0.0, 0.5 + 1e-7), True, True),  # nearer to a cap than the slack
        ((0.25 + 1e-7, 0.0, 0.1), True, True),
        ((0.25 + 1e-7, 0.0, 0.5 + 1e-7), False, False),
        ((0.25 + 1e-5, 0.0, 0.5 + 1e-5), True, True),
        ((0.25 - 1e-7, 0.0, 0.5 + 1e-7), False, False),
        ((0.25 - 1e-5, 0.0, 0.5 + 1e-7), True, True),
        ((0.25 + 1e-7, 0.0, 0.5 - 1e-5), True, True),
        ((0.15, 0.0, 0.4), False, False),
        ((0.15, 0.0, 0.4 + 3e-7), False, False),
        ((0.15, 0.0, 0.4 - 3e-7), False, False),
        ((0.15, 0.0, 0.4 + 3e-6), True, True),
        ((0.15, 0.0, 0.4 - 3e-6), True, True),
        ((3e-7, 0.0, 0.1), False, False),
        ((3e-6, 0.0, 0.1), True, True),
    ],
)
def test_what_counts_as_equally_near_is_the_slack(q, on_box, on_cylinder):
    """1e-6 m here; a box as high as the cylinder and as wide, but long."""
    assert points.box_point((0.25, 9.0, 0.5), q, 1e-6)[3] == on_box
    assert points.cylinder_point(0.25, 0.5, q, 1e-6)[3] == on_cylinder


@pytest.mark.parametrize(
    ('size', 'q', 'distance', 'grad', 'unique'),
    [
        ((0.25, 0.25, 0.25), [0, 0, 0], -0.25, [1, 0, 0], False),
        ((0.25, 0.25, 0.26), [0, 0, 0], -0.25, [1, 0, 0], False),
        ((0.25, 0.25, 0.25 + 1e-7), [0, 0, 0], -0.25, [1, 0, 0], False),
        ((0.25, 0.24, 0.25), [0, 0, 0], -0.24, [0, 1, 0], False),
        ((0.25, 0.25, 0.26), [0, 1e-6, 0], 1e-6 - 0.25, [0, 1, 0], True),
        ((0.25, 0.25, 0.26), [0, -1e-3, 0], 1e-3 - 0.25, [0, -1, 0], True),
        ((0.3, 0.2, 0.1), [0, 0, 0], -0.1, [0, 0, 1], False),
        ((0.3, 0.2, 0.1), [0.29, 0, 0], -0.01, [1, 0, 0], True),
        ((0.3, 0.2, 0.1), [0.3, 0, 0], 0.0, [1, 0, 0], True),
        ((0.3, 0.2, 0.1), [0.3 + 1e-9, 0, 0], 1e-9, [1, 0, 0], True),
        ((1e-3, 1e-3, 1.0), [0, 0, 1.01], 0.01, [0, 0, 1], True),
        ((1.0, 1.0, 1e-3), [0, 0, 0], -1e-3, [0, 0, 1], False),
        ((1e-6, 1e-6, 1e-6), [0, 0, 0], -1e-6, [1, 0, 0], False),
        ((0.3, 0.2, 0.1), [1e6, 0, 0], 1e6 - 0.3, [1, 0, 0], True),
    ],
)
def test_ellipsoid_where_peers_hang(size, q, distance, grad, unique):
    found = _query(ELLIPSOID, size, q)
    assert found[0] == pytest.approx(distance, rel=1e-6, abs=1e-16)
    np.testing.assert_allclose(found[1], grad, rtol=0, atol=1e-15)
    assert found[3] == unique


ELLIPSOIDS = [
    (0.3, 0.2, 0.1),
    (0.25, 0.25, 0.26),
    (0.25, 0.26, 0.26),
    (1e-3, 1e-3, 1.0),
    (1.0, 1e-3, 1.0),
    (1e-3, 0.03, 1.0),
    (1e-6, 2e-6, 3e-6),
]


@pytest.mark.parametrize('size', ELLIPSOIDS)
def test_ellipsoid_on_and_about_the_focal_ellipse(size):
    """Within it, in the plane across the shortest axis, two mirror images are nearest."""
    size = np.array(size)
    across = int(np.argmin(size))
    # Centres of curvature of that plane's normals: where the mirror images begin to part.
    focal = (size**2 - size[across] ** 2) / size
    for angle in np.linspace(0.0, 2 * np.pi, 3 if config.DISABLE_JIT else 4):
        for shrink in (0.0, 0.5, 1 - 1e-6, 1 - 1e-12, 1.0, 1 + 1e-15, 1 + 1e-6):
            for off in (0.0, 1e-300, 1e-30, 1e-17, 1e-12, -1e-9):
                turn = np.roll([0.0, np.cos(angle), np.sin(angle)], across)
                q = shrink * focal * turn
                q[across] = off * size[across]
                unique = _query(ELLIPSOID, size, q)[3]
                inside = shrink <= 0.5
                if inside and abs(off) < 1e-16:
                    assert not unique
                if inside and abs(off) > 1e-10 and np.sum(size == size[across]) == 1:
                    assert unique


def test_ellipsoid_answers_for_extreme_numbers():
    """Any finite input ends, without overflow, with laws kept."""
    for size in ((1e-100, 1.0, 1e100), (1e-6, 1e6, 1.0), (1e-150,) * 3, (1e150, 1e150, 1e149)):
        for q in ([0, 0, 0], [1e-200, 1e-100, 0], [1.0, 0, -1.0], [1e120, 1.0, 1e-120]):
            out = _row(ELLIPSOID, np.array(size), np.array(q, dtype=float))
            assert np.all(np.isfinite(out))
            assert np.linalg.norm(out[NORMAL : NORMAL + 3]) == pytest.approx(1.0, abs=1e-14)


def test_the_oracle_of_ellipsoids_against_their_dense_surface():
    """No point of a fine grid on the surface is nearer than the oracle says, and one is close."""
    rng = np.random.default_rng(3)
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 400), np.linspace(0, 2 * np.pi, 800))
    sphere = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1
    )
    for k in range(20):
        size = 10 ** rng.uniform(-1, 0, 3)
        q = size * rng.normal(size=3) * rng.uniform(0, 0.8)
        q[k % 3] *= k % 2
        truth = float(closed_forms.point_distance(ELLIPSOID, size, q))
        nearest = np.linalg.norm(size * sphere - q, axis=-1).min()
        assert abs(truth) - 1e-12 <= nearest <= abs(truth) + 1e-3
        assert (truth < 0) == (np.sum((q / size) ** 2) < 1)
