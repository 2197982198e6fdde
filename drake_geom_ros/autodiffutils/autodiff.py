"""``AutoDiffXd``: a number with derivatives, which operations propagate (forward mode)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats


class AutoDiffXd:
    """A value and its derivatives (n,) by n independent variables; by pydrake's name.

    Made from a value, which makes a constant; from a value and its derivatives; or from a value,
    the number of variables and its own index among them. Constants, whose derivatives are empty,
    combine with any number; other operands must have equally many variables, or RuntimeError is
    raised. Comparisons are those of the values. NumPy's functions work on arrays of these.

        >>> x, y = AutoDiffXd(3.0, 2, 0), AutoDiffXd(2.0, 2, 1)
        >>> (x * y).value(), (x * y).derivatives().tolist()
        (6.0, [2.0, 3.0])
    """

    __slots__ = ('_derivatives', '_value')
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self,
        value: float,
        derivatives: ArrayLike | int = (),
        offset: int | None = None,
        *,
        size: int | None = None,
    ) -> None:
        self._value = float(value)
        if offset is None:
            self._derivatives: Floats = np.array(derivatives, dtype=np.float64).reshape(-1)
        else:
            count: Any = derivatives if size is None else size
            self._derivatives = np.eye(1, int(count), offset)[0]

    def value(self) -> float:
        """Return the value."""
        return self._value

    def derivatives(self) -> Floats:
        """Return the derivatives (n,), empty for a constant."""
        return self._derivatives.copy()

    def _after(self, value: float, slope: float) -> AutoDiffXd:
        """Return a function of this number, by the chain rule with its ``slope``."""
        return AutoDiffXd(value, slope * self._derivatives)

    def _with(self, other: AutoDiffXd, value: float, by_a: float, by_b: float) -> AutoDiffXd:
        """Return a function of this number a and another b, by its partial derivatives."""
        a, b = self._derivatives, other._derivatives
        if a.size and b.size and a.size != b.size:
            raise RuntimeError(
                f'AutoDiffXd: numbers of {a.size} and of {b.size} independent variables met; both '
                'must be of the same ones, see InitializeAutoDiffTuple'
            )
        if not (a.size and b.size):
            return AutoDiffXd(value, by_a * a if a.size else by_b * b)
        return AutoDiffXd(value, by_a * a + by_b * b)

    def __add__(self, other: Any) -> Any:
        return _binary(other, lambda y: self._with(y, self._value + y._value, 1.0, 1.0))

    def __sub__(self, other: Any) -> Any:
        return _binary(other, lambda y: self._with(y, self._value - y._value, 1.0, -1.0))

    def __mul__(self, other: Any) -> Any:
        return _binary(
            other, lambda y: self._with(y, self._value * y._value, y._value, self._value)
        )

    def __truediv__(self, other: Any) -> Any:
        def divided(y: AutoDiffXd) -> AutoDiffXd:
            quotient = self._value / y._value
            return self._with(y, quotient, 1.0 / y._value, -quotient / y._value)

        return _binary(other, divided)

    def __pow__(self, other: Any) -> Any:
        """Return this number to a power."""

        def raised(y: AutoDiffXd) -> AutoDiffXd:
            x, power = self._value, _power(self._value, y._value)
            slope = y._value * _power(x, y._value - 1.0) if y._value != 0.0 else 0.0
            varies = y._derivatives.any()  # a constant exponent is allowed for any base
            return self._with(y, power, slope, power * math.log(x) if varies else 0.0)

        return _binary(other, raised)

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __rsub__(self, other: Any) -> Any:
        return _binary(other, lambda y: y - self)

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __rtruediv__(self, other: Any) -> Any:
        return _binary(other, lambda y: y / self)

    def __rpow__(self, other: Any) -> Any:
        return _binary(other, lambda y: y**self)

    def __neg__(self) -> AutoDiffXd:
        return self._after(-self._value, -1.0)

    def __pos__(self) -> AutoDiffXd:
        return self

    def __abs__(self) -> AutoDiffXd:
        """Return the absolute value."""
        return self._after(abs(self._value), 1.0 if self._value >= 0.0 else -1.0)

    def __ceil__(self) -> float:
        """Return the smallest integer not below the value."""
        return float(math.ceil(self._value))

    def __floor__(self) -> float:
        """Return the largest integer not above the value."""
        return float(math.floor(self._value))

    def max(self, other: Any) -> AutoDiffXd:
        """Return the larger number; if equal, this one unless it is a constant."""
        y = _number(other)
        return y if y._value > self._value or self._gives_way(y) else self

    def min(self, other: Any) -> AutoDiffXd:
        """Return the smaller number; if equal, this one unless it is a constant."""
        y = _number(other)
        return y if y._value < self._value or self._gives_way(y) else self

    def _gives_way(self, other: AutoDiffXd) -> bool:
        return other._value == self._value and not self._derivatives.size

    def __eq__(self, other: object) -> Any:
        return _compared(other, lambda y: self._value == y)

    def __ne__(self, other: object) -> Any:
        return _compared(other, lambda y: self._value != y)

    def __lt__(self, other: Any) -> Any:
        return _compared(other, lambda y: self._value < y)

    def __le__(self, other: Any) -> Any:
        return _compared(other, lambda y: self._value <= y)

    def __gt__(self, other: Any) -> Any:
        return _compared(other, lambda y: self._value > y)

    def __ge__(self, other: Any) -> Any:
        return _compared(other, lambda y: self._value >= y)

    def __repr__(self) -> str:
        return f'AutoDiffXd({self._value}, {self._derivatives.tolist()})'

    def __str__(self) -> str:
        return f'AD{{{self._value}, nderiv={self._derivatives.size}}}'

    # NumPy calls these for its functions on arrays of objects.

    def sqrt(self) -> AutoDiffXd:
        """Return the square root."""
        root = math.sqrt(self._value)
        return self._after(root, 0.5 / root if root else math.inf)

    def exp(self) -> AutoDiffXd:
        """Return e to the power of this number."""
        return self._after(math.exp(self._value), math.exp(self._value))

    def log(self) -> AutoDiffXd:
        """Return the natural logarithm."""
        return self._after(math.log(self._value), 1.0 / self._value)

    def sin(self) -> AutoDiffXd:
        """Return the sine."""
        return self._after(math.sin(self._value), math.cos(self._value))

    def cos(self) -> AutoDiffXd:
        """Return the cosine."""
        return self._after(math.cos(self._value), -math.sin(self._value))

    def tan(self) -> AutoDiffXd:
        """Return the tangent."""
        return self._after(math.tan(self._value), 1.0 + math.tan(self._value) ** 2)

    def sinh(self) -> AutoDiffXd:
        """Return the hyperbolic sine."""
        return self._after(math.sinh(self._value), math.cosh(self._value))

    def cosh(self) -> AutoDiffXd:
        """Return the hyperbolic cosine."""
        return self._after(math.cosh(self._value), math.sinh(self._value))

    def tanh(self) -> AutoDiffXd:
        """Return the hyperbolic tangent."""
        return self._after(math.tanh(self._value), 1.0 - math.tanh(self._value) ** 2)

    def arcsin(self) -> AutoDiffXd:
        """Return the angle [rad] with this sine."""
        return self._after(math.asin(self._value), 1.0 / math.sqrt(1.0 - self._value**2))

    def arccos(self) -> AutoDiffXd:
        """Return the angle [rad] with this cosine."""
        return self._after(math.acos(self._value), -1.0 / math.sqrt(1.0 - self._value**2))

    def arctan(self) -> AutoDiffXd:
        """Return the angle [rad] with this tangent."""
        return self._after(math.atan(self._value), 1.0 / (1.0 + self._value**2))

    def arctan2(self, x: Any) -> Any:
        """Return the angle [rad] of the point (x, this)."""

        def angle(x: AutoDiffXd) -> AutoDiffXd:
            squared = self._value**2 + x._value**2
            slopes = x._value / squared, -self._value / squared
            return self._with(x, math.atan2(self._value, x._value), *slopes)

        return _binary(x, angle)

    # Other names in pydrake.
    abs, pow, ceil, floor = __abs__, __pow__, __ceil__, __floor__
    acos, asin, atan, atan2 = arccos, arcsin, arctan, arctan2


def _power(x: float, exponent: float) -> float:
    """Return x to a power, as for floats; integer powers of negative numbers are real."""
    return float(np.float64(x) ** np.float64(exponent))


def is_autodiff(number: Any) -> bool:
    """Return whether a number is an AutoDiffXd of this package or of pydrake."""
    return type(number).__name__ == 'AutoDiffXd'


def _converted(number: Any) -> AutoDiffXd | None:
    """Return a number as an AutoDiffXd of this package, None for other objects."""
    if isinstance(number, AutoDiffXd):
        return number
    if isinstance(number, (int, float, np.integer, np.floating)):
        return AutoDiffXd(float(number))
    return None


def _number(number: Any) -> AutoDiffXd:
    """Return a number as an AutoDiffXd of this package; raises TypeError for other objects."""
    converted = _converted(number)
    if converted is None:
        raise TypeError(f'AutoDiffXd: {number!r} is no number')
    return converted


def _binary(other: Any, function: Callable[[AutoDiffXd], AutoDiffXd]) -> Any:
    number = _converted(other)
    return NotImplemented if number is None else function(number)


def _compared(other: Any, function: Callable[[float], bool]) -> Any:
    number = _converted(other)
    return NotImplemented if number is None else function(number._value)
