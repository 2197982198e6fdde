"""Child process that may be lost: a question that crashes or hangs it costs only its answer.

It isolates third-party libraries from this process and from each other.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

START_LIMIT = 60.0  # [s] of wall time to start, and to import libraries
PATIENCE = 20.0  # wall time as a multiple of the limit, for a process that waits
ENDS = ANSWER, EXCEPTION, CRASH, HANG = 'answer', 'exception', 'crash', 'hang'


class QuestionOutcome(NamedTuple):
    """End of a question, one of ENDS, with its value or error."""

    end: str
    value: Any

    @property
    def is_lost(self) -> bool:
        """True if the process did not survive the question."""
        return self.end in (CRASH, HANG)


class LostProcess:
    """Child process that starts at its first question, and again after it was lost.

    ``make`` is called in the process, and returns the function that answers questions there. The
    process is forked from this one, with all imports, at almost no cost. With the module
    ``clean`` it is forked from a process that has imported only this module, and ``make`` must be
    picklable.
    """

    def __init__(self, make: Callable[[], Callable[..., Any]], clean: str = '') -> None:
        self._make = make
        self._context: Any = multiprocessing.get_context('forkserver' if clean else 'fork')
        self._process: Any = None
        if clean:
            self._context.set_forkserver_preload([clean])

    @property
    def is_running(self) -> bool:
        """True if the process was started and not lost since."""
        return self._process is not None

    def ask(self, limit: float, *question: Any) -> QuestionOutcome:
        """Return the outcome of a question; after ``limit`` [s] it counts as a hang.

        The limit is in processor time, so that a busy machine causes no hangs.
        """
        try:
            if self._process is None:
                self._start()
            self._connection.send((limit, question))
            if self._connection.poll(PATIENCE * limit):
                outcome: QuestionOutcome = self._connection.recv()
                return outcome
            outcome = QuestionOutcome(HANG, f'{limit:g} s')
        except (EOFError, OSError):
            self._process.join()
            signalled = -(self._process.exitcode or 0)
            outcome = QuestionOutcome(CRASH, f'signal {signalled}')
            if signalled == signal.SIGPROF:
                outcome = QuestionOutcome(HANG, f'{limit:g} s')
        self.close()
        return outcome

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._connection.close()
            self._process = None

    def _start(self) -> None:
        self._connection, child_end = self._context.Pipe()
        # A forked process also has a copy of this end, and would never see it closed.
        forked = self._context.get_start_method() == 'fork'
        copied = self._connection if forked else None
        self._process = self._context.Process(
            target=_serve, args=(child_end, copied, self._make), daemon=True
        )
        self._process.start()
        child_end.close()
        if not self._connection.poll(START_LIMIT):
            self._process.kill()
            raise EOFError
        self._connection.recv()


def outcomes(
    questions: Iterable[Any], ask: Callable[[Any], Any], limit: float
) -> Iterator[tuple[Any, QuestionOutcome]]:
    """Yield each question with its outcome, from processes forked from this one."""
    process = LostProcess(lambda: ask)
    try:
        for question in questions:
            yield question, process.ask(limit, question)
    finally:
        process.close()


def _serve(
    connection: Connection, copied: Connection | None, make: Callable[[], Callable[..., Any]]
) -> None:
    """Answer questions until the other end of the pipe is closed."""
    if copied is not None:
        copied.close()
    # Messages of a dying library must not mix with this program's output; core files are useless.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # The timer's signal ends the process even within a loop in C++.
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    ask = make()
    connection.send('ready')
    while True:
        try:
            limit, question = connection.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, limit)
        try:
            outcome = QuestionOutcome(ANSWER, ask(*question))
        except Exception as error:  # libraries raise any kind for numbers that they refuse
            outcome = QuestionOutcome(EXCEPTION, error)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        try:
            connection.send(outcome)
        except Exception:  # an error that cannot be pickled
            connection.send(QuestionOutcome(EXCEPTION, RuntimeError(str(outcome.value))))
