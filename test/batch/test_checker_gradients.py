"""Distances with derivatives by joints: those of ``evaluate``, and slopes of differences."""

import threading

import numpy as np
import pytest
from batch.conftest import Cell
from hypothesis import given
from hypothesis import strategies as st
from oracles.mesh_files import BOX, SIDES

from drake_geom_ros.batch import Checker, DistancesAndGradients, Joints, evaluate
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    ArgumentError,
    CollisionFilterDeclaration,
    GeometryError,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    Mesh,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene


@pytest.fixture(scope='module')
def checker(cell):
    return Checker(cell.scene_graph, cell.joints)


def by_evaluate(cell, states, **how):
    asked = {'states': states, 'joints': cell.joints, 'by_joints': True}
    return evaluate(cell.scene_graph, **asked, **how)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_the_clearance_and_its_gradient_are_those_of_evaluate(cell, accuracy):
    states = cell.states(60)
    checker = Checker(cell.scene_graph, cell.joints, accuracy=accuracy)
    least = by_evaluate(cell, states, want='least', accuracy=accuracy)
    clearances, gradients = checker.clearance_and_gradient(states)
    np.testing.assert_array_equal(clearances, least.distance - least.error_bound)
    np.testing.assert_array_equal(gradients, least.joint_gradient)
    for q, clearance, gradient in zip(states, clearances, gradients, strict=True):
        one = checker.clearance_and_gradient(q)
        assert one.clearance == clearance == checker.clearance(q)
        np.testing.assert_array_equal(one.gradient, gradient)


@pytest.mark.parametrize('within', [0.2, np.inf])
def test_distances_are_those_of_evaluate_in_a_fixed_order(cell, checker, within):
    states = cell.states(40)
    expected = by_evaluate(cell, states, want='within', max_distance=within)
    number_of = {tuple(pair): k for k, pair in enumerate(checker.pairs.tolist())}
    each = checker.distances_and_gradients(states, within=within)
    assert each.distance.shape == (40, len(checker.pairs))
    for s, q in enumerate(states):
        rows = slice(expected.offsets[s], expected.offsets[s + 1])
        ids = np.column_stack((expected.id_A, expected.id_B))[rows].tolist()
        numbers = [number_of[tuple(pair)] for pair in ids]
        one = checker.distances_and_gradients(q, within=within)
        for name in one._fields:
            np.testing.assert_array_equal(getattr(one, name), getattr(each, name)[s])
        np.testing.assert_array_equal(one.distance[numbers], expected.distance[rows])
        np.testing.assert_array_equal(one.gradient[numbers], expected.joint_gradient[rows])
        left_out = np.setdiff1d(np.arange(len(one.distance)), numbers)
        assert np.isinf(one.distance[left_out]).all()
        assert not one.gradient[left_out].any()
        assert not one.is_gradient_unique[left_out].any()
    assert (within == np.inf) == np.isfinite(each.distance).all()


def test_unique_is_what_the_query_says_of_each_pair(cell, checker):
    for q, query in zip(cell.states(30), cell.each(cell.states(30)), strict=True):
        results = query.ComputeSignedDistancePairwiseClosestPoints()
        found = checker.distances_and_gradients(q)
        ids = np.column_stack((results.id_A, results.id_B))
        np.testing.assert_array_equal(ids, checker.pairs)
        np.testing.assert_array_equal(found.is_gradient_unique, results.is_gradient_unique)
        least = checker.clearance_and_gradient(q)
        k = int(np.argmin(found.lower_bound))
        assert least.is_gradient_unique == bool(found.is_gradient_unique[k])


def test_gradients_are_central_differences_where_they_are_unique(cell, checker):
    step, smooth = 1e-6, 0
    for q in cell.states(25):
        middle = checker.distances_and_gradients(q)
        for joint in range(4):
            ends = np.array([q, q])
            ends[:, joint] += [-step, step]
            sides = checker.distances_and_gradients(ends)
            sure = middle.is_gradient_unique & sides.is_gradient_unique.all(axis=0)
            # Where the normal turns fast between the two sides, the difference is no slope.
            change = np.abs(sides.gradient[1] - sides.gradient[0])[:, joint]
            sure &= change < 1e-3
            slopes = (sides.distance[1] - sides.distance[0]) / (2.0 * step)
            off = np.abs(slopes - middle.gradient[:, joint])[sure]
            assert off.max(initial=0.0) < 2e-3
            smooth += int(sure.sum())
    assert smooth > 1000


