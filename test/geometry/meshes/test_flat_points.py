"""Sums of squares judge points as their decomposition does: flat or not."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry.meshes import _library
from drake_geom_ros.geometry.meshes._library import extent_axes
from truth.bodies.random_bodies import random_rotations


@given(
    st.integers(0, 999),
    st.floats(-20.0, 0.0),
    st.sampled_from((0.0, 1.0, 1e6)),
    st.sampled_from((1e-200, 1e-6, 1.0, 1e6, 1e200)),
    st.sampled_from((4, 30, 1000)),
)
def test_points_are_flat_as_their_decomposition_says(seed, exponent, shift, size, count):
    rng = np.random.default_rng(seed)
    (R,) = random_rotations(rng, 1)
    points = rng.uniform(-1.0, 1.0, (count, 3)) * [1.0, 0.5, 10.0**exponent] @ R + shift
    points *= size
    assert _library._is_flat(points) == (len(extent_axes(points)[1]) < 3)
