"""Paddings of a robot from a parameter: a list of texts, because ROS has no mappings."""

from __future__ import annotations

import math
from collections.abc import Iterable

from drake_geom_ros.geometry import ArgumentError


def paddings_of(texts: Iterable[str], called: str = 'paddings') -> tuple[tuple[str, float], ...]:
    """Return patterns of links or geometries with their paddings [m], of ``PATTERN=METRES``.

    ``called`` is the name of the texts in errors.

    >>> paddings_of(['*=0.01', 'panda_hand=0.02'])
    (('*', 0.01), ('panda_hand', 0.02))

    Raises ArgumentError for a text that is none, and a padding that is negative or not finite.
    """
    paddings = []
    for text in texts:
        pattern, _, number = text.rpartition('=')
        try:
            padding = float(number)
        except ValueError:
            padding = math.nan
        if not pattern or not 0.0 <= padding < math.inf:
            raise ArgumentError(
                f'{called} holds {text!r}; each must be PATTERN=METRES, of a link or '
                "link/geometry, with * and ?, and a number >= 0, such as 'panda_hand=0.02'"
            )
        paddings.append((pattern, padding))
    return tuple(paddings)
