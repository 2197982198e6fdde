"""What an answer about a pair promises, checked against the surfaces and against other answers.

No truth is needed: for every unit n the gap between the supporting planes along n is at most the
signed distance, so any n may prove a certificate false; and the other order, another frame,
another scale and the other query must agree within their bounds.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.evidence.asking import PairScene
from drake_geom_ros.evidence.hard_cases.cases import Body, Case, Floats
from drake_geom_ros.evidence.surfaces import height, width
from drake_geom_ros.evidence.tolerances import (
    AS_TOUCHING,
    COARSE_NORMALS,
    EPS,
    NORMALS,
    POSITIONS,
    UNIT,
    VERY_WIDE,
    WITNESSES,
)
from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.math import RotationMatrix

COARSE = 'coarse normal'
DIRECTIONS = 64
R_WM = np.array(
    RotationMatrix.MakeZRotation(1.0).matrix() @ RotationMatrix.MakeXRotation(2.0).matrix()
)
SCALES = (2.0**-20, 2.0**13)


def broken(a: Body, b: Body) -> list[str]:
    """Return the promises that answers about two bodies break, each in some words."""
    pair = Case('', '', '', '', a, b, 0.0, 0.0)
    try:
        first = PairScene(a, b).distance()
        return [*_of_row(pair, first), *_of_queries(pair, first), *_of_others(pair, first)]
    except Exception as error:
        return [f'raises {type(error).__name__}']


def rounding(pair: Case) -> float:
    """Return what positions of a pair may be off by [m]."""
    away = max(np.abs(pair.a.p).max(), np.abs(pair.b.p).max())
    return float(POSITIONS * (pair.extent + away))


def _of_row(pair: Case, row: SignedDistanceResults) -> list[str]:
    """Return what is wrong with an answer by itself."""
    distance, bound = float(row.distance[0]), float(row.error_bound[0])
    nhat, p_WCa, p_WCb = row.nhat_BA_W[0], row.p_WCa[0], row.p_WCb[0]
    if not (np.isfinite([distance, bound]).all() and np.isfinite([nhat, p_WCa, p_WCb]).all()):
        return ['not finite']
    noise, found = rounding(pair), []
    if abs(math.hypot(*nhat) - 1.0) > UNIT:
        found.append('normal not unit')
    if math.hypot(*(p_WCa - p_WCb - distance * nhat)) > noise:
        found.append('witness points apart')
    off = max(abs(height(pair.a, p_WCa)), abs(height(pair.b, p_WCb)))
    if off > noise + bound + WITNESSES * pair.extent:
        found.append('witness points off their surfaces')
    lacking = distance - width(pair.a, pair.b, nhat) - noise - bound
    if lacking > NORMALS * pair.extent:
        coarse = lacking <= COARSE_NORMALS * pair.extent
        found.append(COARSE if coarse else 'normal does not attain the distance')
    if max(width(pair.a, pair.b, n) for n in _directions(pair, nhat)) > distance + bound + noise:
        found.append('certificate false: another direction has a wider gap')
    if bound > VERY_WIDE * pair.extent + noise:
        found.append('very wide bound')
    return found


def _directions(pair: Case, nhat: Floats) -> Floats:
    """Return unit vectors that may have wide gaps: the normal, axes, centres, and any."""
    rng = np.random.default_rng(0)
    axes = [*pair.a.R.T, *pair.b.R.T]
    crosses = [np.cross(u, v) for u in axes[:3] for v in axes[3:]]
    vectors = [nhat, *axes, *crosses, *rng.normal(size=(DIRECTIONS, 3))]
    vectors += [(pair.b.p - pair.a.p) / pair.extent]
    units = np.array([v / math.hypot(*v) for v in vectors if math.hypot(*v) > EPS])
    return np.vstack([units, -units])


def _of_queries(pair: Case, first: SignedDistanceResults) -> list[str]:
    """Return where the queries disagree."""
    scene, found = PairScene(pair.a, pair.b), []
    distance, bound = float(first.distance[0]), float(first.error_bound[0])
    penetration = scene.penetration()
    if scene.collides() != bool(len(penetration)):
        found.append('HasCollisions disagrees')
    if len(penetration) and abs(penetration.depth[0] + distance) > 2.0 * bound + rounding(pair):
        found.append('penetration disagrees with the signed distance')
    sure = bound + AS_TOUCHING * pair.extent
    if (distance < -sure) != bool(len(penetration)) and abs(distance) > sure:
        found.append('penetration and signed distance disagree on contact')
    if len(penetration) and not scene.is_candidate():
        found.append('a contact is no candidate')
    return found


def _of_others(pair: Case, first: SignedDistanceResults) -> list[str]:
    """Return where the other order, another frame and another scale disagree."""
    p = pair.extent * np.array([3.0, -2.0, 1.0])
    others = {
        'the other order': (pair.swapped(), 1.0),
        'another frame': (pair.moved(R_WM, p), 1.0),
        **{f'scale {s:.0e}': (pair.scaled(s), s) for s in SCALES},
    }
    found = []
    for name, (other, s) in others.items():
        row = PairScene(other.a, other.b).distance()
        bounds = s * first.error_bound[0] + row.error_bound[0] + rounding(other)
        if not abs(row.distance[0] - s * first.distance[0]) <= bounds:
            found.append(f'{name} disagrees')
    return found
