"""Constraints as functions of CasADi, which needs the extra ``casadi``."""

from __future__ import annotations

from typing import Any, Protocol

import casadi
import numpy as np

from drake_geom_ros.math.array_types import Floats


class Differentiable(Protocol):
    """A function of n values with m outputs and their derivatives."""

    def num_vars(self) -> int:
        """Return n."""

    def num_constraints(self) -> int:
        """Return m."""

    def value_and_jacobian(self, q: Floats) -> tuple[Floats, Floats]:
        """Return the outputs (m,) and their derivatives (m, n)."""


class _Jacobian(casadi.Callback):  # type: ignore[misc]
    """The derivatives (m, n), as CasADi calls them: of the values, and the outputs there."""

    def __init__(self, name: str, function: Differentiable, options: dict[str, Any]) -> None:
        casadi.Callback.__init__(self)
        self._function = function
        self.construct(name, options)

    def get_n_in(self) -> int:
        return 2

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, number: int) -> Any:
        function = self._function
        rows = function.num_constraints() if number else function.num_vars()
        return casadi.Sparsity.dense(rows, 1)

    def get_sparsity_out(self, number: int) -> Any:
        return casadi.Sparsity.dense(self._function.num_constraints(), self._function.num_vars())

    def eval(self, arguments: list[Any]) -> list[Any]:
        return [self._function.value_and_jacobian(np.array(arguments[0]).ravel())[1]]


class _Value(casadi.Callback):  # type: ignore[misc]
    """The outputs (m, 1) of values (n, 1)."""

    def __init__(self, name: str, function: Differentiable) -> None:
        casadi.Callback.__init__(self)
        self._function = function
        self._jacobians: list[_Jacobian] = []  # CasADi keeps none alive
        self.construct(name, {})

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, number: int) -> Any:
        return casadi.Sparsity.dense(self._function.num_vars(), 1)

    def get_sparsity_out(self, number: int) -> Any:
        return casadi.Sparsity.dense(self._function.num_constraints(), 1)

    def eval(self, arguments: list[Any]) -> list[Any]:
        return [self._function.value_and_jacobian(np.array(arguments[0]).ravel())[0]]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(
        self, name: str, inputs: list[str], outputs: list[str], options: dict[str, Any]
    ) -> Any:
        jacobian = _Jacobian(name, self._function, options)
        self._jacobians.append(jacobian)
        return jacobian


def casadi_callback(function: Differentiable, name: str) -> Any:
    """Return a function as a ``casadi.Callback``; it must outlive all that use it."""
    return _Value(name, function)
