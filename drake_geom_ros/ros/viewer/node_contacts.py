"""The contact surfaces of a running node as a page shows them: asked for by its service."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from rclpy.task import Future

from drake_geom_ros.client import Services
from drake_geom_ros.viewing.patches import Patches
from drake_geom_ros.viewing.shown_contacts import Left, ShownContacts

_NAME = 'compute_contact_surfaces'
_ANSWER_PATIENCE = 2.0  # [s] after which an answer is taken for lost
_ASK_PERIOD = 0.2  # [s] between two questions
_STALE = 2.0  # [s] of an answer, after which it is no longer shown


class NodeContacts:
    """Asks while somebody wants to see; the last answer is shown until the next one comes."""

    def __init__(self, services: Services, server: str, changed: Callable[[], None]) -> None:
        """Ask with ``services``; ``changed()`` is called by who spins when an answer comes."""
        self._services, self._server, self._changed = services, server, changed
        self._lock = threading.Lock()
        self._answer: Any = None
        self._heard = 0.0  # [s] of the steady clock
        self._next = 0.0

    def shown(self, names_version: int, names: Mapping[int, str]) -> ShownContacts:
        """Return what is known now for names of a version, and ask anew."""
        trouble = self._ask()
        with self._lock:
            answer, age = self._answer, time.monotonic() - self._heard
        if trouble:
            return _nothing(trouble)
        if answer is None or age > _STALE:
            return _nothing(f'waiting for {self._server}/{_NAME}')
        if not answer.success:
            return _nothing(f'{_NAME}: {answer.message}')
        if answer.result.names_version != names_version:
            return _nothing(f'waiting for {self._server}/{_NAME}, the scene being new')
        return _of_message(answer.result, names)

    def _ask(self) -> str:
        """Ask if it is time to; return why that cannot be."""
        now = time.monotonic()
        if now < self._next:
            return ''
        if self._services.missing(_NAME):
            return f'no contact surfaces: nobody serves {self._server}/{_NAME}'
        self._next = now + _ANSWER_PATIENCE

        def take(done: Future) -> None:
            with self._lock:
                self._answer, self._heard = done.result(), time.monotonic()
            self._next = time.monotonic() + _ASK_PERIOD
            self._changed()

        future = self._services.send(_NAME, polygons=True, with_fallback=True)
        future.add_done_callback(take)
        return ''


def _nothing(why: str) -> ShownContacts:
    return ShownContacts(Patches.none(), [], [why])


def _of_message(message: Any, names: Mapping[int, str]) -> ShownContacts:
    """Return the surfaces of a ContactSurfaces message with polygons."""
    ids = message.point_pair_id_a, message.point_pair_id_b
    left = Left(0)
    if len(ids[0]):
        first, second = (names.get(int(id[0]), f'#{int(id[0])}') for id in ids)
        left = Left(len(ids[0]), (first, second), int(message.point_pair_reason[0]))
    patches = Patches.of_polygons(
        np.asarray(message.p_wv).reshape(-1, 3),
        np.asarray(message.pressure),
        np.asarray(message.polygon_ends).astype(np.int64),
    )
    return ShownContacts.of(patches, int(message.participants), len(message.id_a), left)
