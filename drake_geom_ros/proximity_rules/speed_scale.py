"""Speed scale of a robot, 0 to 1, from the states of its proximity rules."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.proximity_rules.decisions import Limits, Reasons
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, Why
from drake_geom_ros.proximity_rules.watched_pairs import WatchedPairs


class SpeedScale:
    """Speed scale of a set of rules, the minimum over all of them.

    A stop rule scales to 0 while it is entered or needs a pose that is not valid. A slow rule
    scales by its curve of the distance: its ``scale``, or by default a straight line from 0 at
    the greatest ``enter`` of the stop rules that share a pair with it (0 m if none does) to 1 at
    its ``leave``. While a pair would touch sooner than ``min_time_to_contact``, the scale is at
    most the remaining fraction of that time. A slow rule scales to the minimum of its curve if a
    pose that it needs was never received, and also while it is entered and a pose or motion that
    it needs is unknown. A stoppable rule scales to the share of the present speed from which
    braking is proved to end before contact, and to 0 while a pose that it needs is not valid,
    unless that is only stale, and its ``when_stale`` is 'keep': then what is stale grows.

    A latched slow rule that nobody acknowledged scales as at its ``enter``, however far away its
    pairs are meanwhile; a stoppable one to 0.
    """

    def __init__(self, rules: Sequence[ProximityRule], watched: WatchedPairs) -> None:
        levels = np.array([rule.level for rule in rules])
        self._stops = levels == Level.STOP
        self._stoppable = levels == Level.STOPPABLE
        slow = [n for n, rule in enumerate(rules) if rule.level == Level.SLOW]
        stops = np.flatnonzero(self._stops).tolist()
        begins = watched.greatest_shared(slow, stops, np.array([rules[n].enter for n in stops]))
        self._curves = {
            number: np.array(rules[number].scale or _line(begin, rules[number].leave)).T
            for number, begin in zip(slow, begins.tolist(), strict=True)
        }
        self._slow = np.array(list(self._curves), dtype=np.int64)
        self._ends = np.array([curve[0, -1] for curve in self._curves.values()])
        self.has_scale: Flags = self._stops | self._stoppable  # (r,) rules that scale
        self.has_scale[self._slow] = True
        # Without a stop, slow or stoppable rule there is no scale to publish.
        self.is_asked_for = bool(self.has_scale.any())

    def value(self, entered: Flags, latched: Flags, reasons: Reasons, limits: Limits) -> float:
        """Return the scale, by masks (r,), and the reasons and limits of rules.

        ``latched`` are the rules that are entered and wait to be acknowledged.
        """
        if (self._stops & (entered | (reasons.unposed > 0))).any():
            return 0.0
        return float(self.each(entered, latched, reasons, limits).min(initial=1.0))

    def each(self, entered: Flags, latched: Flags, reasons: Reasons, limits: Limits) -> Floats:
        """Return the scale (r,) of each rule; see ``value``."""
        unposed, absent = reasons.unposed > 0, reasons.unposed == Why.NO_POSE
        grows = (reasons.unposed == Why.STALE) & ~limits.enters_when_stale
        stands = self._stops & (entered | unposed)
        stands |= self._stoppable & ((unposed & ~grows) | latched)
        scales = np.where(stands, 0.0, reasons.stop_scale)
        unseen = (entered & (unposed | reasons.unpredicted)) | absent
        lacking = unseen[self._slow]
        distance = np.where(latched, np.minimum(reasons.lowest, limits.enter), reasons.lowest)
        near = distance[self._slow] < self._ends
        soon = (reasons.soonest < limits.least_time)[self._slow]
        for number in self._slow[near | soon | lacking].tolist():
            distances, curve = self._curves[number]
            lowest = -np.inf if unseen[number] else distance[number]
            scales[number] = np.interp(lowest, distances, curve)
            if limits.least_time[number] > 0.0:
                in_time = reasons.soonest[number] / limits.least_time[number]
                scales[number] = min(scales[number], in_time)
        return scales


def _line(begin: float, leave: float) -> tuple[tuple[float, float], ...]:
    """Return the default curve of a slow rule, from ``begin`` [m] of its stop rules."""
    # A stop rule farther out leaves no interval for a line: then the curve is a step.
    return (min(begin, math.nextafter(leave, -math.inf)), 0.0), (leave, 1.0)
