"""Functions of one or two numbers, floats or AutoDiffXd, with the names of ``pydrake.math``.

They call ``math`` for floats, and the number's own method for one with derivatives.
"""

from __future__ import annotations

import builtins
import math
from collections.abc import Callable
from typing import Any


def _function(name: str, of_float: Callable[[float], float]) -> Callable[[Any], Any]:
    def function(x: Any) -> Any:
        return getattr(x, name)() if _is_autodiff(x) else float(of_float(x))

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f'Return ``{name}`` of a float or an AutoDiffXd.'
    return function


def _is_autodiff(x: Any) -> bool:
    return type(x).__name__ == 'AutoDiffXd'


abs, sqrt = _function('abs', math.fabs), _function('sqrt', math.sqrt)
exp, log = _function('exp', math.exp), _function('log', math.log)
sin, cos, tan = _function('sin', math.sin), _function('cos', math.cos), _function('tan', math.tan)
arcsin, arccos = _function('arcsin', math.asin), _function('arccos', math.acos)
arctan = _function('arctan', math.atan)
asin, acos, atan = arcsin, arccos, arctan
sinh, cosh = _function('sinh', math.sinh), _function('cosh', math.cosh)
tanh = _function('tanh', math.tanh)
ceil, floor = _function('ceil', math.ceil), _function('floor', math.floor)


def max(x: Any, y: Any) -> Any:
    """Return the larger of two numbers; of equal ones the first with derivatives."""
    return y.max(x) if _is_autodiff(y) and not _is_autodiff(x) else _chosen('max', x, y)


def min(x: Any, y: Any) -> Any:
    """Return the smaller of two numbers; of equal ones the first with derivatives."""
    return y.min(x) if _is_autodiff(y) and not _is_autodiff(x) else _chosen('min', x, y)


def _chosen(name: str, x: Any, y: Any) -> Any:
    return getattr(x, name)(y) if _is_autodiff(x) else float(getattr(builtins, name)(x, y))


def pow(x: Any, y: Any) -> Any:
    """Return x to the power y."""
    return x**y


def arctan2(y: Any, x: Any) -> Any:
    """Return the angle [rad] of the point (x, y)."""
    if _is_autodiff(y):
        return y.arctan2(x)
    return type(x)(y).arctan2(x) if _is_autodiff(x) else math.atan2(y, x)


atan2 = arctan2


def isnan(x: Any) -> bool:
    """Return whether a number's value is NaN."""
    return math.isnan(x.value() if _is_autodiff(x) else x)
