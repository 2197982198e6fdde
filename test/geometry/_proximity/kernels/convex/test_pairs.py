"""The iterative kernel against the support-function oracle, and the laws of a result row."""

import numpy as np
import pytest
from numba import config
from oracles.body_truth import apart
from oracles.forms import ALIGNED, row_of
from oracles.kernel_calls import call_for_pair
from oracles.pairs import check_row, off_surfaces, pair_of, random_pairs, turned
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.bodies import Pair
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    ITERATIVE,
)
from truth.bodies.random_bodies import random_rotation
from truth.judging.laws import lacking
from truth.references.convex import signed_distance

ROWS = {
    'box_cylinder': (BOX, CYLINDER),
    'box_ellipsoid': (BOX, ELLIPSOID),
    'capsule_cylinder': (CAPSULE, CYLINDER),
    'capsule_ellipsoid': (CAPSULE, ELLIPSOID),
    'cylinder_cylinder': (CYLINDER, CYLINDER),
    'cylinder_ellipsoid': (CYLINDER, ELLIPSOID),
    'ellipsoid_ellipsoid': (ELLIPSOID, ELLIPSOID),
}
COUNT = 2 if config.DISABLE_JIT else 8
LYING = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # the z axis along x


def _turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def _truth(pair):
    return signed_distance(pair.a, pair.b)[0]


def _evaluate(pair, *options, **named):
    return row_of(pair.a, pair.b, *options, **named, kernel=convex.signed_distance_of_cores)


def _check(pair, tolerance=1e-9):
    """Evaluate a pair and check the laws that need no truth; return the row."""
    out = _evaluate(pair, tolerance)
    bound, rounding = out[calling.ERROR_BOUND], 1e-14 * pair.extent
    check_row(out, rounding)
    assert -lacking(pair, out[0], out[1:4]) <= bound + rounding, pair
    assert off_surfaces(pair, out) <= 8 * bound + rounding, pair
    return out


@pytest.mark.parametrize('name', ROWS)
def test_random_poses_at_every_scale(name):
    rng = np.random.default_rng(11)
    for pair in random_pairs(rng, ROWS[name], COUNT + 2):
        phi = _truth(pair)
        for scale in (1e-6, 1e-3, 1.0, 1e3, 1e6):
            row = _check(pair.scaled(scale), 1e-9 * scale)
            slack = 2e-12 * scale * pair.extent
            assert abs(row[0] - scale * phi) <= row[calling.ERROR_BOUND] + slack, pair
            assert row[calling.ERROR_BOUND] <= 4e-9 * scale, pair


