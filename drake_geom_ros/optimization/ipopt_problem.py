"""``ipopt_problem``: a cost and constraints as a problem of cyipopt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.common.extras import needed_for
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.optimization.constraint import Constraint

Cost = Callable[[Floats], tuple[float, ArrayLike]]


def ipopt_problem(
    cost: Cost, constraints: Sequence[Constraint], lower: ArrayLike, upper: ArrayLike
) -> Any:
    """Return a ``cyipopt.Problem`` whose ``solve(q0)`` returns the best values and a report.

    Each state is evaluated once for outputs and derivatives together. IPOPT approximates the
    Hessian (``hessian_approximation='limited-memory'``); its options are set by ``add_option``.
    Needs cyipopt, the extra ``ipopt``.

    Args:
        cost: from values (n,) to a number and its gradient (n,).
        constraints: of the same n values.
        lower: (n,) bounds of the values.
        upper: (n,) likewise.

    Raises:
        ArgumentError: bounds of another number than a constraint has values.
        ImportError: cyipopt is not installed.
    """
    with needed_for('problems of IPOPT', 'ipopt'):
        import cyipopt

    low, high = (np.array(values, dtype=np.float64, ndmin=1) for values in (lower, upper))
    for constraint in constraints:
        if not low.shape == high.shape == (constraint.num_vars(),):
            raise ArgumentError(
                f'lower has the shape {low.shape} and upper {high.shape}; both must be '
                f'({constraint.num_vars()},), the number of values of {type(constraint).__name__}'
            )
    none = np.zeros(0)
    problem = cyipopt.Problem(
        n=len(low),
        m=sum(constraint.num_constraints() for constraint in constraints),
        problem_obj=_Callbacks(cost, constraints),
        lb=low,
        ub=high,
        cl=np.concatenate([none, *(constraint.lower_bound() for constraint in constraints)]),
        cu=np.concatenate([none, *(constraint.upper_bound() for constraint in constraints)]),
    )
    problem.add_option('hessian_approximation', 'limited-memory')
    return problem


class _Callbacks:
    """Callbacks of IPOPT, which calls several at the same values; these are evaluated once."""

    def __init__(self, cost: Cost, constraints: Sequence[Constraint]) -> None:
        self._cost = cost
        self._constraints = tuple(constraints)
        self._costs: tuple[bytes, tuple[float, ArrayLike]] | None = None
        self._outputs: tuple[bytes, tuple[Floats, Floats]] | None = None

    def objective(self, q: Floats) -> float:
        return self._cost_of(q)[0]

    def gradient(self, q: Floats) -> ArrayLike:
        return self._cost_of(q)[1]

    def constraints(self, q: Floats) -> Floats:
        return self._outputs_of(q)[0]

    def jacobian(self, q: Floats) -> Floats:
        return self._outputs_of(q)[1].ravel()

    def _cost_of(self, q: Floats) -> tuple[float, ArrayLike]:
        if self._costs is None or self._costs[0] != q.tobytes():
            self._costs = q.tobytes(), self._cost(q.copy())
        return self._costs[1]

    def _outputs_of(self, q: Floats) -> tuple[Floats, Floats]:
        if self._outputs is None or self._outputs[0] != q.tobytes():
            answers = [each.value_and_jacobian(q.copy()) for each in self._constraints]
            values = np.concatenate([np.zeros(0), *(value for value, _ in answers)])
            rows = np.concatenate([np.zeros((0, q.size)), *(jacobian for _, jacobian in answers)])
            self._outputs = q.tobytes(), (values, rows)
        return self._outputs[1]
