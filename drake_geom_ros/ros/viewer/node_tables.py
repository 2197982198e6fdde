"""Tables of a running node for a page: its sensors, ages, stops with their reasons, stopping."""

from __future__ import annotations

import math
import re
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_msgs.msg import Float64

from drake_geom_ros.client import Services
from drake_geom_ros.proximity_rules import Level, Why
from drake_geom_ros.viewing.tables import TextRow, TextTable

_PERIOD = 1.0  # [s] between two questions about ages
_PATIENCE = 5.0  # [s] after which an answer is taken for lost
_LATE = 3.0  # [s] without an answer, after which the last one is not shown
_MOST_EVENTS = 30  # in the table, the newest
_MOST_FRAMES = 12  # in the table, those with the oldest poses
_SENSORS, _AGES = 'list_obstacle_sources', 'get_pose_ages'
_TIMEOUT = re.compile(r'\btimeout: ([0-9.e+-]+)')
_TOPIC = re.compile(r'\btopic: ([^\s,}]+)')


class NodeTables:
    """Listens to events and stopping, and asks for ages while somebody looks."""

    def __init__(
        self, node: Node, services: Services, server: str, changed: Callable[[], None]
    ) -> None:
        """Listen with a node that another thread spins; ``changed()`` is called with news."""
        self._services, self._changed = services, changed
        self._lock = threading.Lock()
        self._answers: dict[str, tuple[float, Any]] = {}  # with the time [s] when each came
        self._next: dict[str, float] = {}
        self._events: deque[TextRow] = deque(maxlen=_MOST_EVENTS)
        self._stopping: Any = None
        self._scale: float | None = None
        for kind, topic, take, depth in (
            (msg.ProximityEvents, 'proximity_events', self._take_events, 1000),
            (msg.Stopping, 'stopping', self._take_stopping, 1),
            (Float64, 'speed_scale', self._take_scale, 1),
        ):
            node.create_subscription(kind, f'{server}/{topic}', take, QoSProfile(depth=depth))

    def shown(self) -> list[TextTable]:
        """Return the tables as known now, and ask anew for what grows old."""
        for name in (_SENSORS, _AGES):
            self._ask(name)
        with self._lock:
            tables = [self._stops()]
            if self._stopping is not None and self._stopping.rules:
                tables.append(stopping_table(self._stopping))
            if (sensors := self._answer(_SENSORS)) is not None and sensors.names:
                tables.append(_sensors_table(sensors))
            if (ages := self._answer(_AGES)) is not None:
                tables.append(_ages_table(ages))
            return tables

    def _ask(self, name: str) -> None:
        now = time.monotonic()
        if now < self._next.get(name, 0.0) or self._services.missing(name):
            return
        self._next[name] = now + _PATIENCE

        def take(done: Future) -> None:
            self._next[name] = time.monotonic() + _PERIOD
            with self._lock:
                self._answers[name] = time.monotonic(), done.result()
            self._changed()

        self._services.send(name).add_done_callback(take)

    def _answer(self, name: str) -> Any:
        """Return the last answer of a service; None if there is none of now, or a refusal."""
        heard, answer = self._answers.get(name, (0.0, None))
        is_new = answer is not None and time.monotonic() - heard < _LATE
        return answer if is_new and answer.success else None

    def _take_events(self, message: msg.ProximityEvents) -> None:
        stamp = message.header.stamp
        rows = []
        for k, rule in enumerate(message.rule):
            entered = message.entered[k]
            level = Level(message.level[k])
            pair = int(message.id_a[k]), int(message.id_b[k])
            bodies = ' | '.join(filter(None, (message.geometry_a[k], message.geometry_b[k])))
            cells = (
                _time_of_day(stamp.sec + 1e-9 * stamp.nanosec),
                rule,
                f'{level.name.lower()} {"entered" if entered else "left"}',
                in_words(message.why[k]),
                bodies,
                _length(message.distance[k]),
            )
            stops = entered and level in (Level.STOP, Level.STOPPABLE)
            rows.append(TextRow(cells, warns=stops, pair=pair if all(pair) else None))
        with self._lock:
            self._events.extendleft(rows)
        self._changed()

    def _take_stopping(self, message: msg.Stopping) -> None:
        with self._lock:
            self._stopping = message
        self._changed()

    def _take_scale(self, message: Float64) -> None:
        with self._lock:
            self._scale = message.data

    def _stops(self) -> TextTable:
        scale = '' if self._scale is None else f', speed scale {self._scale:.2f}'
        columns = ('time [UTC]', 'rule', 'change', 'why', 'pair', 'distance')
        empty = 'no rule was entered or left since this page was opened'
        return TextTable(f'Events{scale}', columns, list(self._events), empty)


def in_words(why: int) -> str:
    """Return a reason of a rule's state as a text; empty for none."""
    return Why(why).name.lower().replace('_', ' ') if why else ''


def _sensors_table(answer: Any) -> TextTable:
    rows = []
    for name, settings, messages, age in zip(
        answer.names, answer.settings, answer.messages, answer.ages, strict=True
    ):
        topic, timeout = _TOPIC.search(settings), _TIMEOUT.search(settings)
        limit = float(timeout[1]) if timeout else math.inf
        cells = (name, topic[1] if topic else '', str(messages), _age(age))
        rows.append(TextRow(cells, warns=not age < limit))
    return TextTable('Sensors', ('sensor', 'topic', 'messages', 'age'), rows)


def _ages_table(answer: Any) -> TextTable:
    rows = [
        TextRow((name, _age(age)), warns=math.isinf(age))
        for name, age in list(zip(answer.names, answer.ages, strict=True))[:_MOST_FRAMES]
        if age > 0.0
    ]
    title = 'Ages of poses, the oldest first'
    return TextTable(title, ('frame', 'age'), rows, 'no pose grows old')


def stopping_table(message: msg.Stopping) -> TextTable:
    """Return a row for each rule of the level STOPPABLE: whether all stand before contact."""
    columns = ('rule', 'stops in time', 'after', 'within', 'minimum clearance', 'pair')
    rows = []
    for k, rule in enumerate(message.rules):
        trouble = message.trouble[k]
        proved = 'yes' if message.clear[k] else f'NOT PROVED, scale {message.scale[k]:.2f}'
        pair = int(message.id_a[k]), int(message.id_b[k])
        bodies = ' | '.join(filter(None, (message.geometry_a[k], message.geometry_b[k])))
        cells = (
            rule,
            f'NOT PROVED: {trouble}' if trouble else proved,
            f'{message.stopping_time[k]:.3f} s',
            _length(message.stopping_distance[k]),
            _length(message.least_clearance[k]),
            bodies,
        )
        rows.append(TextRow(cells, not message.clear[k], pair if all(pair) else None))
    return TextTable('Stopping', columns, rows)


def _time_of_day(seconds: float) -> str:
    """Return the time of day of a stamp, as its clock has it."""
    minutes, rest = divmod(seconds % 86400.0, 60.0)
    hours, minutes = divmod(minutes, 60.0)
    return f'{hours:02.0f}:{minutes:02.0f}:{rest:04.1f}'


def _age(seconds: float) -> str:
    return 'never heard of' if math.isinf(seconds) else f'{seconds:.2f} s'


def _length(metres: float) -> str:
    if math.isnan(metres):
        return 'not known'
    return 'farther than asked' if math.isinf(metres) else f'{1e3 * metres:.1f} mm'
