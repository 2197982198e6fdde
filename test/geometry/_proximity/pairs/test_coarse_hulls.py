"""Coarse hulls change no verdict, and answers to an accuracy hold the truth."""

import math

import numpy as np
import pytest
from batch.floating_bodies import Floating
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.solids import surface_of

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Sphere,
)
from drake_geom_ros.geometry.meshes.source import MeshData
from truth.bodies.random_bodies import random_directions

ACCURACIES = (1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 1.0)  # [m]
SCALES = (1e-3, 1.0, 1e3)
EXAMPLES = 1 if config.DISABLE_JIT else 8


def round_hull(rng, count, axes, scale):
    """Return a hull of many vertices, as an ellipsoid of some semi-axes [m]."""
    return Convex.FromMeshData(MeshData(scale * random_directions(rng, count) * axes))


def shapes_of(rng, scale):
    """Return hulls with and without coarse hulls, slivers and pins, beside other bodies."""
    pin = np.vstack([0.1 * random_directions(rng, 200), [[0.6, 0.0, 0.0]]])
    return [
        round_hull(rng, 400, [0.3, 0.2, 0.25], scale),
        round_hull(rng, 700, [0.2, 0.2, 0.1], scale),  # with lists of neighbours
        round_hull(rng, 300, [0.4, 0.3, 1e-4], scale),
        round_hull(rng, 300, [0.5, 1e-3, 2e-3], scale),
        Convex.FromMeshData(MeshData(scale * pin)),
        round_hull(rng, 20, [0.2, 0.2, 0.2], scale),
        Sphere(0.1 * scale),
        Box(*(scale * np.array([0.2, 0.3, 0.1]))),
        Capsule(0.05 * scale, 0.3 * scale),
        Cylinder(0.1 * scale, 0.2 * scale),
        Ellipsoid(*(scale * np.array([0.1, 0.2, 0.15]))),
    ]


@pytest.fixture(scope='module', params=SCALES)
def scene(request):
    return Floating(shapes_of(np.random.default_rng(5), request.param)), request.param


def ask(bodies, poses, want='within', **how):
    return evaluate(bodies.graph, bodies.ids, poses, want, threads=1, **how)


def ends_of(found):
    return found.distance - found.error_bound, found.distance + found.error_bound


def keys_of(found):
    """Return the state and the pair of each row."""
    states = np.repeat(np.arange(len(found.offsets) - 1), np.diff(found.offsets))
    return np.column_stack([states, found.id_A, found.id_B])


@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), spread=st.sampled_from([0.3, 0.6, 1.5]))
def test_intervals_hold_the_truth_and_shrink_with_the_accuracy(scene, seed, spread):
    bodies, scale = scene
    poses = bodies.states(np.random.default_rng(seed), 5, spread * scale)
    exact = ask(bodies, poses)
    lower, upper = ends_of(exact)
    rounding = 1e-12 * scale
    widest = np.full(len(lower), math.inf)
    for accuracy in ACCURACIES[::-1]:
        found = ask(bodies, poses, accuracy=accuracy)
        np.testing.assert_array_equal(keys_of(found), keys_of(exact))
        low, high = ends_of(found)
        assert (low <= upper + rounding).all()
        assert (high >= lower - rounding).all()
        assert (found.error_bound <= max(accuracy, exact.error_bound.max()) + rounding).all()
        assert (found.error_bound <= widest + rounding).all()
        widest = found.error_bound
        # No accuracy hides a contact or makes one.
        plain = np.abs(exact.distance) > exact.error_bound + rounding
        assert ((found.distance < 0.0) == (exact.distance < 0.0))[plain].all()
        # Witness points and normal say the distance.
        along = np.einsum('ij,ij->i', found.p_WCa - found.p_WCb, found.nhat_BA_W)
        np.testing.assert_allclose(along, found.distance, rtol=0.0, atol=1e-9 * scale)


def test_coarse_answers_are_used(scene):
    bodies, scale = scene
    poses = bodies.states(np.random.default_rng(1), 20, 2.0 * scale)
    exact, found = ask(bodies, poses), ask(bodies, poses, accuracy=max(0.1 * scale, 1e-5))
    if scale >= 1.0:
        assert (found.error_bound > 100.0 * exact.error_bound).any()


