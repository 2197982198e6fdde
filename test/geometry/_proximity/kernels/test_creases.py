"""Depth over faces and creases, against the support-function oracle."""

import numpy as np
import pytest
from numba import config
from oracles.pairs import random_pairs

from drake_geom_ros.evidence.truth.convex import signed_distance
from drake_geom_ros.geometry._proximity.kernels import creases, sums

BOX, CAPSULE, CYLINDER = 2, 3, 4
COUNT = 6 if config.DISABLE_JIT else 24
NOISE = 1e-15


def _least(pair, start=(1.0, 0.0, 0.0)):
    arguments = (
        *(pair.kind_A, pair.size_A, pair.R_WA, pair.kind_B, pair.size_B, pair.R_WB),
        tuple(pair.p_AB_W),
    )
    return creases.least_on_creases(sums.difference_of(arguments), start, 1e-12, NOISE)


@pytest.mark.parametrize('kind', [BOX, CAPSULE])
def test_overlapping_cores_are_as_deep_as_the_oracle_says(kind):
    rng, seen = np.random.default_rng(3), 0
    for pair in random_pairs(rng, (kind, CYLINDER), COUNT):
        phi, _ = signed_distance(
            (kind, pair.size_A), (pair.R_WA, np.zeros(3)),
            (CYLINDER, pair.size_B), (pair.R_WB, pair.p_AB_W),
        )  # fmt: skip
        radius = pair.size_A[0] if kind == CAPSULE else 0.0
        if phi + radius < -1e-6:
            complete, h, n, _ = _least(pair)
            assert complete
            assert h == pytest.approx(-phi - radius, abs=1e-12)
            assert np.linalg.norm(n) == pytest.approx(1, abs=1e-14)
            seen += 1
    assert seen >= 2


def test_the_start_does_not_matter():
    rng = np.random.default_rng(4)
    for pair in random_pairs(rng, (BOX, CYLINDER), COUNT):
        depths = [_least(pair, tuple(n))[1] for n in np.vstack([np.eye(3), -np.eye(3)])]
        if min(depths) > 0:
            assert max(depths) - min(depths) <= 1e-14


@pytest.mark.parametrize(
    ('p', 'depth', 'unique'),
    [((0.4, 0.0, 0.0), 0.35, True), ((0.4, 0.4, 0.0), 0.35, False), ((0.0, 0.0, 0.7), 0.8, False)],
)
def test_a_rod_through_a_cube(p, depth, unique):
    identity, size = np.eye(3), (np.full(3, 0.5), np.array([0.25, 1.0]))
    pair = BOX, size[0], identity, CYLINDER, size[1], identity, p
    difference = sums.difference_of(pair)
    complete, h, _, is_unique = creases.least_on_creases(difference, (0, 0, 1.0), 1e-9, NOISE)
    assert complete
    assert h == pytest.approx(min(depth, 0.75), abs=1e-15)
    assert is_unique == unique


def test_kinks_come_in_turn():
    pair = BOX, np.ones(3), np.eye(3), CYLINDER, np.ones(2), np.eye(3)[[1, 2, 0]], (1.0,) * 3
    terms, _, last, _, _ = sums.difference_of(pair)
    kinks = np.empty((8, 4))
    count = creases.kinks_on_circle(terms, last, (0.0, 0.0, 1.0), kinks)
    turns = np.arctan2(kinks[:count, 1], kinks[:count, 0])
    steps = np.diff(np.append(turns, turns[0])) % (2 * np.pi)
    assert steps.sum() == pytest.approx(2 * np.pi)
    assert np.abs(kinks[:count, 2]).max() == 0.0
