"""Interpolation of times with directed rounding."""

from __future__ import annotations

import math
from fractions import Fraction


def time_between(begin: float, end: float, part: float, towards: float | None = None) -> float:
    """Return begin + part (end - begin), 0 <= part <= 1.

    The result is rounded to nearest, or down or up if ``towards`` is -inf or inf.

    >>> time_between(1.0, 3.0, 0.5)
    2.0
    >>> time_between(0.0, 0.1, 0.1, math.inf) > time_between(0.0, 0.1, 0.1, -math.inf)
    True
    """
    exact = Fraction(begin) + Fraction(part) * (Fraction(end) - Fraction(begin))
    time = float(exact)
    is_beyond = time > exact if towards == -math.inf else time < exact
    return time if towards is None or not is_beyond else math.nextafter(time, towards)
