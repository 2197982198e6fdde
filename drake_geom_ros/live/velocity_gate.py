"""A gate for commands of velocity: it scales them by proximity rules, and stops a robot.

It passes nothing before the rules were decided, while they stop the robot, and while nobody
decides about them. A robot whose commands fall silent is stopped.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats

PERIOD = 0.05  # [s] between two looks for silence
LONGEST_UNDECIDED = 0.5  # [s] after which rules that nobody decides about stop the robot
_ZEROS = 10  # messages of rest, one a look, so that one that is lost does no harm


class Decision(NamedTuple):
    """The speed that a robot's rules allow."""

    scale: float  # of the commanded velocity, 0 to 1
    why: str  # reason for a scale below 1, in words


UNDECIDED = Decision(0.0, 'no cycle has decided about its rules yet')


class VelocityGate:
    """Passes commands on, scaled; times [s] are of one steady clock.

    ``publish(twist, header)`` is called with a twist (6,), linear then angular, that the robot is
    to have, and with the header of the command that it is for; None: it is for none.

    >>> passed = []
    >>> gate = VelocityGate(lambda twist, header: passed.append(twist.tolist()), timeout=0.5)
    >>> gate.open()
    >>> gate.take(np.array([1.0, 0, 0, 0, 0, 0.5]), now=0.0)  # before any decision
    >>> gate.decide(Decision(0.5, 'go slowly'), now=0.1)
    >>> gate.take(np.array([1.0, 0, 0, 0, 0, 0.5]), now=0.2)
    >>> gate.decide(Decision(0.0, 'hands off'), now=0.3)
    >>> for twist in passed:
    ...     print(twist)
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    [0.5, 0.0, 0.0, 0.0, 0.0, 0.25]
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """

    def __init__(self, publish: Callable[[Floats, Any], object], timeout: float) -> None:
        """``timeout`` [s]: a robot whose commands are silent for longer is stopped."""
        self._publish, self._timeout = publish, timeout
        self._lock = threading.Lock()  # commands, decisions and looks come from several threads
        self._is_open = False
        self._decision, self._decided = UNDECIDED, -math.inf
        self._command, self._heard = np.zeros(6), -math.inf
        self._proved: Floats | None = None  # the only command that the decision is about
        self._passed = 0.0  # scale of the last message, where that was not at rest
        self._zeros = 0  # messages of rest that are still to be sent
        self.stopped = 0  # how often the robot was stopped

    def open(self) -> None:
        """Pass commands on from now on, once the rules are decided."""
        with self._lock:
            self._is_open, self._decision, self._decided = True, UNDECIDED, -math.inf

    def close(self) -> None:
        """Stop the robot, and pass nothing on."""
        with self._lock:
            if self._is_open:
                self._is_open = False
                self._rest()

    def take(self, twist: Floats, now: float, header: Any = None) -> None:
        """Take a command (6,) [m/s, rad/s] and pass it on.

        Raises ArgumentError for one that is not finite, and stops the robot.
        """
        is_finite = bool(np.isfinite(twist).all())
        with self._lock:
            self._command = np.array(twist) if is_finite else np.zeros(6)
            self._heard = now
            if self._proved is None or not self._command.any():
                self._pass(now, header)
        if not is_finite:
            raise ArgumentError(f'the twist is {twist.tolist()}; it must be finite')

    def decide(self, decision: Decision, now: float, proved: Floats | None = None) -> None:
        """Take what the rules of now allow; a robot that may not go on as fast is sent it at once.

        With ``proved`` (6,) the decision is about this command alone: it is what passes, now, and
        a later one waits for the decision about it. A command to rest waits for none.
        """
        with self._lock:
            stops = decision.scale == 0.0 < self._decision.scale
            self._decision, self._decided, self._proved = decision, now, proved
            is_next = proved is not None and bool(proved.any())
            if is_next or stops or decision.scale < self._passed:
                self._pass(now)

    def command(self) -> Floats:
        """Return the last command (6,) [m/s, rad/s], whatever became of it."""
        with self._lock:
            return self._command

    def look(self, now: float) -> None:
        """Stop a robot for which nothing comes any more: no command, or no decision."""
        with self._lock:
            if self._passed > 0.0 and self._allowed(now).scale < self._passed:
                self._pass(now)
            elif self._zeros > 0 and self._passed == 0.0:
                self._zeros -= 1
                self._send(np.zeros(6), None)

    def allowed(self, now: float) -> Decision:
        """Return how fast the robot may go now, and why not faster."""
        with self._lock:
            return self._allowed(now)

    def _allowed(self, now: float) -> Decision:
        if not self._is_open:
            return Decision(0.0, 'the node is not active')
        if now - self._decided > LONGEST_UNDECIDED:
            why = f'nobody decided about its rules for {LONGEST_UNDECIDED:g} s'
            return UNDECIDED if self._decided == -math.inf else Decision(0.0, why)
        if now - self._heard > self._timeout:
            return Decision(0.0, f'no command came for {self._timeout:g} s')
        return self._decision

    def _pass(self, now: float, header: Any = None) -> None:
        """Send the last command as fast as is allowed."""
        scale = min(1.0, max(0.0, self._allowed(now).scale))
        command = self._command if self._proved is None else self._proved
        if scale > 0.0 and command.any() and self._command.any():
            self._passed, self._zeros = scale, 0
            self._send(command * scale, header)
        else:
            self._rest(header)

    def _rest(self, header: Any = None) -> None:
        """Send that the robot is to stand."""
        if self._passed > 0.0:
            self.stopped, self._zeros = self.stopped + 1, _ZEROS
        self._passed = 0.0
        self._send(np.zeros(6), header)

    def _send(self, twist: Floats, header: Any) -> None:
        self._publish(twist, header)
