"""Whoever gets a normal can prove the distance less its bound: by the planes that it is across.

So an answer needs no trust: two support points are looked up, and what is between them is empty.
"""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.forms import PARAMETERS, row_of
from oracles.pairs import moved_apart, pair_of, random_pairs

from bench.evidence.bodies.random_bodies import random_rotation
from bench.evidence.judging.laws import lacking
from drake_geom_ros.cross_check.surfaces import width
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS

ROWS = list(
    itertools.combinations_with_replacement((SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID), 2)
)
FEW_ULPS = 32.0 * EPS  # of the pair's extent: both supports, and the sum of them
EXAMPLES = 5 if config.DISABLE_JIT else 60


def proves(pair, hint=(0.0, 0.0, 0.0)):
    """Check that the planes across the normal are as far apart as the distance less its bound."""
    out = row_of(pair.a, pair.b, hint=hint)
    missing = lacking(pair, out[calling.DISTANCE], out[calling.NORMAL : calling.NORMAL + 3])
    assert missing <= out[calling.ERROR_BOUND] + FEW_ULPS * pair.extent, pair


@settings(max_examples=EXAMPLES, deadline=None, derandomize=True)
@given(st.sampled_from(ROWS), st.integers(0, 2**32 - 1))
def test_pairs_of_all_sizes_apart_touching_and_overlapping(row, seed):
    for pair in random_pairs(np.random.default_rng(seed), row, 6):
        proves(pair)


@settings(max_examples=EXAMPLES, deadline=None, derandomize=True)
@given(
    st.sampled_from([(BOX, CYLINDER), (CYLINDER, CYLINDER), (CYLINDER, ELLIPSOID), (BOX, BOX)]),
    st.integers(0, 2**32 - 1),
    st.sampled_from([1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 0.0]),
    st.sampled_from([1e-2, 1e-5, 1e-9, 1e-13, 0.0, -1e-9]),
)
def test_discs_and_plates_that_nearly_touch(row, seed, tilt, gap):
    """Flat and wide, almost parallel: the shortest vector between them has few digits."""
    rng = np.random.default_rng(seed)
    sizes = [10.0 ** rng.uniform(-1, 0, PARAMETERS[kind]) for kind in row]
    for size in sizes:
        size[-1] = 10.0 ** rng.uniform(-4, -1)
    R_WA = random_rotation(rng)
    pair = pair_of(
        row[0], sizes[0], R_WA, row[1], sizes[1], R_WA @ random_rotation(rng, tilt), np.zeros(3)
    )
    n = R_WA @ np.array([*(0.3 * rng.normal(size=2) * rng.choice([0.0, 1.0])), 1.0])
    n /= np.linalg.norm(n)
    proves(moved_apart(pair, (gap - width(pair.a, pair.b, -n)) * n))
