"""Braking of joints: how long and how far they go on after a stop was asked for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np

from drake_geom_ros.math.array_types import Floats


class BrakingError(RuntimeError):
    """A declaration of braking is invalid, or does not say how a joint brakes."""


class StopCategory(IntEnum):
    """Kind of a stop, as IEC 60204-1 numbers them."""

    EACH_JOINT = 0  # each joint brakes by itself: no path is kept
    ALONG_PATH = 1  # all joints brake in proportion, along the path


@dataclass(frozen=True)
class Braking:
    """Braking of some joints, as its owner declares or measured it.

    Joints go on at their speed for ``reaction_time`` [s] and brake then. ``decelerations``
    [rad/s^2] or [m/s^2] are one for each of ``joint_names``, or one for all; without names it is
    about all joints. With ``stopping_times`` instead, points (speed of the fastest joint [rad/s]
    or [m/s], time [s] from the begin of braking until all stand), all joints brake evenly within
    the time that a straight line between the points gives; below the first point it is that of
    the first point, and above the last one nothing is known.

    With ``StopCategory.ALONG_PATH`` the slowest joint to brake sets the time for all of them.
    With ``StopCategory.EACH_JOINT`` each may stop at any moment from now until its own end.

    Raises BrakingError, which names the field, for an invalid value.

    >>> braking = Braking(decelerations=(2.0,), reaction_time=0.1)
    >>> braking.time_of([1.0, -3.0])
    1.5
    """

    joint_names: tuple[str, ...] = ()
    decelerations: tuple[float, ...] = ()
    stopping_times: tuple[tuple[float, float], ...] = ()
    reaction_time: float = 0.0
    category: int = StopCategory.ALONG_PATH

    def __post_init__(self) -> None:
        if int(self.category) not in tuple(StopCategory):
            raise BrakingError(
                f'stop_category is {self.category}; it must be 1 (all joints brake along the '
                'path) or 0 (each joint by itself)'
            )
        object.__setattr__(self, 'category', StopCategory(self.category))
        if not (math.isfinite(self.reaction_time) and self.reaction_time >= 0.0):
            raise BrakingError(
                f'reaction_time is {self.reaction_time}; it must be finite and >= 0 [s]'
            )
        if len(set(self.joint_names)) < len(self.joint_names) or not all(self.joint_names):
            raise BrakingError(
                f'joint_names is {list(self.joint_names)}; names must not be empty, nor twice'
            )
        if bool(self.decelerations) == bool(self.stopping_times):
            raise BrakingError(
                'it must have either decelerations or stopping_times: without them nobody knows '
                'how it brakes'
            )
        self._check_decelerations()
        self._check_times()

    def _check_decelerations(self) -> None:
        values, count = self.decelerations, len(self.joint_names)
        if len(values) > 1 and len(values) != count:
            raise BrakingError(
                f'decelerations has {len(values)} numbers for {count} joint_names; it must have '
                'one for each, or one for all'
            )
        if not all(math.isfinite(value) and value > 0.0 for value in values):
            raise BrakingError(
                f'decelerations is {list(values)}; each must be finite and > 0 [rad/s^2 or m/s^2]'
            )

    def _check_times(self) -> None:
        points = [list(point) for point in self.stopping_times]
        if not all(math.isfinite(x) and x > 0.0 for point in points for x in point):
            raise BrakingError(
                f'stopping_times is {points}; speeds and times must be finite and > 0'
            )
        if any(b[0] <= a[0] or b[1] < a[1] for a, b in pairwise(points)):
            raise BrakingError(
                f'stopping_times is {points}; speeds must ascend, and what is faster must not '
                'stand sooner'
            )

    def decelerations_of(self, count: int) -> Floats:
        """Return the deceleration (count,) of each joint; BrakingError if it has none for each."""
        if len(self.decelerations) not in (1, count):
            raise BrakingError(
                f'decelerations has {len(self.decelerations)} numbers for {count} joints'
            )
        return np.broadcast_to(np.array(self.decelerations), (count,)).astype(np.float64)

    def time_of(self, velocities: Sequence[float] | Floats) -> float:
        """Return the time [s] from the begin of braking until joints of velocities (n,) stand.

        It is infinite above the fastest of ``stopping_times``.
        """
        speeds = np.abs(np.asarray(velocities, dtype=np.float64))
        fastest = float(speeds.max(initial=0.0))
        if fastest == 0.0:
            return 0.0
        if not self.stopping_times:
            return float((speeds / self.decelerations_of(len(speeds))).max())
        speed_table, times = np.array(self.stopping_times).T
        return (
            math.inf
            if fastest > speed_table[-1]
            else float(np.interp(fastest, speed_table, times))
        )
