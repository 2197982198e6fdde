"""Distances and closing speeds of pairs at a step, each looked for once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from bench.ros.rules.cell import Bodies
from bench.ros.rules.records import Twist
from drake_geom_ros.common.eigen_geometry import AngleAxis
from drake_geom_ros.math import RigidTransform, RotationMatrix

_MOMENT = 1e-4  # [s] in which a distance changes by far more than its bound
_SLOPE = 1e-3  # [m/s] by which a quotient of differences may be off


class Gap(NamedTuple):
    """How far apart a pair is, and between which speeds [m/s] it closes."""

    distance: float  # [m]
    bound: float  # [m]
    slowest: float
    fastest: float


class Distances:
    """The pairs of one moment."""

    def __init__(
        self, bodies: Bodies, places: dict[str, RigidTransform], twists: Mapping[str, Twist]
    ) -> None:
        self._bodies, self._now = bodies, places
        self._before = _moved(places, twists, -_MOMENT)
        self._after = _moved(places, twists, _MOMENT)
        self._found: dict[frozenset[str], tuple[float, float]] = {}
        self._gaps: dict[frozenset[str], Gap] = {}
        bodies.pose(places)

    def at(self, pair: frozenset[str]) -> tuple[float, float]:
        """Return the distance of a pair and its bound [m]."""
        if pair not in self._found:
            self._found[pair] = self._bodies.distance(pair)
        return self._found[pair]

    def gap(self, pair: frozenset[str]) -> Gap:
        """Return how a pair closes, by differences: forward and back, where it has a kink."""
        if pair not in self._gaps:
            d, bound = self.at(pair)
            ahead, e_ahead = self._at(self._after, pair)
            back, e_back = self._at(self._before, pair)
            doubt = _SLOPE + (2.0 * bound + e_ahead + e_back) / _MOMENT
            speeds = (d - ahead) / _MOMENT, (back - d) / _MOMENT
            self._gaps[pair] = Gap(d, bound, min(speeds) - doubt, max(speeds) + doubt)
        return self._gaps[pair]

    def _at(self, places: dict[str, RigidTransform], pair: frozenset[str]) -> tuple[float, float]:
        self._bodies.pose({name: places[name] for name in pair if name in places})
        found = self._bodies.distance(pair)
        self._bodies.pose({name: self._now[name] for name in pair if name in self._now})
        return found


def _moved(
    places: dict[str, RigidTransform], twists: Mapping[str, Twist], seconds: float
) -> dict[str, RigidTransform]:
    """Return where bodies are a moment later."""
    moved = dict(places)
    for name, twist in twists.items():
        angle = float(np.linalg.norm(twist.w))
        axis = twist.w / angle if angle else np.array([1.0, 0.0, 0.0])
        turn = RotationMatrix(AngleAxis(angle * seconds, axis))
        X = places[name]
        moved[name] = RigidTransform(turn @ X.rotation(), X.translation() + twist.v * seconds)
    return moved
