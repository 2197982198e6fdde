"""Base of constraints on joint values: bounds, evaluation, adapters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue
from drake_geom_ros.common.extras import needed_for
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.math.array_types import Floats


class Constraint:
    """A smooth constraint lower <= f(q) <= upper on values q (n,), with m outputs.

    Any number of threads may evaluate one at once.
    """

    def __init__(self, columns: int, lower: ArrayLike, upper: ArrayLike) -> None:
        """Take the number of values and the bounds (m,) of the outputs."""
        self._columns = columns
        self._lower = np.array(lower, dtype=np.float64, ndmin=1)
        self._upper = np.array(upper, dtype=np.float64, ndmin=1)

    def num_vars(self) -> int:
        """Return the number n of values."""
        return self._columns

    def num_constraints(self) -> int:
        """Return the number m of outputs."""
        return len(self._lower)

    num_outputs = num_constraints

    def lower_bound(self) -> Floats:
        """Return the lower bounds (m,) of the outputs."""
        return self._lower.copy()

    def upper_bound(self) -> Floats:
        """Return the upper bounds (m,) of the outputs."""
        return self._upper.copy()

    def value_and_jacobian(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Return the outputs (m,) and their derivatives (m, n) in one evaluation.

        Args:
            q: values (n,) in [rad] or [m].

        Raises:
            ArgumentError: another number of values, or one that is not finite.
            GeometryError: the scene has changed, or a distance is undefined.
        """
        raise NotImplementedError

    def Eval(self, x: ArrayLike) -> Any:
        """Return the outputs (m,); for AutoDiffXd values (n,), AutoDiffXd outputs.

        Raises as ``value_and_jacobian``.
        """
        values = np.asarray(x)
        if values.dtype != object or not any(isinstance(v, AutoDiffXd) for v in values.flat):
            return self.value_and_jacobian(values)[0]
        outputs, jacobian = self.value_and_jacobian(ExtractValue(values).ravel())
        gradients = jacobian @ ExtractGradient(values)
        pairs = zip(outputs.tolist(), gradients, strict=True)
        return np.array([AutoDiffXd(value, gradient) for value, gradient in pairs], dtype=object)

    def Jacobian(self, x: ArrayLike) -> Floats:
        """Return the derivatives (m, n) of the outputs; raises as ``value_and_jacobian``."""
        return self.value_and_jacobian(x)[1]

    def HessianVectorProduct(
        self, x: ArrayLike, v: ArrayLike, weights: ArrayLike, step: float = 2.0**-20
    ) -> Floats:
        """Return the Hessian of the weighted sum of all outputs times a vector (n,).

        It is the central difference of the Jacobian along v, at ``step`` times the largest of 1
        and the values' magnitudes. Where the Jacobian jumps, it is the jump over two steps.

        Args:
            x: values (n,).
            v: direction (n,).
            weights: (m,) of the outputs, such as Lagrange multipliers.
            step: length of a step, relative [-].

        Raises:
            ArgumentError: a ``step`` that is not above 0; and as ``value_and_jacobian``.
        """
        q, direction = np.asarray(x, dtype=np.float64), np.asarray(v, dtype=np.float64)
        number = as_number(step)
        if number is None or not 0.0 < number < 1.0:
            raise ArgumentError(f'step={step!r} must be above 0 and below 1')
        length = float(np.linalg.norm(direction))
        if length == 0.0:
            return np.zeros(self._columns)
        h = number * max(1.0, float(np.abs(q).max(initial=0.0))) / length
        ahead, behind = self.Jacobian(q + h * direction), self.Jacobian(q - h * direction)
        product: Floats = np.asarray(weights, dtype=np.float64) @ (ahead - behind) / (2.0 * h)
        return product

    def CheckSatisfied(self, x: ArrayLike, tol: float = 1.0 / 2**20) -> bool:
        """Return whether all outputs are within their bounds, up to ``tol`` [-]."""
        outputs, _ = self.value_and_jacobian(x)
        return bool(np.all((outputs >= self._lower - tol) & (outputs <= self._upper + tol)))

    def as_scipy(self) -> Any:
        """Return a ``scipy.optimize.NonlinearConstraint`` with the exact Jacobian.

        ``scipy.optimize.minimize`` takes it with SLSQP and trust-constr, and so does
        ``cyipopt.minimize_ipopt``. Curvature is estimated by BFGS.
        """
        from scipy.optimize import BFGS, NonlinearConstraint

        return NonlinearConstraint(
            lambda q: self.value_and_jacobian(q)[0],
            self._lower.copy(),
            self._upper.copy(),
            jac=self.Jacobian,
            hess=BFGS(),
        )

    def as_casadi(self, name: str = 'constraint') -> Any:
        """Return a ``casadi.Callback`` from values (n,) to outputs (m,), with its Jacobian.

        It must outlive all functions that use it: CasADi does not keep it alive. Raises
        ImportError without CasADi, the extra ``casadi``.
        """
        with needed_for('functions of CasADi', 'casadi'):
            from drake_geom_ros.optimization.casadi_callback import casadi_callback

        return casadi_callback(self, name)
