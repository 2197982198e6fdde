"""Node's side of the second opinion, which starts, queries and restarts the process."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from multiprocessing import Pipe

from drake_geom_ros.cross_check.question import PairQuestion, QuestionBatch, Verdict, shapes_of
from drake_geom_ros.geometry import QueryObject

NEEDED = {'fcl': 'python-fcl'}  # module name: package name

_LOOKS = 0.1  # [s] between two checks whether the node ends
# A question that hangs is abandoned after 40 s (LostProcess), so a batch that takes longer than
# this [s] means that the process hangs.
_PATIENCE = 1000.0
_PAUSE = 10.0  # [s] before a lost process is restarted


def missing() -> list[str]:
    """Return the required packages that are not installed."""
    return [name for module, name in NEEDED.items() if find_spec(module) is None]


class Asker:
    """Blocking client of the process ``python -m drake_geom_ros.cross_check``, for one thread."""

    def __init__(self, stopping: Callable[[], bool]) -> None:
        """Stop waiting for verdicts when ``stopping()`` is true."""
        self._stopping = stopping
        self._process: subprocess.Popen[bytes] | None = None
        self._version = -1
        self._sent: set[int] = set()  # ids whose shapes the process has
        self._not_before = 0.0  # [s] of the steady clock, of the next start
        self.lost = 0  # number of processes that ended by themselves or had to be ended

    def ask(
        self, query: QueryObject, version: int, questions: list[PairQuestion]
    ) -> list[Verdict] | None:
        """Return the verdicts on questions about a version of a scene; None if there are none.

        ``query`` has the shapes. A lost process is restarted after a pause.
        """
        if self._process is None and time.monotonic() < self._not_before:
            return None
        try:
            if self._process is None:
                self._start()
            if version != self._version:
                self._version, self._sent = version, set()
            ids = {value for question in questions for value in question.ids} - self._sent
            self._connection.send(QuestionBatch(version, questions, shapes_of(query, ids)))
            self._sent |= ids
            return self._received()
        except (EOFError, OSError):
            self.lost += 1
            self._not_before = time.monotonic() + _PAUSE
            self.close()
            return None

    def _start(self) -> None:
        self._connection, child_end = Pipe()
        with child_end:
            descriptor = child_end.fileno()
            self._process = subprocess.Popen(
                [sys.executable, '-m', 'drake_geom_ros.cross_check', str(descriptor)],
                pass_fds=[descriptor],
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # a terminal's signals to the node must not reach it
            )
        self._version = -1

    def _received(self) -> list[Verdict] | None:
        """Wait for the verdicts; None if the node ends. Raises OSError if none arrive."""
        end = time.monotonic() + _PATIENCE
        while not self._stopping():
            if self._connection.poll(_LOOKS):
                verdicts: list[Verdict] = self._connection.recv()
                return verdicts
            # Its own children may still hold its end of the pipe, so its exit is checked.
            if self._process is None or self._process.poll() is not None:
                raise EOFError
            if time.monotonic() > end:
                raise TimeoutError
        return None

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._connection.close()
            self._process = None