@pytest.mark.parametrize('name', ROWS)
@pytest.mark.parametrize('gap', [0.2, 2e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_gaps_are_found_along_any_normal(name, gap):
    """Two support points moved apart by a gap are the closest points: no oracle is needed."""
    rng = np.random.default_rng(12)
    for pair in random_pairs(rng, ROWS[name], COUNT):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        pair = Pair(pair.a, apart(pair.a, pair.b, n, gap))
        row = _check(pair)
        assert abs(row[0] - gap) <= row[calling.ERROR_BOUND] + 1e-15, pair
        if gap > 1e-4:
            assert row[1:4] == pytest.approx(-n, abs=1e-4)


@pytest.mark.parametrize('gap', [1e-2, 1e-4, 1e-6, 1e-8, 1e-11])
@pytest.mark.parametrize('kinds', [*ROWS.values(), (BOX, BOX), (BOX, CAPSULE), (CAPSULE, CAPSULE)])
def test_the_reported_normal_proves_the_distance(kinds, gap):
    """Of bodies almost side by side b - a has few digits: it proved 5e-11 less than the bound."""
    rng = np.random.default_rng(21)
    for pair in random_pairs(rng, kinds, 2 * COUNT):
        almost = pair.a.R @ Rotation.from_rotvec(rng.normal(size=3) * 1e-6).as_matrix()
        n = pair.a.R[:, rng.integers(3)] + rng.normal(size=3) * 10.0 ** rng.uniform(-12, -1)
        b = pair.b.placed(almost if rng.random() < 0.5 else pair.b.R, pair.b.p)
        pair = Pair(pair.a, apart(pair.a, b, n / np.linalg.norm(n), gap))
        out = row_of(pair.a, pair.b)
        proved = lacking(pair, out[calling.DISTANCE], out[1:4])
        assert proved <= out[calling.ERROR_BOUND] + 1e-14 * pair.extent, pair


CUBE, TALL, COIN = (0.5, 0.5, 0.5), (0.25, 0.5), (0.08, 0.001)
TRI, ROUND, NEAR_ROUND = (0.3, 0.2, 0.1), (0.15, 0.15, 0.15), (0.25, 0.25, 0.26)
PANCAKE, NEEDLE = (1.0, 1.0, 0.001), (0.001, 0.001, 1.0)
C, E = CYLINDER, ELLIPSOID
SPECIAL = {
    'cylinder in box': (BOX, CUBE, ALIGNED, C, (0.1, 0.1), ALIGNED, (0.3, 0, 0), -0.3),
    'ellipsoid in box': (BOX, CUBE, ALIGNED, E, (0.1, 0.1, 0.1), ALIGNED, (0.3, 0, 0), -0.3),
    'coaxial box and cylinder': (BOX, CUBE, ALIGNED, C, TALL, ALIGNED, (0, 0, 0), -0.75),
    'needle in cylinder': (
        (BOX, (5e-4, 5e-4, 0.5), ALIGNED, C, TALL, ALIGNED, (0, 0, 0), -0.2505)
    ),
    'coin on tray': (BOX, (0.245, 0.315, 0.0075), LYING @ LYING, C, COIN, ALIGNED,
                     (0.1, 0, 0.0085), 0.0),
    'cylinder on huge box, apart': (BOX, (5e3,) * 3, ALIGNED, C, (0.5, 0.5), ALIGNED,
                                    (3, 4, 5e3 + 0.5 + 2**-10), 2**-10),
    'cylinder on huge box, in': (BOX, (5e3,) * 3, ALIGNED, C, (0.5, 0.5), ALIGNED,
                                 (3, 4, 5e3 + 0.5 - 2**-10), -(2**-10)),
    'cylinder lying on box, apart': (BOX, CUBE, ALIGNED, C, TALL, LYING, (0, 0, 0.751), 1e-3),
    'cylinder lying on box, in': (BOX, CUBE, ALIGNED, C, TALL, LYING, (0, 0, 0.749), -1e-3),
    'ellipsoid on box, touching': (BOX, CUBE, ALIGNED, E, TRI, ALIGNED, (0.8, 0, 0), 0.0),
    'ellipsoid on box, in': (BOX, CUBE, ALIGNED, E, TRI, ALIGNED, (0.8 - 1e-6, 0, 0), -1e-6),
    'capsule end on cylinder axis': (CAPSULE, (0.2, 1), ALIGNED, C, (1, 10), ALIGNED,
                                     (0, 0, 10), -1.2),
    'capsule across cylinder side': (CAPSULE, (0.1, 2), LYING, C, (0.5, 2), ALIGNED,
                                     (0, 0.55, 0), -0.05),
    'capsule over disk': (CAPSULE, (0.01, 0.05), ALIGNED, C, (0.2, 0.005), ALIGNED,
                          (0.1, 0, 0.1), 0.035),
    'capsule crossed on side': (CAPSULE, (0.1, 1), LYING, C, (0.2, 1), ALIGNED,
                                (0, 0.301, 0), 1e-3),
    'capsule touching cylinder': (CAPSULE, (0.1, 1), ALIGNED, C, TALL, ALIGNED,
                                  (0.35, 0, 0), 0.0),
    'capsule coaxial in spheroid': (CAPSULE, (0.05, 0.2), ALIGNED, E, (0.1, 0.1, 0.3), ALIGNED,
                                    (0, 0, 0), -0.15),
    'capsule through ball': (CAPSULE, (0.05, 0.2), LYING, E, ROUND, ALIGNED, (0.1, 0, 0), -0.2),
    'capsule touching ellipsoid': (CAPSULE, (0.05, 0.2), ALIGNED, E, TRI, ALIGNED,
                                   (0.35, 0, 0.1), 0.0),
    'same cylinder': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0, 0, 0), -0.5),
    'side by side, apart': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0.501, 0, 0), 1e-3),
    'side by side, touching': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0.5, 0, 0), 0.0),
    'side by side, in': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0.499, 0, 0), -1e-3),
    'stacked, apart': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0, 0, 1.001), 1e-3),
    'stacked, in': (C, TALL, ALIGNED, C, TALL, ALIGNED, (0, 0, 0.999), -1e-3),
    'crossed, touching': (C, TALL, ALIGNED, C, TALL, LYING, (0, 0.5, 0), 0.0),
    'crossed, in': (C, TALL, ALIGNED, C, TALL, LYING, (0, 0.499, 0), -1e-3),
    'sliding disks': (C, (0.25, 0.05), ALIGNED, C, (0.25, 0.05), ALIGNED, (0.3, 0, 0), -0.1),
    'sliding disks, late': (C, (0.25, 0.05), ALIGNED, C, (0.25, 0.05), ALIGNED,
                            (0.45, 0, 0), -0.05),
    'disks past each other': (C, (0.25, 0.05), ALIGNED, C, (0.25, 0.05), ALIGNED,
                              (0.8, 0, 0), 0.3),
    'coaxial cylinder and spheroid': (C, (0.05, 0.2), ALIGNED, E, (0.1, 0.1, 0.3), ALIGNED,
                                      (0, 0, 0), -0.15),
    'cylinder touching ellipsoid': (C, TALL, ALIGNED, E, TRI, ALIGNED, (0.55, 0, 0), 0.0),
    'ellipsoids along x, apart': (E, TRI, ALIGNED, E, TRI, ALIGNED, (0.601, 0, 0), 1e-3),
    'ellipsoids along x, touching': (E, TRI, ALIGNED, E, TRI, ALIGNED, (0.6, 0, 0), 0.0),
    'ellipsoids along x, in': (E, TRI, ALIGNED, E, TRI, ALIGNED, (0.6 - 1e-6, 0, 0), -1e-6),
    'same pancake': (E, PANCAKE, ALIGNED, E, PANCAKE, ALIGNED, (0, 0, 0), -0.002),
    'same needle': (E, NEEDLE, ALIGNED, E, NEEDLE, ALIGNED, (0, 0, 0), -0.002),
    'crossed needles': (E, NEEDLE, ALIGNED, E, NEEDLE, LYING, (0, 0, 0), -0.002),
    'same ellipsoid': (E, TRI, ALIGNED, E, TRI, ALIGNED, (0, 0, 0), -0.2),
    'concentric balls': (E, ROUND, ALIGNED, E, (0.2, 0.2, 0.2), ALIGNED, (0, 0, 0), -0.35),
    'almost balls': (E, NEAR_ROUND, ALIGNED, E, NEAR_ROUND, ALIGNED, (0, 0, 0), -0.5),
    'balls apart': (E, ROUND, ALIGNED, E, (0.2, 0.2, 0.2), ALIGNED, (0.6, 0, 0.8), 0.65),
    'same small ellipsoid': (E, (1e-6, 2e-6, 3e-6), ALIGNED, E, (1e-6, 2e-6, 3e-6), ALIGNED,
                             (0, 0, 0), -2e-6),
    'small on large': (E, (1e3, 1e3, 1e3), ALIGNED, E, (1e-3, 2e-3, 1e-3), ALIGNED,
                       (1e3, 0, 0), -1e-3),
}  # fmt: skip
MANY_AS_GOOD = {
    'coaxial box and cylinder', 'needle in cylinder', 'capsule end on cylinder axis',
    'capsule coaxial in spheroid', 'capsule through ball', 'same cylinder',
    'coaxial cylinder and spheroid', 'same pancake', 'same needle', 'crossed needles',
    'same ellipsoid', 'concentric balls', 'almost balls', 'same small ellipsoid',
    'sliding disks',
}  # fmt: skip


