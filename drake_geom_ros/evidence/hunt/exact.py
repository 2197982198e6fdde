"""The truth in 40 digits, for the few pairs that planes leave open."""

from __future__ import annotations

import math

from drake_geom_ros.evidence.bodies import Pair
from drake_geom_ros.evidence.hunt.judge import Judged
from drake_geom_ros.evidence.tolerances import ROUNDING, SEARCH
from drake_geom_ros.evidence.truth import convex


def distance(pair: Pair, n: object = None) -> float:
    """Return the signed distance [m] of a pair, or the widest gap near a direction n out of A.

    Lengths are brought to about 1 m by a power of two: the truth squares them.
    """
    s = 2.0 ** -round(math.log2(pair.extent)) if pair.extent else 1.0
    scaled = pair.scaled(s)
    return convex.signed_distance(scaled.a, scaled.b, near=n)[0] / s


def error(judged: Judged, k: int) -> float:
    """Return by how much of its bound a distance exceeds the truth."""
    pair, row = judged.pairs[k], judged.replies.levels['exact']
    allowed = row.error_bound[k] + ROUNDING * judged.extent[k]
    # A sharper plane beside the best one may be enough.
    near = (row.distance[k] - distance(pair, -judged.nhats[k])) / allowed
    if near <= 1.0:
        return float(near)
    return float((row.distance[k] - distance(pair)) / (allowed + SEARCH * judged.extent[k]))
