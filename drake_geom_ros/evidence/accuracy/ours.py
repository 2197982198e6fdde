"""Our answers to pairs, each from a scene that was never asked before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.evidence import laws
from drake_geom_ros.evidence.asking import BodyScene
from drake_geom_ros.evidence.bodies import Pair
from drake_geom_ros.evidence.peers import PENETRATION, SIGNED_DISTANCE
from drake_geom_ros.geometry import ACCURACY_LEVELS as LEVELS
from drake_geom_ros.geometry import QueryObject

POINTS = 'points'
QUERIES = (SIGNED_DISTANCE, PENETRATION, POINTS)


class Answer(NamedTuple):
    """A signed distance and its certificate [m], and whether that is wider than promised."""

    distance: float
    error_bound: float
    is_wide: bool


def answers(pair: Pair, query: str, levels: Sequence[str] = LEVELS) -> list[Answer | None]:
    """Return our answer at each level; None where a penetration is not reported."""
    scene = BodyScene((pair.b,) if query == POINTS else (pair.a, pair.b))
    return [_answer(scene.asked(), pair, query, level) for level in levels]


def _answer(asked: QueryObject, pair: Pair, query: str, level: str) -> Answer | None:
    if query == POINTS:
        found = asked.ComputeSignedDistanceToPoint(pair.a.p, accuracy=level)
        distance, bound = float(found.distance[0]), float(found.error_bound[0])
        return Answer(distance, bound, laws.is_wide_to_a_point(bound, pair.b))
    found, distances = asked_for(asked, query, level)
    return rows(found, distances)[0] if len(found) else None


def asked_for(asked: QueryObject, query: str, level: str, most: float = np.inf) -> tuple[Any, Any]:
    """Return what a query of pairs finds, and the signed distances (k,) [m]."""
    if query == PENETRATION:
        overlaps = asked.ComputePointPairPenetration(accuracy=level)
        return overlaps, -overlaps.depth
    pairs = asked.ComputeSignedDistancePairwiseClosestPoints(most, accuracy=level)
    return pairs, pairs.distance


def rows(found: Any, distances: Any) -> list[Answer]:
    """Return the answers of a query of pairs."""
    columns = distances, found.error_bound, found.breaks_promise()
    return [Answer(*row) for row in zip(*(x.tolist() for x in columns), strict=True)]