@pytest.mark.parametrize('name', SPECIAL)
@pytest.mark.parametrize('scale', [1e-6, 1.0, 1e4])
@pytest.mark.parametrize('turn', [0, 1])
def test_special_position(name, scale, turn):
    *bodies, distance = SPECIAL[name]
    pair = pair_of(*bodies).scaled(scale)
    if turn:
        pair = turned(pair, random_rotation(np.random.default_rng(13)))
    row = _check(pair, 1e-9 * scale)
    rounding = 2e-15 * pair.extent
    assert abs(row[0] - scale * distance) <= row[calling.ERROR_BOUND] + rounding
    assert row[calling.ERROR_BOUND] <= max(1.1e-9 * scale, 1e-14 * pair.extent)
    assert row[calling.UNIQUE] == (name not in MANY_AS_GOOD)


@pytest.mark.parametrize('name', [n for n in SPECIAL if 'touching' in n or n == 'coin on tray'])
def test_touching_shapes_have_the_right_normal(name):
    pair = pair_of(*SPECIAL[name][:-1])
    row = _check(pair)
    along = {'crossed, touching': 1, 'coin on tray': 2}.get(name, 0)
    assert row[1:4] == pytest.approx(-ALIGNED[along], abs=2e-5)


@pytest.mark.parametrize('tilt', [1e-12, 1e-10, 1e-8, 1e-6, 1e-3])
@pytest.mark.parametrize('name', ['same cylinder', 'same needle', 'coaxial cylinder and spheroid'])
def test_almost_rings(name, tilt):
    """The bounds widen to 1e-6 of the size, the answer stays good."""
    a, size_A, R_WA, b, size_B, _, p, _ = SPECIAL[name]
    pair = pair_of(a, size_A, R_WA, b, size_B, _turned(tilt), p)
    row = _check(pair)
    assert row[calling.ERROR_BOUND] <= 2e-6
    assert abs(row[0] - _truth(pair)) <= min(row[calling.ERROR_BOUND], 5e-8)


