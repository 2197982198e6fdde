"""Proximity rule: the pairs it watches, its distances, and its level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

from drake_geom_ros.stopping import Braking, BrakingError

ENTER, KEEP = 'enter', 'keep'
_LEVELS = '1 (WARN), 2 (SLOW), 3 (STOP), 4 (STOPPABLE)'
# Of rules of level STOPPABLE alone, and of all others alone.
_OF_STOPPING = ('joint_names', 'decelerations', 'stopping_times')
_NUMBERS_OF_STOPPING = ('reaction_time', 'margin', 'max_speed')
_OF_DISTANCES = ('enter', 'leave', 'min_time_to_contact')


class RuleError(RuntimeError):
    """A rule is invalid, unknown or duplicate, or no pair can ever enter it."""


class Level(IntEnum):
    """Reaction that a rule demands while it is entered."""

    WARN = 1
    SLOW = 2
    STOP = 3
    STOPPABLE = 4


class Why(IntEnum):
    """Reason why a rule was entered, or, for GONE, left."""

    NEAR = 1  # the lower bound of a distance is below ``enter``
    SOON = 2  # the lower bound of a time to contact is below ``min_time_to_contact``
    STALE = 3  # a pose that the rule needs is too old
    NO_POSE = 4  # a pose that the rule needs has never been received
    GONE = 5  # the geometries of the rule were removed
    CANNOT_STOP = 6  # braking that begins now is not proved to end before contact
    TWO_SENDERS = 7  # two senders alternate in posing a body that the rule needs
    OTHER_CLOCK = 8  # a pose that it needs has stamps of another clock, so its age is unknown


@dataclass(frozen=True)
class ProximityRule:
    """A rule about the pairs of one geometry of ``set_a`` and one of ``set_b``.

    Each set is a list of names or patterns as ``client.Results.between`` takes them: of sources
    and robots, frames, geometries. An empty ``set_b`` stands for all geometries not in ``set_a``.

    The rule is entered when the certified lower bound of a pair's distance stays below ``enter``
    [m] for ``enter_after`` [s]. It is left when the lower bounds of all pairs are ``leave`` [m]
    or more, at the earliest after ``hold`` [s]. Where twists are known, it is also entered while
    a pair would touch within ``min_time_to_contact`` [s] at its current closing speed (0: only
    distances count).

    ``when_stale`` applies while a pose that the rule needs is not valid: too old, never
    received, from two senders, or with stamps of another clock. It is 'enter' (enter at once),
    'keep' (an entered rule stays entered, others go by the poses that there are), or empty:
    'enter' for stop and slow rules, 'keep' for warnings. ``scale`` is pairs (distance [m], speed
    scale 0 to 1), for slow rules only: see ``speed_scale``.

    Of a sensed map at least ``min_points`` cells or points must be near: the distance of a map is
    that of the one of this rank, the nearest first.

    A rule with ``acknowledge`` is latched: once entered it is left only after somebody
    acknowledged that entering: see ``RuleMonitor.acknowledge``.

    A rule of level STOPPABLE has no distances and no time to contact. It is entered while braking
    that begins now is not proved to end before contact: the robots of ``set_a`` brake as
    ``braking`` says, which ``joint_names``, ``decelerations``, ``stopping_times``,
    ``reaction_time`` and ``stop_category`` make up. On their way they must keep more than
    ``margin`` [m] from ``set_b``, of which everything that is not fixed to the world may come
    towards them at ``max_speed`` [m/s].

    Raises RuleError, which names the field, for an invalid value.

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
    acknowledge: bool = False
    min_points: int = 1
    joint_names: tuple[str, ...] = ()
    decelerations: tuple[float, ...] = ()
    stopping_times: tuple[tuple[float, float], ...] = ()
    reaction_time: float = 0.0
    margin: float = 0.0
    max_speed: float = 0.0
    stop_category: int = 1  # 0 for other levels

    def __post_init__(self) -> None:
        if not self.name:
            raise RuleError('a proximity rule has no name; events and states are told by it')
        if not self.set_a:
            raise self._refusal('set_a is empty; it must name sources, frames or geometries')
        if self.level not in tuple(Level):
            raise self._refusal(f'level is {self.level}; it must be {_LEVELS}')
        object.__setattr__(self, 'level', Level(self.level))  # messages bear numbers
        if not (math.isfinite(self.enter) and math.isfinite(self.leave)):
            raise self._refusal(f'enter={self.enter} and leave={self.leave} must be finite [m]')
        if self.level == Level.STOPPABLE:
            self._check_stopping()
        elif not self.leave > self.enter:
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
        if not (isinstance(self.min_points, int) and self.min_points >= 1):
            raise self._refusal(f'min_points is {self.min_points}; it must be a number from 1 on')
        if self.level != Level.STOPPABLE:
            object.__setattr__(self, 'stop_category', 0)
            for field in (*_OF_STOPPING, *_NUMBERS_OF_STOPPING):
                if getattr(self, field):
                    raise self._refusal(
                        f'{field} is for stoppable rules, and this is a {self.level.name} rule'
                    )

    def _check_stopping(self) -> None:
        for field in _OF_DISTANCES:
            if getattr(self, field):
                raise self._refusal(
                    f'{field} is for other levels; a stoppable rule goes by its braking, and by '
                    'margin [m]'
                )
        if self.min_points != 1:
            raise self._refusal('min_points is for other levels; a stoppable rule counts all')
        for field in ('margin', 'max_speed'):
            value = getattr(self, field)
            if not (math.isfinite(value) and value >= 0.0):
                raise self._refusal(f'{field} is {value}; it must be finite and >= 0')
        try:
            _ = self.braking
        except BrakingError as error:
            raise self._refusal(str(error)) from None

    def _check_scale(self) -> None:
        if not self.scale:
            return
        if self.level != Level.SLOW:
            raise self._refusal(f'scale is for slow rules, and this is a {self.level.name} rule')
        flat = [number for point in self.scale for number in point]
        points = [list(point) for point in self.scale]
        if len(self.scale) < 2 or not all(map(math.isfinite, flat)):
            raise self._refusal(f'scale is {points}; it must be two or more finite points')
        distances, scales = zip(*self.scale, strict=True)
        if any(b <= a for a, b in pairwise(distances)):
            raise self._refusal(f'scale is {points}; distances must ascend')
        if not all(0.0 <= scale <= 1.0 for scale in scales):
            raise self._refusal(f'scale is {points}; scales must be from 0 to 1')
        if any(b < a for a, b in pairwise(scales)):
            raise self._refusal(f'scale is {points}; what is nearer must not be faster')

    def _refusal(self, why: str) -> RuleError:
        return RuleError(f'proximity rule {self.name[:80]!r}: {why}')

    @property
    def braking(self) -> Braking:
        """The braking of a rule of level STOPPABLE; raises BrakingError for other levels."""
        return Braking(
            self.joint_names,
            self.decelerations,
            self.stopping_times,
            self.reaction_time,
            self.stop_category,
        )

    @property
    def enters_when_stale(self) -> bool:
        """True if a pose that is stale, absent or not trusted enters the rule."""
        return self.when_stale == ENTER or (not self.when_stale and self.level != Level.WARN)

    @property
    def farthest(self) -> float:
        """The distance [m] beyond which a pair counts only by its time to contact."""
        if self.level == Level.STOPPABLE:
            return -math.inf
        return max(self.leave, self.scale[-1][0]) if self.scale else self.leave


def scale_points(flat: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the points of a scale from a flat list of distance, scale, distance, scale, ...

    Raises RuleError for an odd count of numbers.
    """
    return _points('scale', 'a distance [m], then a scale', flat)


def stopping_points(flat: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the points of stopping times from a flat list of speed, time, speed, time, ...

    Raises RuleError for an odd count of numbers.
    """
    return _points('stopping_times', 'a speed [rad/s or m/s], then a time [s]', flat)


def _points(field: str, words: str, flat: Sequence[float]) -> tuple[tuple[float, float], ...]:
    if len(flat) % 2:
        raise RuleError(f'{field} has {len(flat)} numbers; they are pairs: {words}')
    return tuple(zip(map(float, flat[::2]), map(float, flat[1::2]), strict=True))
