"""Contact surfaces that take long: computed beside the cycles, without the lock of the scene."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from drake_geom_ros.geometry import PenetrationResults
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.live.scene.scene_view import SceneStamp, SceneView
from drake_geom_ros.live.scene.waiting import Waiting


@dataclass(frozen=True)
class ContactRequest:
    """The moment of a cycle whose surfaces are wanted."""

    view: SceneView
    moment: SceneStamp
    waiting: Waiting
    overlaps: PenetrationResults
    time_budget: float  # [s]; 0: none
    began: float  # [s] of time.monotonic(), when the cycle asked


class LongContacts:
    """Computes surfaces in a thread of its own, which begins with the first that take long.

    Of the moments that come while it computes it takes the newest one.
    """

    def __init__(
        self,
        prepare: Callable[[ContactRequest, Contacts, float], Callable[[], None]],
        must_stop: Callable[[], bool],
        failed: Callable[[Exception], None],
    ) -> None:
        """``prepare`` takes the request, the answer, and what it took [s], in the thread.

        It returns a function that publishes the answer. Nothing is computed or published while
        ``must_stop()``. ``failed`` takes what nobody foresaw.
        """
        self._prepare, self._stops, self._failed = prepare, must_stop, failed
        self._changed = threading.Condition()
        self._publishing = threading.Lock()
        self._next: ContactRequest | None = None
        self._is_busy = self._is_unwanted = self._is_closed = False
        self._thread: threading.Thread | None = None

    @property
    def is_busy(self) -> bool:
        """True if a moment is computed, or waits."""
        with self._changed:
            return self._is_busy or self._next is not None

    def ask(self, request: ContactRequest) -> None:
        """Compute the surfaces of a moment next, instead of one that waits."""
        with self._changed:
            self._next = request
            if self._thread is None and not self._is_closed:
                self._thread = threading.Thread(
                    target=self._serve, name='contact surfaces', daemon=True
                )
                self._thread.start()
            self._changed.notify()

    def forget(self) -> None:
        """Publish nothing of earlier requests: what is being published is out on return."""
        with self._changed:
            self._next, self._is_unwanted = None, self._is_busy
        with self._publishing:
            pass

    def close(self) -> None:
        """End the thread, after the block of work that it is in."""
        with self._changed:
            self._is_closed, self._next = True, None
            self._changed.notify()
            thread = self._thread
        if thread is not None:
            thread.join()

    def _must_stop(self) -> bool:
        return self._is_closed or self._is_unwanted or self._stops()

    def _serve(self) -> None:
        while (request := self._next_request()) is not None:
            try:
                self._answer(request)
            except Exception as error:  # nobody foresaw it, and the thread goes on
                self._failed(error)

    def _next_request(self) -> ContactRequest | None:
        """Wait for a moment and return it; None once this is closed."""
        with self._changed:
            self._is_busy = self._is_unwanted = False
            self._changed.wait_for(lambda: self._is_closed or self._next is not None)
            request, self._next = self._next, None
            self._is_busy = request is not None
            return request

    def _answer(self, request: ContactRequest) -> None:
        start = time.perf_counter()
        contacts = request.view.query.contacts(
            overlaps=request.overlaps, time_budget=request.time_budget, must_stop=self._must_stop
        )
        if self._must_stop():
            return
        publish = self._prepare(request, contacts, time.perf_counter() - start)
        with self._publishing:  # the last look and what follows it, without a ``forget`` between
            if not self._must_stop():
                publish()
