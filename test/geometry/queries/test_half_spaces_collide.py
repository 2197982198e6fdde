"""Whether two half spaces overlap, yes or no, against planes in rational numbers."""

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from batch.floating_bodies import Floating
from geometry.queries.moving_bodies import pose
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.planes import OVERTURNED, UPRIGHT, Planes

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryError,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix

LEVELS = ('bound', 'fast', 'balanced', 'exact')
# Of A, z <= 0, and of B as it is posed: whether they overlap.
CASES = {
    'one in the other': (UPRIGHT, [0, 0, -1.0], True),
    'one around the other': (UPRIGHT, [0, 0, 1.0], True),
    'crossing': (RotationMatrix.MakeXRotation(1.0).matrix(), [0, 0, 9.0], True),
    'crossing far away': (RotationMatrix.MakeXRotation(np.pi - 1e-9).matrix(), [0, 0, 1.0], True),
    'opposed': (OVERTURNED, [5, 0, -0.1], True),
    'opposed and touching': (OVERTURNED, [5, 0, 0.0], True),
    'opposed and apart': (OVERTURNED, [5, 0, 0.1], False),
}


def collide(query):
    """Return what is told at every level, which is the same; and without a word in lists."""
    found = {query.HasCollisions(accuracy=level) for level in LEVELS} | {query.HasCollisions()}
    assert len(found) == 1
    assert len(query.ComputePointPairPenetration()) == 0
    assert len(query.ComputeSignedDistancePairwiseClosestPoints()) == 0
    (answer,) = found
    return answer


@pytest.mark.parametrize('case', CASES.values(), ids=CASES)
@pytest.mark.parametrize('order', list(permutations(range(2))))
def test_known_planes(case, order):
    *B, overlap = case
    planes = Planes([(UPRIGHT, [0, 0, 0]), B], order=order)
    assert collide(planes.query) == overlap
    expected = [planes.pair()] if overlap else []
    assert planes.query.FindCollisionCandidates() == expected
    with pytest.raises(GeometryError, match='two half spaces have no signed distance'):
        planes.query.ComputeSignedDistancePairClosestPoints(*planes.pair())


# In rational numbers: z <= 0 in G is n . (x - p) <= 0, and two overlap unless their normals are
# opposed and a gap is between them.


def rotation(w, x, y, z):
    """Return the rotation matrix of a quaternion of whole numbers."""
    square = w * w + x * x + y * y + z * z
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.array([[Fraction(value, square) for value in row] for row in rows])


def overlap_of(A, B):
    (R_A, p_A), (R_B, p_B) = A, B
    n_A, n_B = R_A[:, 2], R_B[:, 2]
    return not ((n_A + n_B == 0).all() and n_A @ (p_B - p_A) > 0)


WHOLE = st.tuples(*[st.integers(-9, 9)] * 4).filter(any)
RATIONAL = st.tuples(*[st.fractions(-9, 9, max_denominator=99)] * 3).map(np.array)
FLIP = rotation(0, 1, 0, 0)


def in_floats(poses):
    return [(R.astype(float), p.astype(float)) for R, p in poses]


@settings(max_examples=150, deadline=None)
@given(WHOLE, WHOLE, RATIONAL, RATIONAL, st.booleans(), st.integers(-9, 9), WHOLE, RATIONAL)
def test_random_planes_in_any_order_and_moved_together(a, b, p_A, p_B, opposed, spin, c, p_C):
    A = rotation(*a), p_A
    R_B = A[0] @ FLIP @ rotation(9, 0, 0, spin) if opposed else rotation(*b)
    B = R_B, p_B
    overlap = overlap_of(A, B)
    if opposed and abs(A[0][:, 2] @ (p_B - p_A)) < Fraction(1, 10**9):
        return  # rounding hides which it is
    X = rotation(*c), p_C
    moved = [(X[0] @ R, X[0] @ p + X[1]) for R, p in (A, B)]
    for poses in ([A, B], [B, A], moved):
        planes = Planes(in_floats(poses))
        assert planes.query.HasCollisions() == overlap
        assert planes.query.FindCollisionCandidates() == [planes.pair()] * overlap


def test_answers_do_not_depend_on_what_was_asked_before():
    asks = 'HasCollisions', 'FindCollisionCandidates', 'ComputePointPairPenetration'
    live = Planes([(UPRIGHT, [0, 0, 0])] * 2)
    manager = live.graph.collision_filter_manager(live.context)
    both = GeometrySet(list(live.ids.values()))
    rng = np.random.default_rng(3)
    names = list(CASES)
    filtered = False
    for _ in range(60):
        *B, overlap = CASES[names[rng.integers(len(names))]]
        live.pose([(UPRIGHT, [0, 0, 0]), B])
        if rng.integers(3) == 0:
            filtered = not filtered
            said = CollisionFilterDeclaration()
            manager.Apply(said.ExcludeWithin(both) if filtered else said.AllowWithin(both))
        for name in rng.permutation(asks)[: rng.integers(3)]:
            getattr(live.query, name)()
        overlap = overlap and not filtered
        assert collide(live.query) == overlap
        assert len(live.query.FindCollisionCandidates()) == overlap
        baked = live.query.__copy__()
        live.pose([(UPRIGHT, [0, 0, 0]), (OVERTURNED, [0, 0, 1.0])])
        assert (baked.HasCollisions(), live.query.HasCollisions()) == (overlap, False)


