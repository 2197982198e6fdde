"""Pairs of bodies, and the laws that every result row of a kernel obeys."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from oracles import body_truth
from oracles.case_laws import radius_of_core
from oracles.forms import PARAMETERS, body, row_of

from drake_geom_ros.cross_check import surfaces
from drake_geom_ros.cross_check.bodies import Pair
from drake_geom_ros.cross_check.surfaces import width
from drake_geom_ros.geometry._proximity.kinds import CAPSULE, CLOSED_FORM, HALF_SPACE
from truth.bodies.random_bodies import random_rotation
from truth.judging import laws
from truth.tolerances import EPS


def pair_of(kind_A, size_A, R_WA, kind_B, size_B, R_WB, p_AB_W):
    """Return two bodies as a kernel takes them, A at the origin."""
    return Pair(body((kind_A, size_A), R_WA), body((kind_B, size_B), R_WB, p_AB_W))


def moved_apart(pair, p_AB_W):
    """Return the pair with B elsewhere."""
    return replace(pair, b=pair.b.at(pair.a.p + p_AB_W))


def turned(pair, R):
    """Return the pair under a common rotation."""
    return pair.moved(R, np.zeros(3))


class Row(NamedTuple):
    """One result row, by name."""

    distance: float
    nhat: np.ndarray
    p_ACa: np.ndarray
    p_ACb: np.ndarray
    error_bound: float
    unique: bool
    method: int


def evaluate(kernel, pair):
    """Call a kernel and check the laws that need no truth; return the row."""
    out = row_of(pair.a, pair.b, kernel=kernel)
    row = Row(out[0], out[1:4], out[4:7], out[7:10], out[10], bool(out[11]), int(out[12]))
    rounding = 32 * EPS * pair.extent
    check_row(out, rounding, 1e-14)
    assert off_surfaces(pair, out) <= rounding, (pair, row)
    return row


def check_row(out, rounding, unit=1e-12):
    """Check what holds of every row, to within ``rounding`` [m] and ``unit`` [-]."""
    assert laws.off_unit(out[1:4]) <= unit, out
    assert laws.off_span(out[0], out[1:4], out[4:7], out[7:10]) <= rounding, out


def off_surfaces(pair, out):
    """Return how far [m] the witness points of a row are off the surfaces."""
    return surfaces.off_surfaces(pair, pair.a.p + out[4:7], pair.a.p + out[7:10])


def random_pairs(rng, kinds, count, scale=1.0):
    """Pairs of about 20 cm times scale: 0.2 and 2e-3 apart, touching, 2e-2 deep, deep, contained.

    Every fourth is almost aligned, every fourth flat or thin.
    """
    a, b = kinds
    for k in range(count):
        shrink = 10 ** rng.uniform(-3, 0) if k % 6 == 5 else 1.0
        spread = 2.0 if k % 4 == 3 else 0.5
        size_A = scale * shrink * 0.2 * 10 ** rng.uniform(-spread, 0, PARAMETERS[a])
        size_B = scale * 0.2 * 10 ** rng.uniform(-spread, 0, PARAMETERS[b])
        R_WA = random_rotation(rng)
        R_WB = R_WA @ random_rotation(rng, 10 ** rng.uniform(-17, -2) if k % 4 == 2 else None)
        p = rng.normal(size=3)
        n = -R_WB[:, 2] if b == HALF_SPACE else p / np.linalg.norm(p)
        pair = pair_of(a, size_A, R_WA, b, size_B, R_WB, np.zeros(3))
        if k % 6 < 4:
            gap = scale * (0.2, 2e-3, 0.0, -2e-2)[k % 6]
            yield moved_apart(pair, (gap - width(pair.a, pair.b, -n)) * n)
        else:
            yield moved_apart(pair, p * scale * rng.uniform(0, 0.1))


def _feature_point(rng, kind, size):
    """A random vertex, edge or face point of a box or segment, and a direction out of it."""
    at = rng.choice([-1.0, 0.0, 1.0, rng.uniform(-1, 1)], size=3)
    at[rng.integers(3)] = rng.choice([-1.0, 1.0])
    half = np.array([0.0, 0.0, size[1]]) if kind == CAPSULE else size
    out = np.where(np.abs(at) == 1.0, at, 0.0)
    return at * half, out / np.linalg.norm(out)


def feature_pairs(rng, kinds, count):
    """Boxes and capsules whose cores meet at vertices, edges or faces, or miss by 1e-16 to 0.1.

    Most are parallel, turned by right angles or about one axis, but for 1e-17 to 0.1 rad.
    """
    a, b = kinds
    for _ in range(count):
        spread = rng.choice([0.0, 0.5, 3.0])
        size_A, size_B = (10 ** rng.uniform(-spread, 0, PARAMETERS[k]) for k in kinds)
        R_WA = random_rotation(rng) if rng.random() < 0.7 else np.eye(3)
        turn = np.eye(3)[rng.permutation(3)]
        turn *= np.linalg.det(turn)
        if rng.random() < 0.3:
            angle = rng.uniform(0, np.pi)
            c, s = np.cos(angle), np.sin(angle)
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        tilt = random_rotation(rng, 10 ** rng.uniform(-17, -1) if rng.random() < 0.8 else None)
        R_WB = R_WA @ turn @ tilt
        point_A, n = _feature_point(rng, a, size_A)
        point_B, _ = _feature_point(rng, b, size_B)
        gap = rng.choice([0.0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 0.1]) * rng.choice([-1, 1])
        p_AB_W = R_WA @ (point_A + gap * n) - R_WB @ point_B
        pair = pair_of(a, size_A, R_WA, b, size_B, R_WB, p_AB_W)
        yield pair.scaled(rng.choice([1e-6, 1.0, 1e6]))


def special_pairs(kinds):
    """Unit-sized pairs in special position: axes parallel or crossing, concentric, touching."""
    a, b = kinds
    quarter = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    sizes = {1: [0.5], 2: [0.5, 0.25, 0.5], 3: [0.25, 0.5], 4: [0.25, 0.5], 5: [0.5, 0.25, 0.5]}
    for R_WB in (np.eye(3), quarter):
        pair = pair_of(a, sizes[a], np.eye(3), b, sizes.get(b, []), R_WB, np.zeros(3))
        for offset in (0.0, 1e-300, 1e-17, 1e-12, 1e-6, 0.1, 0.25, 0.5, 1e6):
            for direction in ([1, 0, 0], [0, 0, -1], [0, 1, 1], [1, 1, 1]):
                yield moved_apart(pair, offset * np.array(direction, dtype=float))
        for n in [-R_WB[:, 2]] if b == HALF_SPACE else np.eye(3):
            for gap in (1e-3, 1e-9, 1e-15, 0.0, -1e-15, -1e-9, -1e-3):
                at = (gap - width(pair.a, pair.b, -n)) * n
                yield moved_apart(pair, at)
                yield moved_apart(pair, at + 0.125 * np.roll(n, 1))


def check(kernel, pair):
    """Check a kernel's row for a pair against the truth; return the row."""
    row = evaluate(kernel, pair)
    truth, _ = body_truth.signed_distance(pair.a, pair.b)
    assert row.method == CLOSED_FORM
    assert abs(row.distance - truth) <= row.error_bound, (truth, pair, row)
    # Rounding is relative to whatever is largest of the sizes and the offset: all are added up.
    largest = max(*pair.a.form[1], *pair.b.form[1], np.linalg.norm(pair.b.p - pair.a.p))
    assert 16 * EPS * largest <= row.error_bound <= 100 * EPS * pair.extent, (pair, row)
    # The normal is one of those that attain the signed distance; how well it can be known
    # depends on how far the cores (what remains without the radii) are apart.
    core = abs(truth + radius_of_core(pair.a) + radius_of_core(pair.b))
    slack = row.error_bound * (1 + pair.extent / max(core, row.error_bound))
    assert abs(laws.lacking(pair, truth, row.nhat)) <= slack, (truth, pair, row)
    return row


