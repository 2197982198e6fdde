"""Inverse kinematics with a minimum distance, by SciPy, CasADi, cyipopt, and pydrake's solvers."""

import itertools
import sys

import numpy as np
import pytest
from scipy.optimize import minimize

from drake_geom_ros.geometry import ArgumentError, GeometryError
from drake_geom_ros.optimization import MinimumDistanceLowerBoundConstraint, ipopt_problem

BOUND, OFFSET = 0.05, 0.2  # [m]
GOAL = np.array([0.62, 0.35, 0.0])  # [rad], [rad], [m]: the elbow would be in the box
START = np.array([-0.2, -0.3, 0.1])


def cost(q):
    return float(np.sum((q - GOAL) ** 2))


def slope(q):
    return 2.0 * (q - GOAL)


@pytest.fixture
def constraint(planar):
    assert planar.checker.clearance(GOAL) < 0.0
    return MinimumDistanceLowerBoundConstraint(planar.checker, BOUND, OFFSET)


@pytest.fixture(scope='module')
def best(planar):
    """Return the least cost at the clearance, of the best of many starts of SciPy's."""
    constraint = MinimumDistanceLowerBoundConstraint(planar.checker, BOUND, OFFSET)
    found = [by_scipy(planar, constraint, q) for q in planar.states(12, seed=2)]
    good = [r for r in found if r.success and planar.checker.clearance(r.x) >= BOUND - 1e-6]
    return min(cost(r.x) for r in good)


def by_scipy(planar, constraint, start, method='SLSQP'):
    limits = list(zip(planar.joints.lower, planar.joints.upper, strict=True))
    how = {'jac': slope, 'bounds': limits, 'constraints': [constraint.as_scipy()]}
    tight = {'ftol': 1e-10} if method == 'SLSQP' else {'gtol': 1e-8, 'xtol': 1e-10}
    return minimize(cost, start, method=method, options={'maxiter': 500, **tight}, **how)


@pytest.mark.parametrize('method', ['SLSQP', 'trust-constr'])
def test_scipy_keeps_the_distance(planar, constraint, best, method):
    found = by_scipy(planar, constraint, START, method)
    assert planar.checker.clearance(found.x) >= BOUND - 1e-4
    assert cost(found.x) >= best - 1e-4
    assert cost(found.x) < cost(START)


def test_casadi_keeps_the_distance_and_differentiates(planar, constraint, best):
    casadi = pytest.importorskip('casadi', reason='the extra casadi')
    function = constraint.as_casadi('clear')
    q = casadi.MX.sym('q', 3)
    jacobian = casadi.Function('J', [q], [casadi.jacobian(function(q), q)])
    for state in planar.states(5):
        np.testing.assert_array_equal(np.array(function(state)).ravel(), constraint.Eval(state))
        np.testing.assert_array_equal(np.array(jacobian(state)), constraint.Jacobian(state))
    problem = {'x': q, 'f': casadi.sumsqr(q - GOAL), 'g': function(q)}
    quiet = {'ipopt.print_level': 0, 'print_time': False, 'ipopt.sb': 'yes'}
    options = {'ipopt.hessian_approximation': 'limited-memory', **quiet}
    solver = casadi.nlpsol('solver', 'ipopt', problem, options)
    answer = solver(
        x0=START,
        lbx=planar.joints.lower,
        ubx=planar.joints.upper,
        lbg=constraint.lower_bound(),
        ubg=constraint.upper_bound(),
    )
    found = np.array(answer['x']).ravel()
    assert solver.stats()['success']
    assert planar.checker.clearance(found) >= BOUND - 1e-6
    assert cost(found) >= best - 1e-6


def test_cyipopt_takes_what_scipy_takes(planar, constraint, best):
    cyipopt = pytest.importorskip('cyipopt', reason='the extra ipopt')
    limits = list(zip(planar.joints.lower, planar.joints.upper, strict=True))
    found = cyipopt.minimize_ipopt(
        cost, START, jac=slope, bounds=limits, constraints=[constraint.as_scipy()]
    )
    assert planar.checker.clearance(found.x) >= BOUND - 1e-6
    assert cost(found.x) >= best - 1e-6


def problem_of(planar, constraints):
    problem = ipopt_problem(
        lambda q: (cost(q), slope(q)), constraints, planar.joints.lower, planar.joints.upper
    )
    for name, value in {'print_level': 0, 'sb': 'yes'}.items():
        problem.add_option(name, value)
    return problem


