import numpy as np
import pytest
from oracles.pairs import random_rotation

from drake_geom_ros.evidence.truth.convex import signed_distance
from drake_geom_ros.geometry._proximity.kernels import epa
from drake_geom_ros.geometry._proximity.kernels.sums import difference_of
from drake_geom_ros.geometry._proximity.kernels.supports import BOX, CONVEX, CYLINDER

ALIGNED = np.eye(3)
X = (1.0, 0.0, 0.0)


def _grow(kind_A, shape_A, kind_B, shape_B, R_WB, p, tolerance=1e-9, most_vertices=400, n=None):
    shape_A, shape_B = np.array(shape_A, dtype=float), np.array(shape_B, dtype=float)
    size = np.abs(shape_A).sum() + np.abs(shape_B).sum() + np.linalg.norm(p)
    pair = kind_A, shape_A, ALIGNED, kind_B, shape_B, R_WB, tuple(map(float, p))
    return epa.depth_of_cores(
        *(pair, difference_of(pair), n or X, n is not None, size, tolerance, most_vertices)
    )


@pytest.mark.parametrize(
    ('p', 'depth', 'unique'),
    [
        ((0, 0, 0), 1.0, False),
        ((0.75, 0, 0), 0.25, True),
        ((0.75, 0.75, 0), 0.25, False),
        ((1, 0, 0), 0.0, True),
        ((1, 0.5, -0.25), 0.0, True),
    ],
)
def test_cubes_end_exactly_overlapping_or_touching(p, depth, unique):
    upper, lower, n, a, b, _, is_unique = _grow(BOX, [0.5] * 3, BOX, [0.5] * 3, ALIGNED, p)
    assert upper == pytest.approx(depth, abs=1e-15)
    assert lower == pytest.approx(depth, abs=1e-15)
    assert np.subtract(a, b) == pytest.approx(upper * np.array(n), abs=1e-15)
    assert np.abs(n).max() == pytest.approx(1, abs=1e-15)
    assert is_unique == unique


def test_hulls_end_exactly():
    rng = np.random.default_rng(3)
    for _ in range(6):
        hulls = [np.concatenate(([k], rng.normal(size=3 * k))) for k in (10, 16)]
        R, p = random_rotation(rng), 0.3 * rng.normal(size=3)
        phi, _ = signed_distance(
            (CONVEX, hulls[0]), (ALIGNED, [0, 0, 0]), (CONVEX, hulls[1]), (R, p)
        )
        upper, lower, n, *_ = _grow(CONVEX, hulls[0], CONVEX, hulls[1], R, p, tolerance=0.0)
        assert upper - lower <= 1e-13
        assert -phi == pytest.approx(upper, abs=1e-11)
        hint = np.add(n, 0.1 * rng.normal(size=3))
        hint = tuple(hint / np.linalg.norm(hint))
        again, *_ = _grow(CONVEX, hulls[0], CONVEX, hulls[1], R, p, tolerance=0.0, n=hint)
        assert again == pytest.approx(upper, abs=1e-13)


@pytest.mark.parametrize('most_vertices', [5, 8, 20, 60])
def test_bounds_hold_when_the_cap_ends_the_growth(most_vertices):
    rng = np.random.default_rng(4)
    for _ in range(6):
        R, p = random_rotation(rng), 0.2 * rng.normal(size=3)
        phi, _ = signed_distance(
            (CYLINDER, [0.4, 0.5]), (ALIGNED, [0, 0, 0]), (CYLINDER, [0.3, 0.6]), (R, p)
        )
        upper, lower, *_ = _grow(
            CYLINDER, [0.4, 0.5], CYLINDER, [0.3, 0.6], R, p, 0.0, most_vertices
        )
        assert -phi <= upper + 1e-12
        assert lower <= 0 or lower <= -phi + 1e-12
        if most_vertices == 60:
            assert upper - lower <= 1e-6


def test_a_tighter_tolerance_narrows_the_bounds():
    R = random_rotation(np.random.default_rng(5))
    gaps = []
    for tolerance in (1e-2, 1e-5, 1e-8):
        upper, lower, *_ = _grow(
            CYLINDER, [0.4, 0.5], CYLINDER, [0.3, 0.6], R, (0.3, 0.2, 0.1), tolerance
        )
        gaps.append(upper - lower)
        assert gaps[-1] <= tolerance
    assert gaps[2] < gaps[0]


def test_a_guess_of_overlap_ends_where_the_cores_are_apart():
    n = (0.6, 0.8, 0.0)
    upper, lower, *_ = _grow(BOX, [0.5] * 3, CYLINDER, [0.2, 0.3], ALIGNED, (2.0, 0.0, 0.0), n=n)
    assert lower <= upper < -0.1


def test_a_cap_is_left_where_a_face_may_be_nearer_beyond_it():
    n, m = (0.0, 0.0, 1.0), (0.0, np.sin(0.2), np.cos(0.2))
    assert not epa.is_in_cap(m, 0.9, n, 1.0, 0.0)
    assert not epa.is_in_cap(m, -0.1, n, 1.0, 0.8)
    # Nearer than 1 within acos(0.9) = 0.451 of m, which is 0.2 from n.
    assert epa.is_in_cap(m, 0.9, n, 1.0, 0.66)
    assert not epa.is_in_cap(m, 0.9, n, 1.0, 0.64)
