"""The truth in 40 digits, for the few pairs that planes leave open."""

from __future__ import annotations

import math

from bench.hard_cases.cases import Case
from bench.hunt.laws import PLANE_ROUNDING, Judged
from bench.hunt.planes import support_of
from drake_geom_ros.accuracy import truth

SEARCH = 2e-12  # of the extent: what the search over directions may be off by


def distance(case: Case, n: object = None) -> float:
    """Return the signed distance [m] of a pair, or the widest gap near a direction n out of A.

    Lengths are brought to about 1 m by a power of two: the truth squares them.
    """
    s = 2.0 ** -round(math.log2(case.extent)) if case.extent else 1.0
    scaled = case.scaled(s)
    a, b = scaled.a, scaled.b
    pair = support_of(a.kind, a.size), (a.R, a.p), support_of(b.kind, b.size), (b.R, b.p)
    found = truth.signed_distance(*pair) if n is None else truth.near_direction(*pair, n)
    return found[0] / s


def error(judged: Judged, k: int) -> float:
    """Return by how much of its bound a distance exceeds the truth."""
    case, row = judged.cases[k], judged.replies.levels['exact']
    allowed = row.error_bound[k] + PLANE_ROUNDING * judged.extent[k]
    # A sharper plane beside the best one may be enough.
    near = (row.distance[k] - distance(case, -judged.nhats[k])) / allowed
    if near <= 1.0:
        return float(near)
    return float((row.distance[k] - distance(case)) / (allowed + SEARCH * judged.extent[k]))
