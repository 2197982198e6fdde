"""The node's side of the second opinion: a process that is started, asked, and started again."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from multiprocessing import Pipe

from drake_geom_ros.cross_check.question import PairQuestion, QuestionBatch, Verdict, shapes_of
from drake_geom_ros.geometry import QueryObject

NEEDED = {'fcl': 'python-fcl'}  # what is imported: what is installed

_LOOKS = 0.1  # [s] between two looks whether the node ends
# A question that hangs is given up after 40 s (LostProcess); a batch of them that takes longer
# than this [s] does so because its process hangs.
_PATIENCE = 1000.0
_PAUSE = 10.0  # [s] before a process that ended by itself is started again


def missing() -> list[str]:
    """Return the packages that have to be installed before anybody can be asked."""
    return [name for module, name in NEEDED.items() if find_spec(module) is None]


class Asker:
    """Asks ``python -m drake_geom_ros.cross_check``; for one thread, which it may keep waiting."""

    def __init__(self, stopping: Callable[[], bool]) -> None:
        """Wait for answers no longer than until ``stopping()``."""
        self._stopping = stopping
        self._process: subprocess.Popen[bytes] | None = None
        self._version = -1
        self._sent: set[int] = set()  # whose shapes the process has
        self._not_before = 0.0  # [s] of the steady clock
        self.lost = 0  # processes that ended by themselves or had to be ended

    def ask(
        self, query: QueryObject, version: int, questions: list[PairQuestion]
    ) -> list[Verdict] | None:
        """Return the verdicts on questions about a version of a scene; None where there are none.

        ``query`` knows the shapes. A process that was lost is started again, not at once.
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
        self._connection, theirs = Pipe()
        with theirs:
            descriptor = theirs.fileno()
            self._process = subprocess.Popen(
                [sys.executable, '-m', 'drake_geom_ros.cross_check', str(descriptor)],
                pass_fds=[descriptor],
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # what a terminal sends to the node is not for it
            )
        self._version = -1

    def _received(self) -> list[Verdict] | None:
        """Wait for the verdicts; None when the node ends. Raises OSError when they do not come."""
        end = time.monotonic() + _PATIENCE
        while not self._stopping():
            if self._connection.poll(_LOOKS):
                verdicts: list[Verdict] = self._connection.recv()
                return verdicts
            # What it has started may have its end of the pipe, and be at work still.
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
