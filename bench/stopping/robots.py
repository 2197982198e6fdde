"""Robots that go from target to target along straight lines of joint values, and brake."""

from __future__ import annotations

from collections import deque

import numpy as np

from drake_geom_ros.math.array_types import Floats

CYCLE = 0.05  # [s] of a controller
STEPS = 5  # of the simulation in a cycle
REACTION = 0.1  # [s] from a command to the change of speed
SPEEDS = {'arm': 1.0, 'base': 0.8}  # [rad/s] [m/s] of the fastest joint
BRAKES = {'arm': 3.0, 'base': 1.5}  # [rad/s^2] [m/s^2]
_PATIENCE = 2.0  # [s] that a robot stands before it tries another target


class Walker:
    """A robot with one share of its nominal speed, 0 to 1, for all joints."""

    def __init__(self, name: str, lower: Floats, upper: Floats, rng: np.random.Generator) -> None:
        self.name, self._lower, self._upper, self._rng = name, lower, upper, rng
        self.positions: Floats = 0.5 * (lower + upper)
        self.share = 0.0
        self._commands = deque([0.0] * round(REACTION / CYCLE))
        self._stood, self.gone = 0.0, 0.0  # [s] at rest; [s] of nominal motion
        if name == 'base':
            self.positions = np.array([-2.0, -2.5])
        self._choose()

    @property
    def velocities(self) -> Floats:
        """The velocities (c,) that it is to have."""
        return self._direction * SPEEDS[self.name]

    @property
    def in_flight(self) -> float:
        """The largest share that it has, or was commanded and has not heard of."""
        return max(self.share, *self._commands)

    def command(self, share: float) -> None:
        """Send a share, which it hears ``REACTION`` later."""
        self._commands.append(0.0 if self._is_arriving() else share)

    def move(self) -> list[tuple[Floats, float]]:
        """Go on for a cycle; return positions and shares at its steps."""
        heard, rate = self._commands.popleft(), BRAKES[self.name] / SPEEDS[self.name]
        seconds, passed = CYCLE / STEPS, []
        for _ in range(STEPS):
            before = self.share
            self.share += float(np.clip(heard - self.share, -rate * seconds, rate * seconds))
            went = 0.5 * (before + self.share) * seconds
            self.positions = self.positions + self.velocities * went
            self.gone += went
            self._left -= went
            passed.append((self.positions, max(before, self.share)))
        self._stood = self._stood + CYCLE if self.share == 0.0 else 0.0
        is_done = self._left * SPEEDS[self.name] < 0.02 or self._stood > _PATIENCE
        if self.share == 0.0 and not any(self._commands) and is_done:
            self._choose()
        return passed

    def _is_arriving(self) -> bool:
        """Return whether braking that begins now ends at the target, or beyond it."""
        share = self.in_flight
        braking = 0.5 * share * share * SPEEDS[self.name] / BRAKES[self.name]
        return self._left <= braking + (REACTION + CYCLE) * share

    def _choose(self) -> None:
        target = self._rng.uniform(self._lower, self._upper)
        way = target - self.positions
        self._direction = way / np.abs(way).max()
        self._left = float(np.abs(way).max()) / SPEEDS[self.name]  # [s] of nominal motion
        self._stood = 0.0
