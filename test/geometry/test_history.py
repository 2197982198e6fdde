"""An answer depends on poses, filters and the question, never on what was asked before."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    HalfSpace,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw

SHAPES = (
    *(Sphere(0.1), Sphere(0.1), Box(0.2, 0.3, 0.1), Box(0.1, 0.1, 0.4)),
    *(Capsule(0.05, 0.2), Cylinder(0.1, 0.2), Ellipsoid(0.1, 0.15, 0.05)),
)
CUTOFFS = (-math.inf, -0.2, -0.05, -1e-3, 0.0, 0.02, 0.3, math.inf)
EXAMPLES = 15 if config.DISABLE_JIT else 150


SCENE = ShapeScene(*SHAPES, anchored=[(HalfSpace(), RigidTransform([0.0, 0.0, -0.2]))])


def query_of(X_PFs):
    """Return a context with these poses, and its query object."""
    context = SCENE.graph.CreateDefaultContext()
    SCENE.pose(context, X_PFs)
    return context, SCENE.asked(context)


def random_poses(seed):
    """Return a pose each, in a heap: most pairs overlap, or nearly."""
    rng = np.random.default_rng(seed)
    return [
        RigidTransform(RollPitchYaw(*rng.uniform(-3, 3, 3)), rng.uniform(-0.2, 0.2, 3))
        for _ in SCENE.frames
    ]


questions = st.tuples(
    st.sampled_from(('distances', 'penetrations', 'collide', 'candidates', 'points', 'pair')),
    st.sampled_from(CUTOFFS),
    st.sampled_from(ACCURACY_LEVELS),
)
# A pose counts from the first ones: to rest, to move a little, and to come back, happens too.
moves = st.tuples(
    st.just('move'), st.integers(0, len(SCENE.frames) - 1), st.sampled_from((0.0, 1e-4, 0.02, 0.4))
)
lives = st.tuples(st.integers(0, 50), st.lists(st.one_of(questions, moves), max_size=12))


def pairs_of(results, name):
    """Return the value and the error bound of each pair."""
    ids = zip(results.id_A.tolist(), results.id_B.tolist(), strict=True)
    values = zip(getattr(results, name).tolist(), results.error_bound.tolist(), strict=True)
    return dict(zip(ids, values, strict=True))


def assert_agree(before, fresh, edge, level):
    """The same pairs but those that their bounds leave open, each within both bounds.

    What bounds alone answer depends on nothing that was computed: it is the very same.
    """
    if level == 'bound':
        assert before == fresh
    for pair in before.keys() ^ fresh.keys():
        value, bound = before.get(pair) or fresh[pair]
        assert abs(value - edge) <= 2.0 * bound + 1e-13, pair
    for pair in before.keys() & fresh.keys():
        (a, a_bound), (b, b_bound) = before[pair], fresh[pair]
        assert abs(a - b) <= a_bound + b_bound, pair


def ask(question, query, fresh):
    """Ask both the same, and compare."""
    kind, cutoff, level = question
    if kind == 'distances':
        a, b = (
            q.ComputeSignedDistancePairwiseClosestPoints(cutoff, accuracy=level)
            for q in (query, fresh)
        )
        assert_agree(pairs_of(a, 'distance'), pairs_of(b, 'distance'), cutoff, level)
    elif kind == 'penetrations':
        a, b = (q.ComputePointPairPenetration(accuracy=level) for q in (query, fresh))
        assert_agree(pairs_of(a, 'depth'), pairs_of(b, 'depth'), 0.0, level)
    elif kind == 'collide':
        assert query.HasCollisions(accuracy=level) == fresh.HasCollisions(accuracy=level)
    elif kind == 'candidates':
        assert query.FindCollisionCandidates() == fresh.FindCollisionCandidates()
    elif kind == 'points':
        a, b = (q.ComputeSignedDistanceToPoint([0.05, 0.1, 0.0], cutoff) for q in (query, fresh))
        assert a.id_G.tolist() == b.id_G.tolist()
        np.testing.assert_array_equal(a.distance, b.distance)
    else:
        ids = query.inspector().GetAllGeometryIds()[1:3]
        a, b = (q.ComputeSignedDistancePairClosestPoints(*ids) for q in (query, fresh))
        assert a.distance == b.distance


@settings(max_examples=EXAMPLES)
@given(life=lives, last=questions)
def test_a_fresh_context_answers_the_same(life, last):
    seed, events = life
    starts = random_poses(seed)
    X_PFs = list(starts)
    context, query = query_of(X_PFs)
    for event in [*events, last]:
        if event[0] == 'move':
            _, k, step = event
            X_PFs[k] = starts[k] @ RigidTransform(RollPitchYaw(step, 0, 0), [step, 0, -step])
            context.UpdateFramePoses(FramePoseVector({SCENE.frames[k]: X_PFs[k]}))
        else:
            ask(event, query, query_of(X_PFs)[1])


@pytest.mark.parametrize('before', [None, 0.0, 0.3, math.inf])
@pytest.mark.parametrize('cutoff', CUTOFFS)
def test_a_cutoff_below_zero_gives_the_pairs_that_deep_and_no_others(cutoff, before):
    for seed in range(4):
        _, query = query_of(random_poses(seed))
        everything = query_of(random_poses(seed))[1].ComputeSignedDistancePairwiseClosestPoints()
        expected = {
            pair for pair, (d, _) in pairs_of(everything, 'distance').items() if d <= cutoff
        }
        if before is not None:
            query.ComputeSignedDistancePairwiseClosestPoints(before)
        found = query.ComputeSignedDistancePairwiseClosestPoints(cutoff)
        assert set(pairs_of(found, 'distance')) == expected


def test_two_spheres_deep_in_each_other_are_found_first_thing():
    X_PFs = [RigidTransform([5.0 * k, 0.0, 5.0]) for k in range(len(SCENE.frames))]
    X_PFs[1] = RigidTransform([0.1, 0.0, 5.0])
    found = query_of(X_PFs)[1].ComputeSignedDistancePairwiseClosestPoints(-0.05)
    assert found.distance.tolist() == [pytest.approx(-0.1)]
    assert len(query_of(X_PFs)[1].ComputeSignedDistancePairwiseClosestPoints(-0.15)) == 0
