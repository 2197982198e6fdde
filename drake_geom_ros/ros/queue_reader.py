"""Reads the waiting messages of a topic at once, and skips older ones where there are too many.

rclpy makes Python objects of all parts of a message: for 300 transforms that takes longer than the
5 ms between two messages of 200 Hz. The queue of 100 messages was then always full, and what was
taken from it half a second old. So what waits is taken as bytes, which costs little, and of these
only as many messages are read as can be in a moment: of each publisher the newest.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rclpy.subscription import Subscription

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited

_LONGEST_READING = 0.03  # [s] of the messages that waited; then what they bring is used
_MOST = 1000  # messages that are taken from a queue at once, for it fills meanwhile

Waiting = tuple[bytes, MessageInfo]


class QueueReader:
    """The callback of a subscription to bytes."""

    def __init__(
        self,
        take: Callable[[bytes, float, str], object],
        then: Callable[[int, int], object],
        *,
        may_pass_over: bool,
    ) -> None:
        """``take`` is given each message, how long [s] it waited and who sent it, oldest first.

        ``then`` receives how many messages there were and how many of these were skipped,
        which is none unless ``may_pass_over``.
        """
        self._take = take
        self._then = then
        self._may_pass_over = may_pass_over
        self._seconds_a_byte = 0.0
        # Set by who opens it, maybe after the first message was taken.
        self.subscription: Subscription[Any] | None = None

    def __call__(self, first: bytes, info: MessageInfo) -> None:
        """Take a message, and all that wait behind it."""
        queue: Sequence[Waiting] = [(first, info)]
        if self.subscription is not None:
            queue = [*queue, *_waiting_in(self.subscription)]
        start = time.perf_counter()
        chosen = queue
        if self._may_pass_over and self._seconds_a_byte:
            chosen = newest(queue, _LONGEST_READING / self._seconds_a_byte)
        for raw, message_info in chosen:
            self._take(raw, waited(message_info), publisher_of(message_info))
        size = sum(len(raw) for raw, _ in chosen)
        self._seconds_a_byte = (time.perf_counter() - start) / max(1, size)
        self._then(len(queue), len(queue) - len(chosen))


def newest(queue: Sequence[Waiting], room: float) -> Sequence[Waiting]:
    """Return what has room [bytes], oldest first: the newest of each publisher before others.

    Never nothing: one message has room anyhow.
    """
    if sum(len(raw) for raw, _ in queue) <= room:
        return queue
    seen: Counter[str] = Counter()
    order: list[tuple[int, int]] = []  # how many newer ones its publisher has, how many all have
    for age, (_, info) in enumerate(reversed(queue)):
        publisher = publisher_of(info)
        order.append((seen[publisher], age))
        seen[publisher] += 1
    chosen_ages: list[int] = []
    for _, age in sorted(order):
        room -= len(queue[-1 - age][0])
        if chosen_ages and room < 0.0:
            break
        chosen_ages.append(age)
    return [queue[-1 - age] for age in sorted(chosen_ages, reverse=True)]


def _waiting_in(subscription: Subscription[Any]) -> list[Waiting]:
    """Take what waits in a subscription's queue, as an executor does."""
    waiting: list[Waiting] = []
    with subscription.handle:
        take = partial(subscription.handle.take_message, subscription.msg_type, subscription.raw)
        while len(waiting) < _MOST and (taken := take()):
            waiting.append(taken)
    return waiting