def test_a_problem_of_ipopt_keeps_every_constraint(planar, constraint, best):
    pytest.importorskip('cyipopt', reason='the extra ipopt')
    found, report = problem_of(planar, [constraint]).solve(START)
    assert report['status'] == 0
    assert planar.checker.clearance(found) >= BOUND - 1e-6
    assert cost(found) == pytest.approx(best, abs=1e-5)
    free, _ = problem_of(planar, []).solve(START)
    np.testing.assert_allclose(free, GOAL, rtol=0, atol=1e-6)
    farther = MinimumDistanceLowerBoundConstraint(planar.checker, 2.0 * BOUND, OFFSET)
    both, report = problem_of(planar, [constraint, farther]).solve(START)
    assert report['status'] == 0
    assert planar.checker.clearance(both) >= 2.0 * BOUND - 1e-6
    assert cost(both) > cost(found)


def test_a_problem_of_ipopt_evaluates_each_state_once(planar, constraint, monkeypatch):
    pytest.importorskip('cyipopt', reason='the extra ipopt')
    asked, evaluate = [], constraint.value_and_jacobian
    monkeypatch.setattr(
        constraint, 'value_and_jacobian', lambda q: (asked.append(q.tobytes()), evaluate(q))[1]
    )
    problem_of(planar, [constraint]).solve(START)
    assert len(asked) > 5
    assert all(a != b for a, b in itertools.pairwise(asked))


def test_errors_of_a_constraint_end_ipopt(planar, constraint, monkeypatch):
    pytest.importorskip('cyipopt', reason='the extra ipopt')

    def refuse(q):
        raise GeometryError('the scene has changed')

    monkeypatch.setattr(constraint, 'value_and_jacobian', refuse)
    with pytest.raises(GeometryError, match='the scene has changed'):
        problem_of(planar, [constraint]).solve(START)


def test_bounds_of_another_number_are_refused(planar, constraint):
    pytest.importorskip('cyipopt', reason='the extra ipopt')
    with pytest.raises(ArgumentError, match=r'lower has the shape \(2,\).*must be \(3,\)'):
        ipopt_problem(lambda q: (cost(q), slope(q)), [constraint], START[:2], START)


@pytest.mark.parametrize(('module', 'extra'), [('cyipopt', 'ipopt'), ('casadi', 'casadi')])
def test_a_missing_solver_is_named_with_its_extra(planar, constraint, monkeypatch, module, extra):
    monkeypatch.setitem(sys.modules, module, None)  # as if it were not installed
    monkeypatch.delitem(sys.modules, 'drake_geom_ros.optimization.casadi_callback', raising=False)
    with pytest.raises(ImportError, match=rf'need {module}.*drake_geom_ros\[{extra}\]'):
        problem_of(planar, [constraint]) if module == 'cyipopt' else constraint.as_casadi()


@pytest.mark.parametrize('name', ['IpoptSolver', 'SnoptSolver'])
def test_the_solvers_of_pydrake_find_no_better(planar, constraint, best, name):
    """By their own constraint of the same bound, and by ours in the same program."""
    pytest.importorskip('pydrake', reason='IPOPT and SNOPT')
    from optimization.drake_twin import DrakeTwin
    from pydrake.multibody import inverse_kinematics as drake
    from pydrake.solvers import IpoptSolver, MathematicalProgram, SnoptSolver

    twin = DrakeTwin()
    solver = {'IpoptSolver': IpoptSolver, 'SnoptSolver': SnoptSolver}[name]()
    if not (solver.available() and solver.enabled()):
        pytest.skip(f'{name} is not available')
    theirs = drake.MinimumDistanceLowerBoundConstraint(
        twin.plant, BOUND, twin.plant_context, influence_distance_offset=OFFSET
    )
    found = {}
    for kind in ('theirs', 'ours'):
        program = MathematicalProgram()
        q = program.NewContinuousVariables(3, 'q')
        program.AddBoundingBoxConstraint(planar.joints.lower, planar.joints.upper, q)
        program.AddQuadraticErrorCost(np.eye(3), GOAL, q)
        if kind == 'theirs':
            program.AddConstraint(theirs, q)
        else:
            program.AddConstraint(
                lambda x: evaluated(constraint, x),
                lb=constraint.lower_bound(),
                ub=constraint.upper_bound(),
                vars=q,
            )
        result = solver.Solve(program, START, None)
        assert result.is_success()
        found[kind] = result.GetSolution(q)
        assert planar.checker.clearance(found[kind]) >= BOUND - 1e-5
        assert cost(found[kind]) >= best - 1e-5
    assert cost(found['ours']) == pytest.approx(cost(found['theirs']), abs=1e-4)


def evaluated(constraint, x):
    """Return outputs for pydrake, of its numbers with gradients or of doubles."""
    from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

    if x.dtype != object:
        return constraint.Eval(x)
    outputs, jacobian = constraint.value_and_jacobian(ExtractValue(x).ravel())
    return InitializeAutoDiff(outputs, gradient=jacobian @ ExtractGradient(x)).ravel()