@pytest.mark.parametrize('name', ['cylinder_cylinder', 'ellipsoid_ellipsoid'])
def test_swapped_pairs(name):
    for pair in random_pairs(np.random.default_rng(14), ROWS[name], 2 * COUNT):
        row, swapped = _check(pair), _check(pair.swapped())
        assert abs(row[0] - swapped[0]) <= row[calling.ERROR_BOUND] + swapped[calling.ERROR_BOUND]
        if row[calling.UNIQUE] and swapped[calling.UNIQUE]:
            assert row[1:4] @ swapped[1:4] <= -0.99


@pytest.mark.parametrize('name', ROWS)
def test_common_rotations(name):
    rng = np.random.default_rng(15)
    for pair in random_pairs(rng, ROWS[name], COUNT):
        R = random_rotation(rng)
        row, moved = _check(pair), _check(turned(pair, R))
        assert abs(row[0] - moved[0]) <= row[calling.ERROR_BOUND] + moved[calling.ERROR_BOUND]
        if row[calling.UNIQUE] and moved[calling.UNIQUE]:
            assert (R @ row[1:4]) @ moved[1:4] >= 0.99


@pytest.mark.parametrize('name', ROWS)
def test_loose_tolerances_keep_their_promise(name):
    for pair in random_pairs(np.random.default_rng(16), ROWS[name], COUNT):
        sharp = _check(pair)
        for tolerance in (1e-3, 1e-6):
            row = _check(pair, tolerance)
            bound = row[calling.ERROR_BOUND]
            assert bound <= 2 * tolerance
            assert abs(row[0] - sharp[0]) <= bound + sharp[calling.ERROR_BOUND]


