"""What answers about two bodies promise, checked by the laws and against other answers.

No truth is needed: for every unit n the gap between the supporting planes along n is at most the
signed distance, so any n may prove a certificate false; and the other order, another frame,
another scale and the other query must agree within their bounds.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.evidence import laws
from drake_geom_ros.evidence.asking import PairScene
from drake_geom_ros.evidence.bodies import Body, Floats, Pair
from drake_geom_ros.evidence.random_bodies import random_directions
from drake_geom_ros.evidence.surfaces import width
from drake_geom_ros.evidence.tolerances import AS_TOUCHING, EPS, VERY_WIDE
from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.math import RotationMatrix

DIRECTIONS = 64
R_WM = np.array(
    RotationMatrix.MakeZRotation(1.0).matrix() @ RotationMatrix.MakeXRotation(2.0).matrix()
)
SCALES = (2.0**-20, 2.0**13)


def broken(a: Body, b: Body) -> list[str]:
    """Return the promises that answers about two bodies without dents break, in some words."""
    pair = Pair(a, b)
    try:
        first = PairScene(a, b).distance()
        found = laws.of_answer(pair, first)
        checks = (_of_directions, _of_queries, _of_others)
        return found + [wrong for check in checks for wrong in check(pair, first)]
    except Exception as error:
        return [f'raises {type(error).__name__}']


def _of_directions(pair: Pair, row: SignedDistanceResults) -> list[str]:
    """Return whether a direction has a wider gap than was certified, or much is left open."""
    most, found = float(row.distance[0] + row.error_bound[0]) + laws.rounding(pair), []
    if max(width(pair.a, pair.b, n) for n in _directions(pair, row.nhat_BA_W[0])) > most:
        found.append('certificate false: another direction has a wider gap')
    if row.error_bound[0] > VERY_WIDE * pair.extent + laws.rounding(pair):
        found.append('very wide bound')
    return found


def _directions(pair: Pair, nhat: Floats) -> Floats:
    """Return unit vectors that may have wide gaps: the normal, axes, centres, and any."""
    axes = [*pair.a.R.T, *pair.b.R.T]
    crosses = [np.cross(u, v) for u in axes[:3] for v in axes[3:]]
    vectors = [nhat, *axes, *crosses, (pair.b.p - pair.a.p) / pair.extent]
    units = [v / math.hypot(*v) for v in vectors if math.hypot(*v) > EPS]
    both = np.vstack([units, random_directions(np.random.default_rng(0), DIRECTIONS)])
    return np.vstack([both, -both])


def _of_queries(pair: Pair, first: SignedDistanceResults) -> list[str]:
    """Return where the queries disagree."""
    scene, found = PairScene(pair.a, pair.b), []
    distance, bound = float(first.distance[0]), float(first.error_bound[0])
    penetration, rounding = scene.penetration(), laws.rounding(pair)
    if scene.collides() != bool(len(penetration)):
        found.append('HasCollisions disagrees')
    if len(penetration) and abs(penetration.depth[0] + distance) > 2.0 * bound + rounding:
        found.append('penetration disagrees with the signed distance')
    sure = bound + AS_TOUCHING * pair.extent
    if (distance < -sure) != bool(len(penetration)) and abs(distance) > sure:
        found.append('penetration and signed distance disagree on contact')
    if len(penetration) and not scene.is_candidate():
        found.append('a contact is no candidate')
    return found


def _of_others(pair: Pair, first: SignedDistanceResults) -> list[str]:
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
        bounds = s * first.error_bound[0] + row.error_bound[0] + laws.rounding(other)
        if not abs(row.distance[0] - s * first.distance[0]) <= bounds:
            found.append(f'{name} disagrees')
    return found
