"""Pairs that hypothesis makes up keep their promises; a found one is simplified and printed."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config

from bench import fuzz
from drake_geom_ros.evidence import promises
from drake_geom_ros.evidence.bodies import Body
from drake_geom_ros.evidence.laws import COARSE
from drake_geom_ros.evidence.random_bodies import box_corners, random_rotation
from drake_geom_ros.evidence.surfaces import width

EXAMPLES = 20 if config.DISABLE_JIT else 300
LENGTHS = st.sampled_from([1.0, 0.5, 0.75, 0.1, 1e-3]) | st.floats(0.05, 2.0)
COORDINATES = st.sampled_from([0.0, 0.5, 1.0, -1.0, 0.25, 1e-9, 1e-15]) | st.floats(-2.0, 2.0)
TILTS = st.sampled_from([0.0, 0.0, 1e-16, 1e-12, 1e-6, 1e-3, None])
SIZES = {'Sphere': 1, 'Box': 3, 'Capsule': 2, 'Cylinder': 2, 'Ellipsoid': 3, 'Convex': 3}


@st.composite
def bodies(draw):
    """A body of plain or any lengths, aligned with World, almost so or anyhow."""
    kind = draw(st.sampled_from(list(SIZES)))
    size = tuple(draw(LENGTHS) for _ in range(SIZES[kind]))
    if kind == 'Convex':
        size = tuple(map(tuple, box_corners(size)[draw(st.integers(0, 3)) :].tolist()))
    tilt = draw(TILTS)
    rng = np.random.default_rng(draw(st.integers(0, 9)))
    R = np.eye(3) if tilt == 0.0 else random_rotation(rng, tilt)
    turn = np.eye(3)[draw(st.permutations(range(3)))]
    p = np.array([draw(COORDINATES) for _ in range(3)])
    return Body(kind, size, R @ (turn * np.linalg.det(turn)), p)


@settings(max_examples=EXAMPLES, derandomize=True, deadline=None)
@given(bodies(), bodies())
def test_every_promise_holds(a, b):
    assert set(promises.broken(a, b)) <= {COARSE}


def test_a_short_run_finds_nothing(capsys):
    pairs = 10 if config.DISABLE_JIT else 400
    counts, found = fuzz.fuzz(pairs, seed=3)
    assert set(counts) <= {COARSE}
    assert counts[COARSE] <= pairs / 50
    assert found == []


def test_a_broken_promise_is_seen_and_simplified(monkeypatch):
    """Bodies that seem 1 % farther apart than they are: a gap wider than what was certified."""

    def wider(a, b, n):
        return width(a, b, n) + 0.01 * (a.radius + b.radius)

    a, b = fuzz.random_pair(np.random.default_rng(0))
    assert promises.broken(a, b) == []
    monkeypatch.setattr(promises, 'width', wider)
    false = 'certificate false: another direction has a wider gap'
    assert promises.broken(a, b) == [false]
    simple = fuzz.simplified(a, b)
    assert promises.broken(*simple) == [false]
    assert all(np.array_equal(one.R, np.eye(3)) for one in simple)
    assert all(len(f'{x:g}') <= 6 for one in simple for x in (*one.size, *one.p))