def check_kernel(kernel, kinds, seed, samples, special_step=1):
    """Check a kernel on random and special pairs, scaled, turned and (two of a kind) swapped.

    A power of two changes no digit of a length, so it changes none of an answer.
    """
    rng = np.random.default_rng(seed)
    pairs = [q for scale in (1e-3, 1.0, 1e3) for q in random_pairs(rng, kinds, samples, scale)]
    pairs += list(special_pairs(kinds))[::special_step]
    pairs += [pair.scaled(s) for s in (1e-6, 1e6) for pair in pairs[:6]]
    for pair in pairs:
        row = check(kernel, pair)
        for power in (2.0**-30, 2.0**30):
            scaled = evaluate(kernel, pair.scaled(power))
            assert scaled.distance == power * row.distance, pair
            assert scaled.error_bound == power * row.error_bound, pair
            assert (scaled.unique, *scaled.nhat) == (row.unique, *row.nhat), pair
        other = evaluate(kernel, turned(pair, random_rotation(rng)))
        bound = row.error_bound + other.error_bound
        assert abs(other.distance - row.distance) <= bound, pair
        if pair.a.kind == pair.b.kind:
            swapped = check(kernel, pair.swapped())
            assert abs(swapped.distance - row.distance) <= 2 * row.error_bound, pair
