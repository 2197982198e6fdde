"""A proximity rule: which pairs, from which distance on, and what that means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

ENTER, KEEP = 'enter', 'keep'


class RuleError(RuntimeError):
    """A rule that cannot be, or that no pair can ever satisfy."""


class Level(IntEnum):
    """What a rule asks for while it is entered."""

    WARN = 1
    SLOW = 2
    STOP = 3


class Why(IntEnum):
    """Why a rule was entered, or, for GONE, left."""

    NEAR = 1  # the lower bound of a distance is below ``enter``
    SOON = 2  # and of a time to contact below ``min_time_to_contact``
    STALE = 3  # a pose that the rule needs is too old
    NO_POSE = 4  # or never came
    GONE = 5  # what the rule is about is no more
    TWO_SENDERS = 7  # two senders pose a body that the rule needs, in turn
    OTHER_CLOCK = 8  # stamps of a pose that it needs are of another clock: its age is not known


@dataclass(frozen=True)
class ProximityRule:
    """A rule about the pairs of one geometry of ``set_a`` and one of ``set_b``.

    Each set is a list of names or patterns as ``client.Results.between`` takes them: of sources
    and robots, frames, geometries. An empty ``set_b`` stands for all that is not of ``set_a``.

    The rule is entered when the certified lower bound of a pair's distance is below ``enter`` [m],
    for ``enter_after`` [s] without a break, and left when all are ``leave`` [m] or more, after
    ``hold`` [s] at the earliest. Where twists are known it is entered, too, while a pair would
    touch within ``min_time_to_contact`` [s] at the closing speed of now (0: distances alone
    count). ``when_stale`` says what follows where a pose that it needs is not known, because it is
    too old, never came, has two senders or stamps of another clock: 'enter', at once, or 'keep',
    which keeps the rule entered, and else goes by the poses that there are; empty: 'enter' for a
    stop and a slow rule, 'keep' for a warning. ``scale`` is pairs (distance [m],
    scale of speed 0 to 1), for slow rules only: see ``speed_scale``.

    Raises RuleError, which names the field, for what cannot be.

    >>> stop = ProximityRule('hands off', ('left',), level=Level.STOP, enter=0.05, leave=0.08)
    >>> stop.enters_when_stale, stop.farthest
    (True, 0.08)
    """

    name: str
    set_a: tuple[str, ...]
    set_b: tuple[str, ...] = ()
    level: Level = Level.STOP
    enter: float = 0.0
    leave: float = 0.0
    hold: float = 0.0
    enter_after: float = 0.0
    min_time_to_contact: float = 0.0
    when_stale: str = ''
    scale: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if not self.name:
            raise RuleError('a proximity rule has no name; events and states are told by it')
        if not self.set_a:
            raise self._refusal('set_a is empty; it must name sources, frames or geometries')
        if self.level not in tuple(Level):
            raise self._refusal(f'level is {self.level}; it must be 1 (WARN), 2 (SLOW), 3 (STOP)')
        object.__setattr__(self, 'level', Level(self.level))  # messages bear numbers
        if not (math.isfinite(self.enter) and math.isfinite(self.leave)):
            raise self._refusal(f'enter={self.enter} and leave={self.leave} must be finite [m]')
        if not self.leave > self.enter:
            raise self._refusal(
                f'leave={self.leave} is not greater than enter={self.enter} [m]: without room in '
                'between a rule is entered and left with every rounding'
            )
        for field in ('hold', 'enter_after', 'min_time_to_contact'):
            seconds = getattr(self, field)
            if not (math.isfinite(seconds) and seconds >= 0.0):
                raise self._refusal(f'{field} is {seconds}; it must be finite and >= 0 [s]')
        if self.when_stale not in ('', ENTER, KEEP):
            raise self._refusal(f"when_stale is {self.when_stale!r}; it must be 'enter' or 'keep'")
        self._check_scale()

    def _check_scale(self) -> None:
        if not self.scale:
            return
        if self.level != Level.SLOW:
            raise self._refusal(f'scale is for slow rules, and this is a {self.level.name} rule')
        flat = [number for point in self.scale for number in point]
        told = [list(point) for point in self.scale]
        if len(self.scale) < 2 or not all(map(math.isfinite, flat)):
            raise self._refusal(f'scale is {told}; it must be two or more finite points')
        distances, scales = zip(*self.scale, strict=True)
        if any(b <= a for a, b in pairwise(distances)):
            raise self._refusal(f'scale is {told}; distances must ascend')
        if not all(0.0 <= scale <= 1.0 for scale in scales):
            raise self._refusal(f'scale is {told}; scales must be from 0 to 1')
        if any(b < a for a, b in pairwise(scales)):
            raise self._refusal(f'scale is {told}; what is nearer must not be faster')

    def _refusal(self, why: str) -> RuleError:
        return RuleError(f'proximity rule {self.name[:80]!r}: {why}')

    @property
    def enters_when_stale(self) -> bool:
        """Whether a pose that is stale, absent or not to be trusted enters the rule."""
        return self.when_stale == ENTER or (not self.when_stale and self.level != Level.WARN)

    @property
    def farthest(self) -> float:
        """The distance [m] from which on a pair counts no more for it, but for its speed."""
        return max(self.leave, self.scale[-1][0]) if self.scale else self.leave


def scale_points(flat: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the points of a scale that comes as numbers one after another.

    Raises RuleError where a number is left over.
    """
    if len(flat) % 2:
        raise RuleError(
            f'scale has {len(flat)} numbers; they are pairs: a distance [m], then a scale'
        )
    return tuple(zip(map(float, flat[::2]), map(float, flat[1::2]), strict=True))
