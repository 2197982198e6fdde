"""Constraints on distances: beside pydrake's of the same names, differences, and solvers."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_geom_ros.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from drake_geom_ros.batch import Checker
from drake_geom_ros.geometry import ArgumentError, GeometryError
from drake_geom_ros.optimization import (
    DistanceConstraint,
    ExponentiallySmoothedHingeLoss,
    MinimumDistanceLowerBoundConstraint,
    MinimumDistanceUpperBoundConstraint,
    QuadraticallySmoothedHingeLoss,
)
from drake_geom_ros.optimization.penalties import smooth_over_maximum, smooth_under_maximum

PENALTIES = [QuadraticallySmoothedHingeLoss, ExponentiallySmoothedHingeLoss]


@pytest.fixture(scope='module')
def twin():
    pytest.importorskip('pydrake', reason='the same constraints')
    from optimization.drake_twin import DrakeTwin

    return DrakeTwin()


def constraints_of(planar):
    return [
        MinimumDistanceLowerBoundConstraint(planar.checker, 0.02, 0.3),
        MinimumDistanceUpperBoundConstraint(planar.checker, 0.02, 0.5),
        MinimumDistanceLowerBoundConstraint(
            planar.checker, -0.05, 0.2, ExponentiallySmoothedHingeLoss
        ),
        DistanceConstraint(
            planar.checker, (planar.geometries['box'], planar.geometries['hand']), 0.1, 0.2
        ),
    ]


@pytest.mark.parametrize('offset', [0.01, 0.3, 1.0])
@pytest.mark.parametrize('penalty', [None, ExponentiallySmoothedHingeLoss])
def test_minimum_distances_are_those_of_pydrake(planar, twin, offset, penalty):
    from pydrake import autodiffutils
    from pydrake.multibody import inverse_kinematics as drake

    assert len(planar.checker.pairs) == twin.pairs
    how = {'penalty_function': penalty, 'influence_distance_offset': offset}
    nonzero = 0
    for ours, theirs in (
        (
            MinimumDistanceLowerBoundConstraint(planar.checker, 0.03, **how),
            drake.MinimumDistanceLowerBoundConstraint(twin.plant, 0.03, twin.plant_context, **how),
        ),
        (
            MinimumDistanceUpperBoundConstraint(planar.checker, 0.03, **how),
            drake.MinimumDistanceUpperBoundConstraint(twin.plant, 0.03, twin.plant_context, **how),
        ),
    ):
        np.testing.assert_array_equal(ours.lower_bound(), theirs.lower_bound())
        np.testing.assert_array_equal(ours.upper_bound(), theirs.upper_bound())
        assert (ours.num_vars(), ours.num_constraints()) == (theirs.num_vars(), 1)
        for q in planar.states(40):
            value, scale = theirs.Eval(q), max(1.0, abs(theirs.Eval(q)[0]))
            np.testing.assert_allclose(ours.Eval(q), value, rtol=0, atol=1e-6 * scale)
            slopes = autodiffutils.ExtractGradient(
                theirs.Eval(autodiffutils.InitializeAutoDiff(q).ravel())
            )
            slopes = slopes if slopes.size else np.zeros((1, 3))
            limit = 1e-4 * max(1.0, np.abs(slopes).max())
            np.testing.assert_allclose(ours.Jacobian(q), slopes, rtol=0, atol=limit)
            nonzero += bool(np.abs(slopes).max() > 1e-3)
    assert nonzero > 2


def test_the_distance_of_a_pair_is_that_of_pydrake(planar, twin):
    from pydrake.multibody import inverse_kinematics as drake

    names = ('box', 'tip')
    ours = DistanceConstraint(planar.checker, [planar.geometries[n] for n in names], 0.1, 0.4)
    theirs = drake.DistanceConstraint(
        twin.plant, tuple(twin.geometries[n] for n in names), twin.plant_context, 0.1, 0.4
    )
    for q in planar.states(20):
        np.testing.assert_allclose(ours.Eval(q), theirs.Eval(q), rtol=0, atol=1e-9)
        assert ours.CheckSatisfied(q) == theirs.CheckSatisfied(q)


def test_jacobians_are_central_differences(planar):
    step, seen = 1e-6, 0
    for constraint in constraints_of(planar):
        for q in planar.states(30):
            jacobian = constraint.Jacobian(q)
            steps = step * np.eye(3)
            sides = [[constraint.Eval(q + s * d)[0] for d in steps] for s in (1.0, -1.0)]
            slopes = np.subtract(*sides) / (2.0 * step)
            limit = 1e-5 * max(1.0, np.abs(slopes).max())
            np.testing.assert_allclose(jacobian[0], slopes, rtol=0, atol=limit)
            seen += bool(np.abs(slopes).max() > 1e-3)
    assert seen > 60


def test_hessian_vector_products_are_differences_of_jacobians(planar):
    constraint, rng = constraints_of(planar)[3], np.random.default_rng(1)
    for q in planar.states(5):
        v, h = rng.normal(size=3), 1e-5
        expected = (constraint.Jacobian(q + h * v) - constraint.Jacobian(q - h * v))[0] / (2 * h)
        found = constraint.HessianVectorProduct(q, v, [2.0])
        np.testing.assert_allclose(found, 2.0 * expected, rtol=0, atol=1e-4)
        assert not constraint.HessianVectorProduct(q, np.zeros(3), [2.0]).any()
    with pytest.raises(ArgumentError, match='step=0'):
        constraint.HessianVectorProduct(q, v, [1.0], step=0.0)


@given(seed=st.integers(0, 2**31))
def test_a_satisfied_lower_bound_is_certified(planar, seed):
    constraint = MinimumDistanceLowerBoundConstraint(planar.checker, 0.05, 0.2)
    (q,) = planar.states(1, seed)
    if constraint.CheckSatisfied(q, tol=0.0):
        assert planar.checker.clearance(q) >= 0.05 - 1e-12


@pytest.mark.parametrize('accuracy', ['bound', 'fast'])
def test_rough_answers_are_taken_by_their_safe_end(planar, accuracy):
    rough = Checker(planar.scene_graph, planar.joints, accuracy=accuracy)
    pair = [planar.geometries['box'], planar.geometries['hand']]
    sides = [DistanceConstraint(rough, pair, *r) for r in ((0.1, math.inf), (-math.inf, 0.1))]
    exact = DistanceConstraint(planar.checker, pair, 0.1, 0.2)
    lower, satisfied = (
        [MinimumDistanceLowerBoundConstraint(c, 0.02, 0.3) for c in (rough, planar.checker)],
        0,
    )
    for q in planar.states(40):
        (below,), (distance,), (above,) = (c.Eval(q) for c in (sides[0], exact, sides[1]))
        assert below <= distance + 1e-12
        assert distance <= above + 1e-12
        assert lower[0].Eval(q)[0] >= lower[1].Eval(q)[0] - 1e-9
        within = DistanceConstraint(rough, pair, distance - 1e-9, distance + 1e-9)
        satisfied += within.CheckSatisfied(q, tol=0.0)
        assert not within.CheckSatisfied(q, tol=0.0) or above - below <= 2e-9
    assert satisfied < 40 or accuracy == 'fast'


def test_autodiff_values_carry_gradients(planar):
    constraint, (q,) = constraints_of(planar)[0], planar.states(1)
    along = np.array([[1.0, 0.5], [0.0, 2.0], [3.0, -1.0]])
    values = InitializeAutoDiff(q).ravel()
    np.testing.assert_array_equal(
        ExtractValue(constraint.Eval(values)).ravel(), constraint.Eval(q)
    )
    np.testing.assert_array_equal(ExtractGradient(constraint.Eval(values)), constraint.Jacobian(q))
    mixed = np.array([v + 0.0 for v in values])
    for k, number in enumerate(mixed):
        mixed[k] = type(number)(number.value(), along[k])
    np.testing.assert_allclose(
        ExtractGradient(constraint.Eval(mixed)), constraint.Jacobian(q) @ along, rtol=1e-12
    )


@pytest.mark.parametrize('penalty', PENALTIES)
@given(x=st.floats(-5.0, 1.0))
def test_penalties_are_smooth_hinges(penalty, x):
    assume(abs(x) > 1e-3)
    value, slope = penalty(x, True)
    assert penalty(x, False) == (value, None)
    with mpmath.workdps(40):

        def exactly(t):
            if t >= 0:
                return mpmath.mpf(0)
            if penalty is ExponentiallySmoothedHingeLoss:
                return -t * mpmath.exp(1 / t)
            return t * t / 2 if t > -1 else -mpmath.mpf(1) / 2 - t

        exact = exactly(mpmath.mpf(x))
        h = mpmath.mpf(10) ** -15
        difference = (exactly(x + h) - exactly(x - h)) / (2 * h)
        assert abs(value - exact) <= 1e-15 * (1 + abs(exact))
        assert abs(slope - difference) <= 1e-12 * (1 + abs(difference))
    assert penalty(-5e-324, True) == (0.0, 0.0) or penalty(-5e-324, True)[0] < 1e-300


@given(
    values=st.lists(st.floats(-2.0, 20.0), max_size=5),
    zeros=st.integers(0, 4000),
)
def test_smooth_maxima_are_on_either_side_of_the_largest(values, zeros):
    assume(values or zeros)
    array = np.array(values)
    over, d_over = smooth_over_maximum(array, zeros)
    under, d_under = smooth_under_maximum(array, zeros)
    everything = values + [0.0] * zeros
    assert under - 1e-12 <= max(everything) <= over
    with mpmath.workdps(40):
        weights = [mpmath.exp(100 * mpmath.mpf(v)) for v in values]
        total = mpmath.fsum(weights) + zeros
        assert abs(over - mpmath.log(total) / 100) < 1e-12
        mean = mpmath.fsum(w * mpmath.mpf(v) for w, v in zip(weights, values, strict=True)) / total
        assert abs(under - mean) < 1e-12
        for w, v, slope_over, slope_under in zip(weights, values, d_over, d_under, strict=True):
            assert abs(slope_over - w / total) < 1e-11
            assert abs(slope_under - w / total * (1 + 100 * (v - mean))) < 1e-9


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        ({'bound': math.nan}, 'bound=nan'),
        ({'bound': 'x'}, "bound='x'"),
        ({'influence_distance_offset': 0.0}, 'influence_distance_offset=0.0'),
        ({'influence_distance_offset': math.inf}, 'influence_distance_offset=inf'),
        ({'penalty_function': lambda x, g: (0.0, 0.0)}, r'penalty_function\(-1, True\)'),
        ({'checker': None}, 'checker=None'),
    ],
)
def test_bad_arguments_are_refused(planar, arguments, words):
    usual = {'checker': planar.checker, 'bound': 0.01, 'influence_distance_offset': 0.1}
    for kind in (MinimumDistanceLowerBoundConstraint, MinimumDistanceUpperBoundConstraint):
        with pytest.raises(ArgumentError, match=words):
            kind(**usual | arguments)


def test_bad_pairs_and_states_are_refused(planar):
    ids = planar.geometries
    with pytest.raises(ArgumentError, match='is no pair of this checker'):
        DistanceConstraint(planar.checker, (ids['box'], ids['ball']), 0.0, 1.0)
    for limits in ((1.0, 0.0), (math.nan, 1.0), (None, 1.0)):
        with pytest.raises(ArgumentError, match='distance_lower='):
            DistanceConstraint(planar.checker, (ids['box'], ids['tip']), *limits)
    for constraint in constraints_of(planar):
        for q in (np.zeros(4), np.zeros((2, 3)), [0.0, math.nan, 0.0]):
            with pytest.raises(ArgumentError):
                constraint.Eval(q)


def test_crossing_half_spaces_are_an_error_and_no_number(tmp_path):
    from batch.test_half_spaces_on_joints import Press

    press = Press(tmp_path)
    checker = Checker(press.scene, press.joints)
    pair = tuple(checker.pairs[-1].tolist())
    for constraint in (
        MinimumDistanceLowerBoundConstraint(checker, 0.02, 0.3),
        DistanceConstraint(checker, pair, 0.0, 1.0),
    ):
        assert np.isfinite(constraint.Eval([0.5, 0.0])).all()
        with pytest.raises(GeometryError, match='half spaces that cross'):
            constraint.Eval([0.5, 0.1])
