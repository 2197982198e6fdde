"""Whose answer is wrong, where FCL's differs from ours by more than both may be off.

FCL has faults that are known (docs/hard_cases.md: box and box on a lattice, deep overlaps, long
and thin bodies), and would shout in most scenes. So a difference is a disagreement only where our
own answer does not prove FCL wrong, by what anybody can check without either solver:

* FCL says nearer: the supporting planes across our normal leave a gap as wide as we say, and no
  two convex bodies are nearer than such planes.
* FCL says farther, and bodies are apart: our witness points lie on the surfaces, as far apart as
  we say.
* FCL says less deep: the planes across its normal, and across ours, are no such short way out.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.cross_check.answers import PairAnswer
from drake_geom_ros.cross_check.bodies import Floats, Pair
from drake_geom_ros.cross_check.question import (
    AGREED,
    DISAGREED,
    REFUTED,
    SILENT,
    PairQuestion,
    Verdict,
)
from drake_geom_ros.cross_check.surfaces import height, off_surfaces, width
from drake_geom_ros.cross_check.tolerances import JUDGED_PART, JUDGED_ROUNDING, NO_DIRECTION
from drake_geom_ros.replay import Opinion

_BEYOND = 1e300  # [m]; FCL leaves a distance that it never computed at the largest number


def allowed_to_others(pair: Pair) -> float:
    """Return what the distance of another library may be off by [m].

    That is a thousandth of the smaller body's radius, ten times what the tolerances of peers leave
    at 1 m, and rounding.
    """
    return JUDGED_PART * pair.smaller + JUDGED_ROUNDING * (pair.extent + pair.away)


def judged(pair: Pair, ours: PairQuestion, theirs: PairAnswer | None, library: str) -> Verdict:
    """Return the verdict on our answer, given FCL's; None: it reports no contact."""
    tolerance = allowed_to_others(pair)
    low, high = ours.distance - ours.error_bound, ours.distance + ours.error_bound
    opinion = _opinion(theirs, tolerance, library)
    if pair.has_map and theirs is not None and theirs.distance <= 0.0:
        # FCL tells no depth of an octree, and which of our digits would prove it wrong is open.
        theirs = theirs._replace(distance=min(low, 0.0))
    if theirs is None:
        if high >= -tolerance:
            return Verdict(AGREED, opinion)
        # A point of the surface of one that is in the other: there is a contact.
        depth = min(height(pair.b, ours.p_WCa), height(pair.a, ours.p_WCb))
        refuted = depth <= 0.0 and _may_be_as_deep(pair, ours, None, high + tolerance)
    elif not abs(theirs.distance) < _BEYOND or (pair.has_solid and _is_hollow(high, theirs)):
        return Verdict(SILENT, opinion)
    elif low - tolerance <= _signed(pair, low, theirs) <= high + tolerance:
        return Verdict(AGREED, opinion)
    elif theirs.distance < low:
        refuted = not pair.has_map and width(pair.a, pair.b, ours.nhat_BA_W) >= low - tolerance
    else:
        refuted = not pair.has_map and _is_too_far(pair, ours, theirs, high + tolerance, tolerance)
    said = 'no contact' if theirs is None else f'{theirs.distance:.9g} m'
    bound = f'{ours.distance:.9g} m within {ours.error_bound:.2g} m'
    text = f'{bound} here, {said} within {tolerance:.2g} m by {library}'
    return Verdict(REFUTED if refuted else DISAGREED, opinion, text)


def _opinion(theirs: PairAnswer | None, tolerance: float, library: str) -> Opinion:
    if theirs is None:
        return Opinion(library, None, tolerance)
    numbers = (
        None if x is None else tuple(map(float, x))
        for x in (theirs.nhat_BA_W, theirs.p_WCa, theirs.p_WCb)
    )
    return Opinion(library, float(theirs.distance), tolerance, *numbers)


def _is_hollow(high: float, theirs: PairAnswer) -> bool:
    """Return whether FCL, to which a solid is its surface alone, can say nothing of an overlap."""
    return high < 0.0 < theirs.distance


def _signed(pair: Pair, low: float, theirs: PairAnswer) -> float:
    """Return FCL's distance; of a surface that is crossed it tells no depth, so take ours."""
    if pair.has_solid and theirs.distance <= 0.0:
        return min(low, 0.0)
    return theirs.distance


def _is_too_far(
    pair: Pair, ours: PairQuestion, theirs: PairAnswer, reach: float, tolerance: float
) -> bool:
    """Return whether bodies are nearer than FCL says, or nothing shows a shorter way out."""
    if ours.distance > 0.0:
        apart = math.dist(ours.p_WCa, ours.p_WCb)
        off = off_surfaces(pair, ours.p_WCa, ours.p_WCb)
        return apart <= reach and off <= ours.error_bound + tolerance
    return _may_be_as_deep(pair, ours, theirs, reach)


def _may_be_as_deep(
    pair: Pair, ours: PairQuestion, theirs: PairAnswer | None, reach: float
) -> bool:
    """Return whether no known direction leads out of an overlap sooner: the planes across it."""
    known = [ours.nhat_BA_W, None if theirs is None else _normal(theirs)]
    return all(width(pair.a, pair.b, n) <= reach for n in known if n is not None)


def _normal(theirs: PairAnswer) -> Floats | None:
    """Return FCL's nhat_BA_W, or that of its witness points; None without a direction."""
    normal = theirs.nhat_BA_W
    if normal is None and theirs.p_WCa is not None and theirs.p_WCb is not None:
        normal = math.copysign(1.0, theirs.distance) * (theirs.p_WCa - theirs.p_WCb)
    if normal is None or not np.isfinite(normal).all():
        return None
    length = math.hypot(*normal)
    return normal / length if length > NO_DIRECTION else None