def test_near_pairs_are_the_finite_ones(cell, checker):
    for q in cell.states(20):
        every = checker.distances_and_gradients(q, within=0.2)
        near = checker.near_pairs(q, within=0.2)
        np.testing.assert_array_equal(near.numbers, np.flatnonzero(np.isfinite(every.distance)))
        for name in every._fields:
            expected = getattr(every, name)[near.numbers]
            np.testing.assert_array_equal(getattr(near, name), expected)
    for bad in (np.zeros(3), np.zeros((2, 4))):
        with pytest.raises(ArgumentError, match='shape'):
            checker.near_pairs(bad, within=0.2)


def test_chosen_pairs_come_in_the_callers_order(cell, checker):
    q = cell.states(1)[0]
    every = checker.distances_and_gradients(q)
    numbers = np.random.default_rng(0).permutation(len(checker.pairs))[:7]
    chosen = [[GeometryId(b), a] for a, b in checker.pairs[numbers].tolist()]
    some = checker.distances_and_gradients(q, pairs=chosen)
    for name in some._fields:
        np.testing.assert_array_equal(getattr(some, name), getattr(every, name)[numbers])
    few = checker.distances_and_gradients(q[None], pairs=chosen, within=0.3)
    np.testing.assert_array_equal(np.isfinite(few.distance[0]), some.lower_bound <= 0.3)


@given(order=st.permutations(range(12)), within=st.sampled_from([0.05, 0.3, np.inf]))
def test_an_answer_does_not_depend_on_earlier_ones(cell, checker, order, within):
    states = cell.states(12, seed=3)
    expected = checker.distances_and_gradients(states, within=within)
    for s in order:
        found = checker.distances_and_gradients(states[s], within=within)
        for name in found._fields:
            np.testing.assert_array_equal(getattr(found, name), getattr(expected, name)[s])


def test_given_arrays_are_filled_and_unfit_ones_are_refused(cell, checker):
    first, second = cell.states(2)
    out = checker.distances_and_gradients(first, within=0.2)
    expected = checker.distances_and_gradients(second, within=0.2)
    assert checker.distances_and_gradients(second, within=0.2, out=out) is out
    for name in out._fields:
        np.testing.assert_array_equal(getattr(out, name), getattr(expected, name))
    for bad in (
        out._replace(distance=np.empty(3)),
        out._replace(gradient=out.gradient.astype(np.float32)),
        out._replace(is_gradient_unique=None),
        DistancesAndGradients.empty((2, len(checker.pairs)), 4),
    ):
        with pytest.raises(ArgumentError, match=r'out\.\w+ is '):
            checker.distances_and_gradients(second, within=0.2, out=bad)
    with pytest.raises(ArgumentError, match='must be finite'):
        checker.distances_and_gradients([np.nan, 0, 0, 0], within=0.2, out=out)
    np.testing.assert_array_equal(out.distance, expected.distance)


@pytest.mark.parametrize(
    ('pairs', 'words'),
    [
        ([[1, 2, 3]], r'\(1, 3\)'),
        ([], r'\(0,\)'),
        ([[-1, -2]], r'\(-1, -2\), which is no pair'),
        (None, 'twice'),
        (None, 'filters leave it out'),
    ],
)
def test_pairs_that_are_none_are_refused(cell, checker, pairs, words):
    if words == 'twice':
        pairs = np.vstack((checker.pairs[:1], checker.pairs[:1, ::-1]))
    if words == 'filters leave it out':
        things = [cell.loaded.geometries['things', 'world', name] for name in ('floor', 'wall')]
        pairs = [things]
    with pytest.raises(ArgumentError, match=words):
        checker.distances_and_gradients(cell.states(1)[0], pairs=pairs)


@pytest.mark.parametrize(
    ('q', 'words'),
    [
        (np.zeros(3), r'\(3,\)'),
        (np.zeros((2, 5)), r'\(2, 5\)'),
        ([0.0, np.inf, 0.0, 0.0], 'finite'),
        ([[0.0] * 4, [0.0, np.nan, 0.0, 0.0]], 'state 1: .*finite'),
    ],
)
def test_bad_states_are_refused(checker, q, words):
    for call in (checker.clearance_and_gradient, checker.distances_and_gradients):
        with pytest.raises(ArgumentError, match=words):
            call(q)


