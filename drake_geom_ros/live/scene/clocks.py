"""The age of a moment by two clocks, also after one of them jumps.

The node's time is what stamps are in: the time of day, or simulated time, which may rest, run at
any speed and begin anew. Steady time runs whatever becomes of the other. The age of a pose is the
greater of two: since its stamp by the node's time, and since its message came by steady time. So a
sender that fell silent is noticed although simulated time rests.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Floats

# [s] a stamp that is earlier than the node's time by more is of another clock, or the message is
# that old: nobody can tell, so it counts as that old.
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
    # [s] by which a stamp of another clock was earlier than the node's time; negative: later;
    # 0: it is of the same clock, or there is none.
    offset: float = 0.0

    def said_again(self, first: Since) -> Since:
        """Return since when it holds, the same having been said before, with the same stamp.

        By the node's time it holds since then, lest an old stamp that is repeated, taken for one
        of another clock, be new each time. By steady time it was heard now: while the node's time
        rests, stamps are repeated by senders that are well.
        """
        if first.epoch != self.epoch:
            return self
        return self._replace(held=min(self.held, first.held), offset=first.offset)


def oldest(*moments: Since) -> Since:
    """Return since when all hold that hold since some moments."""
    distinct = set(moments)
    distinct.discard(ALWAYS)
    if len(distinct) < 2:
        return distinct.pop() if distinct else ALWAYS
    epochs, heard, held, offsets = zip(*distinct, strict=True)
    ahead = min(offsets)
    offset = ahead if ahead < 0.0 else max(offsets)
    return UNKNOWN if UNKNOWN in distinct else Since(min(epochs), min(heard), min(held), offset)


def oldest_moments(some: Floats, others: Floats) -> Floats:
    """Return the ``oldest`` of two moments each, rows (n, 4) of the fields of ``Since``."""
    both: Floats = np.minimum(some, others)
    is_ahead = both[:, 3] < 0.0
    both[:, 3] = np.where(is_ahead, both[:, 3], np.maximum(some[:, 3], others[:, 3]))
    both[both[:, 1] == -math.inf] = UNKNOWN
    return both


def oldest_of_each(groups: Iterable[Iterable[Since]]) -> list[Since]:
    """Return the ``oldest`` moment of each group."""
    return [oldest(*group) for group in groups]


ALWAYS = Since(math.inf, math.inf, math.inf)  # of a pose that does not grow old
UNKNOWN = Since(-math.inf, -math.inf, -math.inf)  # of a pose of which nobody knows the age


class Heard(NamedTuple):
    """The time of a message by the node's clock [s], and the epoch of that clock."""

    epoch: int
    time: float


class Arrival(NamedTuple):
    """When a message came."""

    epoch: int
    heard: float  # [s] of steady time
    now: float  # [s] of the node's time, when it is taken
    waited: float  # [s] until it was taken

    def since(self, stamp: float) -> Since:
        """Return since when a pose of the message holds that bears a stamp [s].

        Where there is no stamp (0), and where it is later than the node's time, the pose holds
        since its message came. A stamp of another clock has an ``offset``.
        """
        behind = self.now - stamp
        if not stamp:
            return Since(self.epoch, self.heard, self.now - self.waited)
        if not -_MOST_AHEAD <= behind <= _MOST_BEHIND:
            return Since(self.epoch, self.heard, self.now - self.waited, behind)
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

    def heard(self, waited: float = 0.0) -> Heard:
        """Return the time of a message that came ``waited`` [s] ago."""
        return Heard(self.epoch, self.node() - waited)

    def age(self, since: Since) -> float:
        """Return an age [s]; inf: unknown, by a jump of time or a stamp that lies ahead."""
        return self.ages()(since)

    def ages(self) -> Callable[[Since], float]:
        """Return a function of ages [s], like ``age``, for which the clocks are read once."""
        epoch, steady, node = self.epoch, self.steady(), self.node()

        def age(since: Since) -> float:
            if since.epoch < epoch or since.offset < 0.0:
                return math.inf
            return max(0.0, steady - since.heard, node - since.held) + since.offset

        return age

    def ages_of(self, moments: Iterable[Since]) -> list[float]:
        """Return several ages [s], like ``age``, for which the clocks are read once."""
        age = self.ages()
        return [age(since) for since in moments]

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