@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), spread=st.sampled_from([0.4, 0.8, 1.6]))
def test_verdicts_are_those_of_all_distances(scene, seed, spread):
    bodies, scale = scene
    rng = np.random.default_rng(seed)
    poses = bodies.states(rng, 30, spread * scale)
    # Two bodies only, so that a state need not collide.
    poses[:, 2:, :3] += 10.0 * scale * (1.0 + np.arange(len(bodies.ids) - 2))[:, None]
    order = rng.permutation(len(bodies.ids))
    poses = poses[:, order]
    every = ask(bodies, poses)
    ends = every.distance - every.error_bound
    spans = list(zip(every.offsets[:-1], every.offsets[1:], strict=True))
    least = np.array([ends[first:last].min() for first, last in spans])
    for margin in (0.0, 0.01 * scale, 0.1 * scale):
        for accuracy in ('exact', 'fast'):
            found = ask(bodies, poses, 'collision', max_distance=margin, accuracy=accuracy)
            np.testing.assert_array_equal(found, least <= margin)
    depth = np.array([every.distance[first:last].min() for first, last in spans])
    found = ask(bodies, poses, 'collision')
    clear = np.abs(depth) > 1e-12 * scale
    np.testing.assert_array_equal(found[clear], (depth < 0.0)[clear])


def least_ends(bodies, poses):
    """Return the least lower end [m] of all pairs in each state, by ``exact``."""
    found = ask(bodies, poses, 'least')
    return found.distance - found.error_bound


@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), partner=st.integers(1, 10), apart=st.floats(0.0, 1.0))
def test_verdicts_around_the_margin_are_those_of_exact(scene, seed, partner, apart):
    """Margins that differ from the distance by less than a reach, and by more."""
    bodies, scale = scene
    rng = np.random.default_rng(seed)
    poses = bodies.states(rng, 4, (0.2 + apart) * scale)
    others = np.setdiff1d(np.arange(1, len(bodies.ids)), partner)
    poses[:, others, :3] += 100.0 * scale * (1.0 + np.arange(len(others)))[:, None]
    ends = least_ends(bodies, poses)
    steps = np.array([0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3]) * scale
    for state, end in zip(poses, ends.tolist(), strict=True):
        for margin in np.append(end + steps, end - steps):
            if margin < 0.0:
                continue
            for accuracy in ('exact', 'fast', 0.1 * scale):
                asked = {'max_distance': margin, 'accuracy': accuracy}
                (found,) = ask(bodies, state[None], 'collision', **asked)
                assert found == (end <= margin), (end - margin, accuracy)


def test_answers_do_not_depend_on_order_and_earlier_queries(scene):
    bodies, scale = scene
    poses = bodies.states(np.random.default_rng(3), 12, scale)
    once = ask(bodies, poses, accuracy=0.01)
    ask(bodies, poses, 'collision')
    ask(bodies, poses)
    again = ask(bodies, poses, accuracy=0.01)
    back = ask(bodies, poses[::-1], accuracy=0.01)
    for name in ('distance', 'error_bound', 'nhat_BA_W'):
        np.testing.assert_array_equal(getattr(again, name), getattr(once, name))
    starts = once.offsets
    for s in range(len(poses)):
        rows = slice(starts[s], starts[s + 1])
        r = len(poses) - 1 - s
        same = slice(back.offsets[r], back.offsets[r + 1])
        np.testing.assert_array_equal(back.distance[same], once.distance[rows])


@settings(max_examples=EXAMPLES, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_hulls_of_solids_leave_out_what_is_beyond_the_cutoff_only(seed):
    rng = np.random.default_rng(seed)
    solids = [Mesh.FromMeshData(surface_of(name), 0.3) for name in ('L', 'U', 'ring')]
    bodies = Floating([*solids, *shapes_of(np.random.default_rng(5), 1.0)[:8]])
    poses = bodies.states(rng, 6, 0.8)
    every = ask(bodies, poses)
    for cutoff in (0.0, 0.05, 0.4):
        near = every.distance - every.error_bound <= cutoff
        for accuracy in ('exact', 1e-3):
            found = ask(bodies, poses, max_distance=cutoff, accuracy=accuracy)
            kept = {tuple(key) for key in keys_of(found).tolist()}
            assert {tuple(key) for key in keys_of(every)[near].tolist()} <= kept
            far = every.distance > cutoff + 2e-3
            assert not kept & {tuple(key) for key in keys_of(every)[far].tolist()}
