"""Verdicts on answers that differ from FCL's by more than both error bounds.

FCL has known faults (docs/hard_cases.md: box and box on a lattice, deep overlaps, long and thin
bodies), which would raise false alarms in most scenes. Therefore a difference counts as a
disagreement only if this package's answer does not prove FCL wrong by facts that need neither
solver:

* FCL's distance is smaller: the supporting planes across this package's normal are a gap of its
  distance apart, and no two convex bodies are nearer than such planes.
* FCL's distance is greater, and the bodies are apart: this package's witness points lie on the
  surfaces, at its distance.
* FCL's depth is smaller: the planes across either normal allow no separating translation as short.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.cross_check.answers import PairAnswer
from drake_geom_ros.cross_check.bodies import Pair
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
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.replay import Opinion

_BEYOND = 1e300  # [m]; FCL leaves distances that it did not compute at the largest number


def allowed_to_others(pair: Pair) -> float:
    """Return the tolerance [m] for another library's distance.

    It is a thousandth of the smaller body's radius, ten times the error that tolerances of peers
    cause at 1 m, plus rounding.
    """
    return JUDGED_PART * pair.smaller + JUDGED_ROUNDING * (pair.extent + pair.away)


def judged(pair: Pair, question: PairQuestion, answer: PairAnswer | None, library: str) -> Verdict:
    """Return the verdict on the distance in a question, by FCL's answer; None: no contact."""
    tolerance = allowed_to_others(pair)
    low, high = question.distance - question.error_bound, question.distance + question.error_bound
    opinion = _opinion(answer, tolerance, library)
    if pair.has_map and answer is not None and answer.distance <= 0.0:
        # FCL has no depth of an octree, and no number here could prove it wrong.
        answer = answer._replace(distance=min(low, 0.0))
    if answer is None:
        if high >= -tolerance:
            return Verdict(AGREED, opinion)
        # A surface point of one body inside the other proves a contact.
        depth = min(height(pair.b, question.p_WCa), height(pair.a, question.p_WCb))
        refuted = depth <= 0.0 and _may_be_as_deep(pair, question, None, high + tolerance)
    elif not abs(answer.distance) < _BEYOND or (pair.has_solid and _is_hollow(high, answer)):
        return Verdict(SILENT, opinion)
    elif low - tolerance <= _signed(pair, low, answer) <= high + tolerance:
        return Verdict(AGREED, opinion)
    elif answer.distance < low:
        refuted = not pair.has_map and width(pair.a, pair.b, question.nhat_BA_W) >= low - tolerance
    else:
        refuted = not pair.has_map and _is_too_far(
            pair, question, answer, high + tolerance, tolerance
        )
    peer = 'no contact' if answer is None else f'{answer.distance:.9g} m'
    bound = f'{question.distance:.9g} m within {question.error_bound:.2g} m'
    text = f'{bound} here, {peer} within {tolerance:.2g} m by {library}'
    return Verdict(REFUTED if refuted else DISAGREED, opinion, text)


def _opinion(answer: PairAnswer | None, tolerance: float, library: str) -> Opinion:
    if answer is None:
        return Opinion(library, None, tolerance)
    numbers = (
        None if x is None else tuple(map(float, x))
        for x in (answer.nhat_BA_W, answer.p_WCa, answer.p_WCb)
    )
    return Opinion(library, float(answer.distance), tolerance, *numbers)


def _is_hollow(high: float, answer: PairAnswer) -> bool:
    """Return whether FCL misses an overlap because a solid is only a surface for it."""
    return high < 0.0 < answer.distance


def _signed(pair: Pair, low: float, answer: PairAnswer) -> float:
    """Return FCL's distance, or ``low`` for crossed surfaces, of which FCL has no depth."""
    if pair.has_solid and answer.distance <= 0.0:
        return min(low, 0.0)
    return answer.distance


def _is_too_far(
    pair: Pair, question: PairQuestion, answer: PairAnswer, reach: float, tolerance: float
) -> bool:
    """Return whether bodies are nearer than FCL's distance, or deeper than FCL's depth."""
    if question.distance > 0.0:
        apart = math.dist(question.p_WCa, question.p_WCb)
        off = off_surfaces(pair, question.p_WCa, question.p_WCb)
        return apart <= reach and off <= question.error_bound + tolerance
    return _may_be_as_deep(pair, question, answer, reach)


def _may_be_as_deep(
    pair: Pair, question: PairQuestion, answer: PairAnswer | None, reach: float
) -> bool:
    """Return whether neither normal is a shorter separating direction of an overlap."""
    normals = [question.nhat_BA_W, None if answer is None else _normal(answer)]
    return all(width(pair.a, pair.b, n) <= reach for n in normals if n is not None)


def _normal(answer: PairAnswer) -> Floats | None:
    """Return FCL's nhat_BA_W, or the direction of its witness points; None without one."""
    normal = answer.nhat_BA_W
    if normal is None and answer.p_WCa is not None and answer.p_WCb is not None:
        normal = math.copysign(1.0, answer.distance) * (answer.p_WCa - answer.p_WCb)
    if normal is None or not np.isfinite(normal).all():
        return None
    length = math.hypot(*normal)
    return normal / length if length > NO_DIRECTION else None
