"""Moments between two others, rounded to the side that keeps what is said of them true."""

from __future__ import annotations

import math

_ROUNDINGS = 3  # of a difference, a product and a sum


def time_between(begin: float, end: float, part: float, towards: float | None = None) -> float:
    """Return begin + part (end - begin), 0 <= part <= 1; ends as they are.

    Rounded down or up where ``towards`` is -inf or inf.

    >>> time_between(1.0, 3.0, 0.5)
    2.0
    >>> time_between(1.0, 3.0, 0.5, math.inf) > 2.0
    True
    """
    if part in (0.0, 1.0):  # no number in between was rounded
        return end if part else begin
    time = begin + part * (end - begin)
    if towards is None:
        return time
    for _ in range(_ROUNDINGS):
        time = math.nextafter(time, towards)
    return min(max(time, begin), end)