def test_a_narrowed_query_considers_its_pairs_alone():
    planes = Planes([(UPRIGHT, [0, 0, 0])] * 3)
    considered = np.zeros((3, 3), dtype=bool)
    assert planes.query.HasCollisions()
    assert not planes.query.narrowed(considered).HasCollisions()
    considered[0, 2] = True
    narrowed = planes.query.narrowed(considered)
    assert narrowed.FindCollisionCandidates() == [planes.pair(0, 2)]
    planes.pose([None, None, (OVERTURNED, [0, 0, 1.0])])
    assert not narrowed.HasCollisions()
    assert planes.query.HasCollisions()


def test_two_that_hang_on_the_world_are_filtered():
    graph = SceneGraph()
    source = graph.RegisterSource('source')
    for name in ('floor', 'wall'):
        body = GeometryInstance(RigidTransform(), HalfSpace(), name)
        body.set_proximity_properties(ProximityProperties())
        graph.RegisterAnchoredGeometry(source, body)
    query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
    assert not collide(query)
    assert len(query.half_space_gaps().ids) == 0


def test_padding_closes_a_gap():
    for padding, overlap in ((0.04, False), (0.06, True)):
        planes = Planes([(UPRIGHT, [0, 0, 0]), (OVERTURNED, [0, 0, 0.1])], padding=padding)
        assert collide(planes.query) == overlap
        assert len(planes.query.FindCollisionCandidates()) == overlap


def test_they_are_candidates_among_others_by_their_ids():
    shapes = [Sphere(0.5), HalfSpace(), Sphere(0.5)]
    poses = [(UPRIGHT, [0, 0, 8.0]), (UPRIGHT, [0, 0, 0]), (UPRIGHT, [0, 0, -1.0])]
    planes = Planes([*poses, (UPRIGHT, [0, 0, -9.0])], shapes)
    found = planes.query.FindCollisionCandidates()
    assert found == sorted(found)
    assert planes.pair(1, 3) in found
    assert planes.pair(1, 2) in found
    assert planes.pair(0, 1) not in found


def test_gaps_are_told_by_ids():
    planes = Planes([(UPRIGHT, [0, 0, 0]), (OVERTURNED, [0, 0, 0.25]), (UPRIGHT, [0, 0, 1.0])])
    gaps = planes.query.half_space_gaps()
    assert gaps.distance.tolist() == [0.25, -np.inf, 0.75 - 1.5]
    assert (gaps.error_bound[[0, 2]] < 1e-14).all()
    assert gaps.ids.tolist() == [
        [id.get_value() for id in planes.pair(*pair)] for pair in ((0, 1), (0, 2), (1, 2))
    ]
    assert len(Planes([(UPRIGHT, [0, 0, 0])] * 2, [Sphere(1.0)]).query.half_space_gaps().ids) == 0


# Many states.


@pytest.mark.parametrize('threads', [1, 2])
@pytest.mark.parametrize('margin', [None, 0.0, 0.05])
@pytest.mark.parametrize('balls', [0, 2])
def test_batches_tell_what_contexts_do(threads, margin, balls):
    scene = Floating([HalfSpace(), *[Sphere(0.001)] * balls, HalfSpace()])
    rng = np.random.default_rng(5)
    states = np.tile(np.array(pose(z=3.0)), (40, 2 + balls, 1))
    states[:, 0] = pose()
    states[:, 1:-1, 0] = np.arange(balls)
    for k, height in enumerate(rng.uniform(-0.2, 0.4, 39)):
        states[k, -1] = pose(z=height, axis=(1, 0, 0), angle=np.pi)
        states[k, 1:-1, 2] = height / 2.0  # between the two
    states[::7] = scene.states(rng, len(states[::7]), 1.0)
    if balls:
        states[3, 1] = states[3, 2] = pose(z=-1.0)
    found = evaluate(
        scene.graph,
        scene.ids,
        states,
        'collision',
        max_distance=np.inf if margin is None else margin,
        threads=threads,
        block_size=7,
    )
    least = evaluate(scene.graph, scene.ids, states, 'least', threads=threads, block_size=7)
    ends = least.distance - least.error_bound
    for state, collides, end in zip(states, found, ends, strict=True):
        context = scene.graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(scene.ids, state))
        query = scene.graph.get_query_output_port().Eval(context)
        gaps = query.half_space_gaps()
        if not margin:
            assert collides == query.HasCollisions()
        near = query.ComputeSignedDistancePairwiseClosestPoints(margin or 0.0)
        assert collides == (len(near) > 0 or (gaps.lower <= (margin or 0.0)).any())
        others = query.ComputeSignedDistancePairwiseClosestPoints()
        lower = np.concatenate((gaps.lower, others.distance - others.error_bound))
        assert end == pytest.approx(lower.min(), abs=1e-12)
    assert 0 < np.count_nonzero(found) < len(found)
    assert (ends == -np.inf).any()
    assert np.isfinite(ends).any()
