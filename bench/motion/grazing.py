"""Motions that graze by construction, with their first contact in closed form, to fifty digits.

A ball that passes a ball on a line, a ball that comes down to a plane and no farther, and a rod
that turns past a ball at its tip: by a hair above or below the least distance, or exactly at it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from bench.motion.bodies import Floats, Scene
from drake_geom_ros.geometry import Capsule, HalfSpace, Sphere
from drake_geom_ros.geometry.queries.motion_queries import MotionQuestion

_DIGITS = 50
_TIME_ROUNDING = 1e-12  # of quaternions and times as numbers
_HAIRS = (0.0, 1e-6, 1e-9, -1e-6, -1e-9)  # [m]
_AT_REST = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Grazing:
    """A motion, and when its bodies first are as near as is asked about; never: None."""

    starts: Floats
    ends: Floats
    least: float
    first: Any
    hair: float  # [m] from the least distance


class GrazingScenes:
    """The three scenes, of some sizes, each prepared for many motions."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._radii = tuple(rng.uniform(0.1, 0.5, 2).tolist())
        self._length = float(rng.uniform(0.5, 3.0))
        first, second = self._radii
        self._scenes = (
            Scene([Sphere(first), Sphere(second)]),
            Scene([HalfSpace(), Sphere(second)]),
            Scene([Capsule(first, self._length), Sphere(second)]),
        )

    def check(self, rng: np.random.Generator) -> tuple[Any, bool]:
        """Return what is found of a random one, and whether it is wrong."""
        number = int(rng.integers(3))
        made = (self._balls, self._plane, self._rod)[number](rng)
        found = self._scenes[number].check(
            made.starts, made.ends, MotionQuestion(made.least), 'slerp'
        )
        return found, _is_wrong(made, found)

    def _balls(self, rng: np.random.Generator) -> Grazing:
        """Let the first ball go along x past the second, now and then for kilometres."""
        least, hair = _least_and_hair(rng)
        scale = float(rng.choice([1.0, 1.0, 1e3]))
        off = sum(self._radii) + least + hair
        begin, end = -scale * rng.uniform(1.5, 3), scale * rng.uniform(1.5, 3)
        starts, ends = np.tile(_AT_REST, (2, 1)), np.tile(_AT_REST, (2, 1))
        starts[0, :2], ends[0, :2] = (begin, off), (end, off)
        with mpmath.workdps(_DIGITS):
            reach = mpmath.mpf(self._radii[0]) + mpmath.mpf(self._radii[1]) + mpmath.mpf(least)
            rest = reach**2 - mpmath.mpf(off) ** 2
            half = mpmath.sqrt(rest) if rest >= 0 else None
            way = mpmath.mpf(end) - mpmath.mpf(begin)
            first = None if half is None else (-half - mpmath.mpf(begin)) / way
        return Grazing(starts, ends, least, first, hair)

    def _plane(self, rng: np.random.Generator) -> Grazing:
        """Let the ball come down, on a slant, to a hair from the least distance."""
        least, hair = _least_and_hair(rng)
        begin, end = rng.uniform(2.0, 3.0), self._radii[1] + least + hair
        starts, ends = np.tile(_AT_REST, (2, 1)), np.tile(_AT_REST, (2, 1))
        starts[1, 2], ends[1, 0], ends[1, 2] = begin, rng.normal(), end
        with mpmath.workdps(_DIGITS):
            touching = mpmath.mpf(self._radii[1]) + mpmath.mpf(least)
            way = mpmath.mpf(begin) - mpmath.mpf(end)
            first = (mpmath.mpf(begin) - touching) / way
        return Grazing(starts, ends, least, first if first <= 1 else None, hair)

    def _rod(self, rng: np.random.Generator) -> Grazing:
        """Let the rod turn about z, its tip past the ball by a hair."""
        least, hair = _least_and_hair(rng)
        arm, reach = 0.5 * self._length, sum(self._radii) + least
        away, angle = arm + reach + hair, rng.uniform(2.0, 3.0)
        bearing = rng.uniform(0.9, angle)
        ball = _AT_REST.copy()
        ball[:2] = away * math.cos(bearing), away * math.sin(bearing)
        side = math.sqrt(0.5)
        start = np.array([0.0, 0.0, 0.0, 0.0, side, 0.0, side])  # from z to x
        sine, cosine = math.sin(0.5 * angle), math.cos(0.5 * angle)
        end = np.array([0.0, 0.0, 0.0, *(side * np.array([-sine, cosine, sine, cosine]))])
        first = None
        with mpmath.workdps(_DIGITS):
            a, d, r = mpmath.mpf(arm), mpmath.mpf(away), mpmath.mpf(reach)
            cosine = (d * d + a * a - r * r) / (2 * a * d)
            if cosine <= 1:
                first = (mpmath.mpf(bearing) - mpmath.acos(cosine)) / mpmath.mpf(angle)
                first = max(first, mpmath.mpf(0))
        return Grazing(np.stack((start, ball)), np.stack((end, ball)), least, first, hair)


def _least_and_hair(rng: np.random.Generator) -> tuple[float, float]:
    return float(rng.choice([0.0, 0.05])), float(rng.choice(_HAIRS))


def _is_wrong(made: Grazing, found: Any) -> bool:
    """Tell whether what was found is not so.

    A motion at exactly the least distance is so within rounding: it may be clear or touch.
    """
    if made.first is None:
        return bool(made.hair > 0.0 and found.outcome == 'contact')
    early = found.times[0] > float(made.first) + _TIME_ROUNDING
    if made.hair == 0.0:
        return bool(early and found.outcome != 'clear')
    late = found.outcome == 'contact' and found.times[1] < float(made.first) - _TIME_ROUNDING
    return bool(found.outcome == 'clear' or early or late)
