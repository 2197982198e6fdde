"""What breaks an answer of ours about a pair, in words: by itself, or by the truth of a case."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.surfaces import off_surfaces
from drake_geom_ros.geometry import METHODS, SignedDistanceResults
from truth.hard_cases.cases import Case
from truth.judging.asking import PairScene
from truth.judging.laws import WIDE, lacking, off_span, off_unit, turned
from truth.tolerances import COARSE_NORMALS, EPS, POSITIONS, UNIT

FALSE, COARSE = 'error_bound below the error', 'coarse normal'
ITERATIVE = METHODS['iterative']
# Of the extent: what an iteration, which stops by the distance, leaves in points and normals.
WITNESSES, NORMALS = 1e-10, 1e-8


def rounding(pair: Pair) -> float:
    """Return what positions may be off by [m]: digits, and rotations that are not quite some."""
    skew = max(pair.a.skew, pair.b.skew)
    return POSITIONS * (pair.extent + pair.away) + skew * pair.extent


def unsure(pair: Pair, row: SignedDistanceResults) -> float:
    """Return what an answer may be off by [m]: its certificate, and that of the truth."""
    return float(row.error_bound[0]) + (pair.tolerance if isinstance(pair, Case) else 0.0)


def of_bound(case: Case, row: SignedDistanceResults) -> list[str]:
    """Return what is wrong with an answer's bound: it must hold, and be as narrow as promised."""
    right = abs(row.distance[0] - case.distance) <= unsure(case, row)
    return [FALSE] * (not right) + [WIDE] * bool(row.breaks_promise()[0])


def of_answer(pair: Pair, row: SignedDistanceResults) -> list[str]:
    """Return what is wrong with an answer, by the truth of a case, or without any by itself."""
    nhat, p_WCa, p_WCb = row.nhat_BA_W[0], row.p_WCa[0], row.p_WCb[0]
    if not np.isfinite([row.distance[0], row.error_bound[0], *nhat, *p_WCa, *p_WCb]).all():
        return ['not finite']
    noise, iterated = rounding(pair), bool(row.method[0] == ITERATIVE)
    points = noise + unsure(pair, row) + iterated * WITNESSES * pair.extent
    laws = {
        'normal not unit': off_unit(nhat) <= UNIT,
        'witness points apart': off_span(row.distance[0], nhat, p_WCa, p_WCb) <= noise,
        'witness points off their surfaces': off_surfaces(pair, p_WCa, p_WCb) <= points,
    }
    found = [law for law, holds in laws.items() if not holds]
    if not pair.has_solid:  # these are not what their supporting planes say
        found += _of_normal(pair, row)
    return found + (_of_case(pair, row) if isinstance(pair, Case) else [])


def _of_normal(pair: Pair, row: SignedDistanceResults) -> list[str]:
    """Return whether the normal attains the distance; of a case, as well as it can be known.

    How well that is depends on how far the cores, without the radii, are apart.
    """
    truth, known, off = float(row.distance[0]), math.inf, unsure(pair, row)
    if isinstance(pair, Case):
        truth = pair.distance
        core = abs(truth + radius_of_core(pair.a) + radius_of_core(pair.b))
        spread = 1.0 + pair.extent / max(core, float(row.error_bound[0]), math.ulp(0.0))
        known = off * spread + NORMALS * pair.extent * bool(row.method[0] == ITERATIVE)
    missing = lacking(pair, truth, row.nhat_BA_W[0]) - rounding(pair)
    if missing <= min(known, off + NORMALS * pair.extent):
        return []
    coarse = missing <= min(known, off + COARSE_NORMALS * pair.extent)
    return [COARSE if coarse else 'normal does not attain the distance']


def _of_case(case: Case, row: SignedDistanceResults) -> list[str]:
    """Return where an answer is not what is known of a case."""
    found, off = of_bound(case, row), unsure(case, row) + rounding(case)
    nhat, points = row.nhat_BA_W[0], np.array([row.p_WCa[0], row.p_WCb[0]])
    if case.normals is not None:
        core = abs(case.distance + radius_of_core(case.a) + radius_of_core(case.b))
        known = max(core, case.tolerance, EPS * case.extent)
        if turned(nhat, case.normals) > NORMALS + math.sqrt(8.0 * off / known):
            found.append('another normal than expected')
    if case.witnesses is not None:
        # A point on a surface curved as the whole pair is known to the root of the error.
        allowed = rounding(case) + math.sqrt(8.0 * off * case.extent)
        if np.hypot.reduce(points - case.witnesses, axis=1).max() > allowed:
            found.append('other witness points than expected')
    return found


def of_contact(case: Case, row: SignedDistanceResults, scene: PairScene) -> list[str]:
    """Return whether A, moved along the normal by its distance, touches B and overlaps nothing.

    It is what tells of a normal of solids.
    """
    moved = case.a.at(case.a.p - row.distance[0] * row.nhat_BA_W[0])
    scene.place(moved, case.b)
    touching = scene.distance()
    scene.place(case.a, case.b)
    allowed = unsure(case, row) + unsure(case, touching) + rounding(case)
    return (
        [] if abs(touching.distance[0]) <= allowed else ['no contact when moved by its distance']
    )


def radius_of_core(body: Body) -> float:
    """Return the radius [m] of the ball that a body is its core grown by, as far as it matters."""
    return float(body.size[0]) if body.kind in ('Sphere', 'Capsule') else 0.0
