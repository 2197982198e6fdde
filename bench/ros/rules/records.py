"""What was sent, known and heard: what the referee decides by.

Times [s] are of the machine's clock, which also stamps what the middleware sends. That the node
took a pose, or decided, is known to be between two of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.ros.rules.cell import Rule
from drake_geom_ros.math import RigidTransform

Pairs = frozenset[frozenset[str]]


class Facts(NamedTuple):
    """What is certain for a while."""

    rules: dict[str, Rule]
    filtered: Pairs = frozenset()  # surely
    in_doubt: Pairs = frozenset()  # filtered, or not any more
    is_exact: bool = True  # the level
    unposed: frozenset[str] = frozenset()  # sources whose poses are unknown, or of unknown age


class Twist(NamedTuple):
    """How a body moves in the world."""

    w: NDArray[np.float64]  # (3,) [rad/s]
    v: NDArray[np.float64]  # (3,) [m/s] of its origin

    @classmethod
    def between(cls, before: RigidTransform, after: RigidTransform, seconds: float) -> Twist:
        """Return the mean one from one pose to another."""
        turn = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
        way = after.translation() - before.translation()
        return cls(turn.angle() * turn.axis() / seconds, way / seconds)


class Posed(NamedTuple):
    """When a robot was posed last, and how it moved then."""

    sent: float  # [s] at the latest; where the node's clock rested before, as much earlier
    heard: float  # [s] when the cycle of that was reported
    twists: dict[str, Twist] | None = None  # by body; None: nobody knows


class Heard(NamedTuple):
    """An entry of ProximityEvents, as ProximityMonitor tells it, and when it was heard [s]."""

    event: Any
    at: float


@dataclass
class Step:
    """Poses that were sent and answered by a cycle, and what was heard until the next one."""

    stamp: int  # [ns] that no other step has
    sent: float  # [s]
    heard: float  # [s] when its cycle was reported; inf: it had none
    places: dict[str, RigidTransform]  # of all bodies, as far as they ever had one
    posed: dict[str, Posed]  # by source
    facts: Facts  # when the cycle ran
    later: list[Facts] = field(default_factory=list)  # and until the next one
    events: list[Heard] = field(default_factory=list)
    removed: set[str] = field(default_factory=set)  # rules that end after its cycle
    changed: float = math.inf  # [s] before which ``facts`` were all that held
    until: float = math.inf  # [s] when the next one was sent

    def decisions(self, pulses: list[float]) -> list[tuple[float, float]]:
        """Return intervals [s] that surely hold a whole decision by its poses and facts.

        ``pulses``, ascending, are when the node sent something at the end of a decision.
        """
        first = self.sent if math.isinf(self.heard) else self.heard
        end = min(self.changed, self.until)
        inside = [pulse for pulse in pulses if first <= pulse <= end]
        cycle = [] if math.isinf(self.heard) else [(self.sent, self.heard)]
        return [*cycle, *pairwise(inside)]
