"""Budgets that come and go: what they leave at bounds falsifies nothing in later cycles."""

import copy

import numpy as np
import pytest
from geometry.test_temporal_coherence import CYCLES, REACH, Life, assert_same_distances, by_pair

from drake_geom_ros.geometry import METHODS, ArgumentError, GeometryError, QueryObject

SPENT = 1e-12  # [s] no more than the first block


@pytest.fixture(scope='module')
def mesh(tmp_path_factory):
    """Return an OBJ file of an octahedron."""
    path = tmp_path_factory.mktemp('mesh') / 'body.obj'
    vertices = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = ['1 3 5', '3 2 5', '2 4 5', '4 1 5', '3 1 6', '2 3 6', '4 2 6', '1 4 6']
    lines = [f'v {0.08 * x} {0.08 * y} {0.08 * z}' for x, y, z in vertices]
    path.write_text('\n'.join([*lines, *(f'f {face}' for face in faces)]) + '\n')
    return str(path)


def assert_certified(bounded, fresh):
    """Every pair within reach is there, within its interval; nobody else is surely too far."""
    ours, truth = by_pair(bounded), by_pair(fresh)
    for pair, answer in truth.items():
        if pair not in ours:
            assert REACH - answer.distance <= 3 * answer.error_bound, pair
            continue
        found = ours[pair]
        off = abs(found.distance - answer.distance)
        assert off <= found.error_bound + answer.error_bound, pair
    for pair in ours.keys() - truth.keys():
        assert ours[pair].distance - ours[pair].error_bound <= REACH, pair


@pytest.mark.parametrize('seed', [0, 1])
def test_whatever_happened_and_however_little_time_there_was(seed, mesh):
    life = Life(seed, mesh)
    left, sharp = 0, 0
    for _ in range(min(CYCLES, 150)):
        life.anything()
        fresh = copy.copy(life.query).ComputeSignedDistancePairwiseClosestPoints(REACH)
        spent = life.rng.random() < 0.6
        near = life.query.ComputeSignedDistancePairwiseClosestPoints(
            REACH, time_budget=SPENT if spent else None
        )
        unrefined = life.query.effects().unrefined_pairs
        if unrefined:
            assert_certified(near, fresh)
            bounds_only = near.method == METHODS['bound_only']
            assert np.count_nonzero(bounds_only) == unrefined
            assert np.isinf(near.promised_error_bound[bounds_only]).all()
            left += 1
        else:
            assert_same_distances(near, fresh, REACH)
            sharp += 1
        assert not near.breaks_promise().any()
        if life.rng.random() < 0.2:
            reported = life.query.ComputePointPairPenetration(time_budget=SPENT)
            deep = by_pair(near.penetrations()) if not unrefined else {}
            missing = deep.keys() - by_pair(reported).keys()
            assert all(deep[pair].depth <= 1e-8 for pair in missing)
            assert (reported.depth > 0.0).all()
    assert min(left, sharp) > min(CYCLES, 150) // 10


@pytest.mark.parametrize('seconds', [-1.0, float('nan')])
def test_a_budget_that_is_none_is_refused(seconds, mesh):
    query = Life(2, mesh).query
    for ask in (
        query.ComputePointPairPenetration,
        query.ComputeSignedDistancePairwiseClosestPoints,
    ):
        with pytest.raises(ArgumentError, match='time_budget'):
            ask(time_budget=seconds)
    # None and 0 are no limit.
    query.ComputePointPairPenetration(time_budget=0.0)
    query.ComputePointPairPenetration(time_budget=None)
    assert query.effects().unrefined_pairs == 0


def test_a_hint_changes_no_answer_and_costs_of_levels_are_told(mesh):
    query = Life(3, mesh).query
    pair = query.ComputeSignedDistancePairwiseClosestPoints(REACH)[0]
    for hint in (None, pair.nhat_BA_W, [0.0, 0.0, -7.0], [float('nan')] * 3):
        found = query.signed_distance_of_pair(pair.id_A, pair.id_B, hint=hint)[0]
        assert abs(found.distance - pair.distance) <= found.error_bound + pair.error_bound
    with pytest.raises(ArgumentError, match='hint'):
        query.signed_distance_of_pair(pair.id_A, pair.id_B, hint=[1.0, 0.0])
    costs, samples = query.cost_of_levels(REACH)
    assert list(costs) == ['bound', '0.01', 'fast', 'balanced', 'exact']
    assert 0 < samples <= 64
    with pytest.raises(ArgumentError, match='max_distance'):
        query.cost_of_levels(float('nan'))
    with pytest.raises(GeometryError):
        QueryObject().cost_of_levels()