def test_beyond_the_cutoff_the_lower_bound_is_told():
    pair = pair_of(CAPSULE, (0.1, 1), ALIGNED, C, (1, 1), ALIGNED, (7, 3, 2))
    sharp, row = _evaluate(pair), _evaluate(pair, cutoff=2.0)
    assert row[calling.METHOD] == BOUND_ONLY
    assert 2.0 < row[0] <= sharp[0]
    assert sharp[0] - row[0] <= row[calling.ERROR_BOUND]
    assert row[4:7] - row[7:10] == pytest.approx(row[0] * row[1:4], abs=1e-14)
    near = _evaluate(pair, cutoff=10.0)
    assert near == pytest.approx(sharp, abs=0)
    assert near[calling.METHOD] == ITERATIVE


@pytest.mark.parametrize('name', ROWS)
def test_a_hint_changes_the_work_and_not_the_answer(name):
    rng = np.random.default_rng(17)
    for pair in random_pairs(rng, ROWS[name], COUNT):
        row = _check(pair)
        close = row[1:4] + 1e-2 * rng.normal(size=3)
        for hint in (
            row[1:4],
            close,
            -close,
            1e9 * rng.normal(size=3),
            [np.nan] * 3,
            [np.inf] * 3,
        ):
            other = _evaluate(pair, hint=hint)
            bounds = row[calling.ERROR_BOUND] + other[calling.ERROR_BOUND]
            assert abs(other[0] - row[0]) <= bounds, (pair, hint)
            assert other[calling.ERROR_BOUND] <= 4e-9
            assert other[4:7] - other[7:10] == pytest.approx(other[0] * other[1:4], abs=1e-14)


@pytest.mark.parametrize('name', ROWS)
def test_answers_repeat_bit_for_bit(name):
    for pair in random_pairs(np.random.default_rng(18), ROWS[name], COUNT):
        row = _evaluate(pair)
        assert _evaluate(pair).tobytes() == row.tobytes()


@pytest.mark.parametrize('name', ROWS)
def test_normals_are_good_to_eight_digits(name):
    """Between the support points along a known normal, that is the normal."""
    rng = np.random.default_rng(19)
    for pair in random_pairs(rng, ROWS[name], COUNT):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        row = _check(Pair(pair.a, apart(pair.a, pair.b, n, 0.01)))
        assert row[1:4] == pytest.approx(-n, abs=1e-8)
        assert row[calling.ERROR_BOUND] <= 1e-13


@pytest.mark.parametrize('size', [1e-200, 1e-306, 1e-308, 1e-312, 5e-324])
@pytest.mark.parametrize('kind', [CYLINDER, ELLIPSOID])
def test_a_vanishing_body_is_a_point(kind, size):
    """Products of its lengths leave float64; those of the box beside it do not."""
    rng = np.random.default_rng(7)
    for _ in range(40):
        R_WA, q = random_rotation(rng), rng.normal(size=3)
        q *= 1.5 / np.abs(q).max()
        out = np.zeros(calling.PAIR_WIDTH)
        call_for_pair(
            convex.signed_distance_of_cores,
            *(BOX, np.full(3, 0.5), R_WA, kind, np.full(3, size), random_rotation(rng)),
            *(R_WA @ q, 1e-9, np.inf, out),
        )
        truth = np.linalg.norm(np.maximum(np.abs(q) - 0.5, 0.0))
        assert abs(out[calling.DISTANCE] - truth) <= out[calling.ERROR_BOUND] < 1e-13
