"""The two clocks that tell how old a pose is, and what becomes of ages when one of them jumps.

The node's time is what stamps are in: the time of day, or simulated time, which may rest, run at
any speed and begin anew. Steady time runs whatever becomes of the other. A pose is as old as the
one of the two says that says more: since its stamp by the node's time, and since its message came
by steady time. So a sender that fell silent is noticed although simulated time rests. No ROS
import.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

# [s] a stamp that is earlier than the node's time by more is of another clock, and tells no age:
# no message is on its way that long.
_MOST_BEHIND = 60.0
# [s] a stamp that is later than the node's time by less is of the same clock: simulated time comes
# in messages of its own, which may be heard after the poses of that time, all at once then.
_MOST_AHEAD = 2.0
# [s] a step of the time of day that no correction of its rate can be, between two looks.
_LEAST_STEP = 0.5
# [s] Simulated time may run fast, and it comes in steps: one of a minute is no simulation's. What
# it goes back by less than the other is told by nobody's age, for steady time counts too.
JUMP_FORWARD, JUMP_BACKWARD = 60.0, 0.1
_LONGEST_LOOK = 0.05  # [s] if reading both clocks takes longer, their difference says nothing


class Since(NamedTuple):
    """Since when a pose holds."""

    epoch: float  # how often the node's time had jumped
    heard: float  # [s] of steady time, when its message came
    held: float  # [s] of the node's time, its stamp

    def said_again(self, first: Since) -> Since:
        """Return since when it holds, the same having been said before, with the same stamp.

        By the node's time it holds since then, lest an old stamp that is repeated, taken for one
        of another clock, be new each time. By steady time it was heard now: while the node's time
        rests, stamps are repeated by senders that are well.
        """
        if first.epoch != self.epoch:
            return self
        return self._replace(held=min(self.held, first.held))


ALWAYS = Since(math.inf, math.inf, math.inf)  # of a pose that does not grow old


class Arrival(NamedTuple):
    """When a message came."""

    epoch: int
    heard: float  # [s] of steady time
    now: float  # [s] of the node's time, when it is taken
    waited: float  # [s] until it was taken

    def since(self, stamp: float) -> Since:
        """Return since when a pose of the message holds that bears a stamp [s].

        Where there is no stamp (0), and where it is of another clock, the pose holds since its
        message came.
        """
        behind = self.now - stamp
        if not stamp or not -_MOST_AHEAD <= behind <= _MOST_BEHIND:
            behind = self.waited
        return Since(self.epoch, self.heard, self.now - behind)


class Clocks:
    """The node's time and steady time [s]."""

    def __init__(
        self, node: Callable[[], float], steady: Callable[[], float] = time.monotonic
    ) -> None:
        self.node = node
        self.steady = steady
        self.epoch = 0
        self._offset: float | None = None

    def begin_anew(self) -> None:
        """Let all ages be unknown that began before now; any thread may call it."""
        self.epoch += 1

    def arrival(self, waited: float = 0.0) -> Arrival:
        """Return the arrival of a message that is taken now, and came ``waited`` [s] ago."""
        # The epoch first: of what jumps in between the age is then unknown, and not wrong.
        epoch = self.epoch
        return Arrival(epoch, self.steady() - waited, self.node(), waited)

    def age(self, since: Since) -> float:
        """Return an age [s]; inf: unknown, for the node's time has jumped."""
        return self.ages()(since)

    def ages(self) -> Callable[[Since], float]:
        """Return what tells ages [s] of now, as ``age`` does; the clocks are read once."""
        epoch, steady, node = self.epoch, self.steady(), self.node()

        def age(since: Since) -> float:
            if since.epoch < epoch:
                return math.inf
            return max(0.0, steady - since.heard, node - since.held)

        return age

    def step(self) -> float:
        """Return by how much [s] the node's time has left steady time since the last look.

        0 where it did not. To be asked only where the node's time has the speed of steady time.
        """
        start, now, end = self.steady(), self.node(), self.steady()
        if end - start > _LONGEST_LOOK:
            return 0.0
        before, self._offset = self._offset, now - start
        step = 0.0 if before is None else self._offset - before
        return step if abs(step) >= _LEAST_STEP else 0.0

    def forget_steps(self) -> None:
        """Let the next look be the first one."""
        self._offset = None
