"""Waits for the entities of one callback group, by a wait set that is kept.

rclpy's executors make a wait set, a timer and a task for each message, and look at each entity of
the node before and after each wait, also once more when the callback has returned. rclpy has
nothing public that keeps a wait set, but the events executor of Kilted, which knows no guard
conditions and delivers messages to subscriptions that were destroyed (``bench.ros.executors``).
"""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.client import Client
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

_NEEDED = (
    *('clear_entities', 'wait', 'get_ready_entities', 'add_subscription', 'add_timer'),
    *('add_client', 'add_service', 'add_guard_condition'),
)
_WAITABLE = 'waitable'
_KINDS: dict[type, str] = {
    Timer: 'timer',
    Subscription: 'subscription',
    GuardCondition: 'guard_condition',
    Client: 'client',
    Service: 'service',
}
# In which rclpy serves what is ready together.
_ORDER = (_WAITABLE, *_KINDS.values())
_PLACE = '_event_index'  # of an event, in a wait set
_SIZES = 'subscription', 'guard_condition', 'timer', 'client', 'service'  # of a wait set


def can_keep_wait_sets() -> bool:
    """Return whether this rclpy has inside what is used here, which is none of its API."""
    wait_set = getattr(rclpy_implementation, 'WaitSet', None)
    takes = all(hasattr(Executor, f'_take_{kind}') for kind in _ORDER)
    events = _PLACE in EventHandler.__init__.__code__.co_names
    return takes and events and all(hasattr(wait_set, name) for name in _NEEDED)


class GroupWaitSet:
    """A wait set for the entities of a group, made anew where these change; for one thread."""

    def __init__(self, group: CallbackGroup, guard: GuardCondition, context: Any) -> None:
        """``guard`` ends a wait when it is triggered."""
        self._group, self._guard, self._context = group, guard, context
        self._alive: list[Any] | None = None
        self._entities: list[tuple[Any, str]] = []
        self._wait_set: Any = None

    def ready(self, timeout: float) -> list[tuple[Any, str]]:
        """Return the entities that are ready within a timeout [s], each with its kind.

        There is none where the guard was triggered.
        """
        self._renew()
        with ExitStack() as open_ones:  # whoever closes one of them meanwhile waits
            open_ones.enter_context(self._context.handle)
            self._wait_set.clear_entities()  # which a wait takes out, too
            there = [each for each in self._entities if self._is_taken(*each, open_ones)]
            self._wait_set.wait(int(timeout * 1e9))
            pointers = {kind: set(self._wait_set.get_ready_entities(kind)) for kind in _SIZES}
            return [
                (entity, kind)
                for entity, kind in there
                if entity is not self._guard and self._is_ready(entity, kind, pointers)
            ]

    def _is_taken(self, entity: Any, kind: str, open_ones: ExitStack) -> bool:
        """Put an entity into the wait set; return whether it is made, and not closed again."""
        if _is_being_made(entity):
            return False
        try:
            if kind == _WAITABLE:
                open_ones.enter_context(entity)
                entity.add_to_wait_set(self._wait_set)
            else:
                open_ones.enter_context(entity.handle)
                getattr(self._wait_set, f'add_{kind}')(entity.handle)
        except InvalidHandle:
            return False
        return True

    def _is_ready(self, entity: Any, kind: str, pointers: dict[str, set[int]]) -> bool:
        if kind == _WAITABLE:
            return bool(entity.is_ready(self._wait_set))
        return entity.handle.pointer in pointers[kind]

    def _renew(self) -> None:
        """Take the entities that the group has now."""
        alive = [it for each in list(self._group.entities) if (it := each()) is not None]
        if self._alive is not None and [*map(id, alive)] == [*map(id, self._alive)]:
            return
        every = [(it, _kind_of(it)) for it in (*alive, self._guard)]
        every.sort(key=lambda each: _ORDER.index(each[1]))
        counts = Counter(kind for _, kind in every)
        events = 0
        for waitable in (it for it, kind in every if kind == _WAITABLE):
            more = waitable.get_num_entities()
            counts.update({kind: getattr(more, f'num_{kind}s') for kind in _SIZES})
            events += more.num_events
        sizes = [counts[kind] for kind in _SIZES]
        self._wait_set = rclpy_implementation.WaitSet(*sizes, events, self._context.handle)
        self._alive, self._entities = alive, every


def _kind_of(entity: Any) -> str:
    return next((kind for it, kind in _KINDS.items() if isinstance(entity, it)), _WAITABLE)


def _is_being_made(entity: Any) -> bool:
    """Return whether another thread is making an entity.

    rclpy has an event in its group before it has the event's handle; its place in a wait set is
    what it sets last. It is in the group's list, so the next wait takes it.
    """
    return isinstance(entity, EventHandler) and not hasattr(entity, _PLACE)
