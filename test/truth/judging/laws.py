"""What an answer about a pair must hold: by itself, and by the surfaces.

Each law stands here once, as how far an answer is off it, for one answer or for arrays of them.
What may be is for those who judge: ours answers THE promise (``breaks_promise``) and its own
certificate, others what is ``allowed_to_others`` of the second opinion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.surfaces import width
from drake_geom_ros.geometry import ACCURACY_GAPS
from drake_geom_ros.math.array_types import Floats

WIDE = 'wider than promised'


def off_unit(nhat_BA_W: Floats) -> Any:
    """Return by how much normals (..., 3) are off unit length [-]."""
    return np.abs(np.hypot.reduce(nhat_BA_W, axis=-1) - 1.0)


def off_span(distance: Any, nhat_BA_W: Floats, p_WCa: Floats, p_WCb: Floats) -> Any:
    """Return how far [m] the points are from lying a distance apart along the normal."""
    along = np.asarray(distance)[..., None] * nhat_BA_W
    return np.hypot.reduce(p_WCa - p_WCb - along, axis=-1)


def lacking(pair: Pair, distance: float, nhat_BA_W: Floats) -> float:
    """Return by how much [m] the supporting planes across a normal are nearer than the distance.

    A normal attains the distance of convex bodies: no direction has a wider gap, and it has this.
    """
    return distance - width(pair.a, pair.b, nhat_BA_W)


def turned(nhat_BA_W: Floats, expected: Floats) -> float:
    """Return how far [-] a normal is from the nearest of those expected (k, 3)."""
    return float(np.linalg.norm(expected - nhat_BA_W, axis=1).min())


def is_wide_to_a_point(bound: float, body: Body) -> bool:
    """Return whether the bound of a point's distance [m] is wider than of a closed form.

    Every shape's distance to a point is one, and no level lets it be less sharp than ``exact``.
    """
    return bound > ACCURACY_GAPS['exact'] * min(1.0, body.radius or 1.0)