def test_a_distance_that_is_nan_is_refused(cell, checker):
    with pytest.raises(ArgumentError, match='within=nan'):
        checker.distances_and_gradients(cell.states(1)[0], within=np.nan)


def test_a_changed_scene_is_refused():
    own = Cell()
    checker = Checker(own.scene_graph, own.joints)
    ids = [own.loaded.geometries['things', 'world', name] for name in ('egg', 'pole')]
    declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(ids))
    own.scene_graph.collision_filter_manager().Apply(declaration)
    for call in (checker.clearance_and_gradient, checker.distances_and_gradients):
        with pytest.raises(GeometryError, match='was changed since'):
            call(own.states(1)[0])


def test_paddings_shorten_distances_and_change_no_gradient():
    text = Cell.path.read_text().replace('arm.urdf', str(Cell.path.with_name('arm.urdf')))
    checkers = []
    for scene in (text, text.replace('arm.urdf', 'arm.urdf, padding: 0.03')):
        graph = SceneGraph()
        checkers.append(Checker(graph, Joints.of(load_scene(scene, graph))))
    plain, padded = checkers
    states = np.random.default_rng(2).uniform(-2, 2, (30, 4))
    bare, found = (checker.distances_and_gradients(states) for checker in checkers)
    shift = np.array([0.03 * sum(name.startswith('arm') for name in p) for p in plain.pair_names])
    assert set(shift) == {0.0, 0.03, 0.06}
    np.testing.assert_allclose(found.distance, bare.distance - shift, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found.gradient, bare.gradient)
    clearances, gradients = padded.clearance_and_gradient(states)
    assert clearances.tolist() == [padded.clearance(q) for q in states]
    least = np.argmin(found.lower_bound, axis=1)
    np.testing.assert_array_equal(gradients, found.gradient[np.arange(30), least])
    near = padded.distances_and_gradients(states, within=0.1)
    np.testing.assert_array_equal(np.isfinite(near.distance), found.lower_bound <= 0.1)


def test_solids_have_gradients_that_are_unique_as_in_queries(tmp_path):
    corners = '\n'.join('v {} {} {}'.format(*(0.2 * row)) for row in BOX)
    faces = '\n'.join('f {} {} {}'.format(*(row + 1)) for row in SIDES)
    (tmp_path / 'box.obj').write_text(f'{corners}\n{faces}\n')
    own = Cell()
    X_WG = RigidTransform([0.3, -0.3, 0.0])
    body = GeometryInstance(X_WG, Mesh(str(tmp_path / 'box.obj')), 'solid')
    properties = ProximityProperties()
    properties.AddProperty('mesh', 'solid', True)
    body.set_proximity_properties(properties)
    source = own.scene_graph.model_inspector().GetAllSourceIds()[-1]
    own.scene_graph.RegisterAnchoredGeometry(source, body)
    checker, of_solid, unique = Checker(own.scene_graph, own.joints), 0, set()
    for q, query in zip(own.states(20), own.each(own.states(20)), strict=True):
        results = query.ComputeSignedDistancePairwiseClosestPoints()
        found = checker.distances_and_gradients(q)
        np.testing.assert_array_equal(found.distance, results.distance)
        np.testing.assert_array_equal(found.is_gradient_unique, results.is_gradient_unique)
        least = checker.clearance_and_gradient(q)
        k = int(np.argmin(found.lower_bound))
        np.testing.assert_array_equal(least.gradient, found.gradient[k])
        assert least.is_gradient_unique == found.is_gradient_unique[k]
        if any(name.endswith('/solid') for name in checker.pair_names[k]):
            of_solid += 1
            unique.add(least.is_gradient_unique)
    assert of_solid > 2
    assert True in unique


@pytest.mark.clock
def test_threads_share_a_checker(cell, checker):
    states = cell.states(80, seed=5)
    expected = checker.distances_and_gradients(states, within=0.3)
    wrong = []

    def ask(seed):
        for s in np.random.default_rng(seed).permutation(len(states)).tolist():
            found = checker.distances_and_gradients(states[s], within=0.3)
            if not np.array_equal(found.gradient, expected.gradient[s]):
                wrong.append(s)

    threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
