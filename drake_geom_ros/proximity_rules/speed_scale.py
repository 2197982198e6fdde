"""How fast a robot may go, 0 to 1, by what its rules know."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules.decisions import Limits, Reasons
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, Why
from drake_geom_ros.proximity_rules.watched_pairs import WatchedPairs

Flags = NDArray[np.bool_]


class SpeedScale:
    """The scale of speed of some rules; the least of all rules counts.

    0 while a stop rule is entered, or a pose that it needs is not known. Of a slow rule the
    scale ascends in a straight line from 0 at the greatest ``enter`` of the stop rules that share
    a pair with it (0 m where none does) to 1 at its ``leave``, or as its own ``scale`` says; and
    while a pair would touch sooner than ``min_time_to_contact``, it is at most the part of that
    time that is left. While a slow rule is entered and lacks a pose, or the motion that times are
    told by, or a pose that it needs never came, it is the scale's least.
    """

    def __init__(self, rules: Sequence[ProximityRule], watched: WatchedPairs) -> None:
        levels = np.array([rule.level for rule in rules])
        self._stops = levels == Level.STOP
        slow = [n for n, rule in enumerate(rules) if rule.level == Level.SLOW]
        stops = np.flatnonzero(self._stops).tolist()
        begins = watched.greatest_shared(slow, stops, np.array([rules[n].enter for n in stops]))
        self._curves = {
            number: np.array(rules[number].scale or _line(begin, rules[number].leave)).T
            for number, begin in zip(slow, begins.tolist(), strict=True)
        }
        self._slow = np.array(list(self._curves), dtype=np.int64)
        self._ends = np.array([curve[0, -1] for curve in self._curves.values()])
        # Whether any rule says how fast to go; without one there is nothing to say.
        self.is_asked_for = bool(self._stops.any()) or bool(self._curves)

    def value(self, entered: Flags, reasons: Reasons, limits: Limits) -> float:
        """Return the scale for the rules (r,) that are entered, and what is known of each."""
        blind, absent = reasons.blind > 0, reasons.blind == Why.NO_POSE
        if (self._stops & (entered | blind)).any():
            return 0.0
        scale = 1.0
        unseen = (entered & (blind | reasons.unpredicted)) | absent
        lacking = unseen[self._slow]
        near = reasons.lowest[self._slow] < self._ends
        soon = (reasons.soonest < limits.least_time)[self._slow]
        for number in self._slow[near | soon | lacking].tolist():
            distances, scales = self._curves[number]
            lowest = -np.inf if unseen[number] else reasons.lowest[number]
            scale = min(scale, float(np.interp(lowest, distances, scales)))
            if limits.least_time[number] > 0.0:
                scale = min(scale, float(reasons.soonest[number] / limits.least_time[number]))
        return scale


def _line(begin: float, leave: float) -> tuple[tuple[float, float], ...]:
    """Return the scale of a slow rule that names none, from a stop that shares a pair with it."""
    # A stop farther out leaves no room for a line: then it is a step.
    return (min(begin, math.nextafter(leave, -math.inf)), 0.0), (leave, 1.0)
