"""A process that may be lost: what kills or hangs it over one question costs one answer.

What a library of others does to its process, it does to no other; nor do libraries meet.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

START_LIMIT = 60.0  # [s] by the clock to start, and to import libraries
PATIENCE = 20.0  # times the limit by the clock: for what waits and does not compute
ENDS = ANSWER, EXCEPTION, CRASH, HANG = 'answer', 'exception', 'crash', 'hang'


class Outcome(NamedTuple):
    """How a question ended, one of ENDS, and with what."""

    end: str
    value: Any

    @property
    def is_lost(self) -> bool:
        """Whether the process did not survive it."""
        return self.end in (CRASH, HANG)


class LostProcess:
    """Started when it is first asked, and again when it was lost.

    ``make`` is called in the process, and returns what answers questions there. The process is
    forked from this one, has all its imports and costs next to nothing; or, with the module
    ``clean``, from one that has imported nothing else, and ``make`` must be fit to be pickled.
    """

    def __init__(self, make: Callable[[], Callable[..., Any]], clean: str = '') -> None:
        self._make = make
        self._context: Any = multiprocessing.get_context('forkserver' if clean else 'fork')
        self._process: Any = None
        if clean:
            self._context.set_forkserver_preload([clean])

    @property
    def is_running(self) -> bool:
        """Whether it has been asked and has not been lost since."""
        return self._process is not None

    def ask(self, limit: float, *question: Any) -> Outcome:
        """Return the outcome of a question; one that takes longer than ``limit`` [s] hangs.

        The limit is of processor time, so that a busy machine hangs nobody.
        """
        try:
            if self._process is None:
                self._start()
            self._connection.send((limit, question))
            if self._connection.poll(PATIENCE * limit):
                outcome: Outcome = self._connection.recv()
                return outcome
            outcome = Outcome(HANG, f'{limit:g} s')
        except (EOFError, OSError):
            self._process.join()
            signalled = -(self._process.exitcode or 0)
            outcome = Outcome(CRASH, f'signal {signalled}')
            if signalled == signal.SIGPROF:
                outcome = Outcome(HANG, f'{limit:g} s')
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
        self._connection, theirs = self._context.Pipe()
        # A forked process has a copy of our end, too, and would never see that we are gone.
        forked = self._context.get_start_method() == 'fork'
        copied = self._connection if forked else None
        self._process = self._context.Process(
            target=_serve, args=(theirs, copied, self._make), daemon=True
        )
        self._process.start()
        theirs.close()
        if not self._connection.poll(START_LIMIT):
            self._process.kill()
            raise EOFError
        self._connection.recv()


def outcomes(
    questions: Iterable[Any], ask: Callable[[Any], Any], limit: float
) -> Iterator[tuple[Any, Outcome]]:
    """Yield each question with its outcome, asked in processes forked from this one."""
    process = LostProcess(lambda: ask)
    try:
        for question in questions:
            yield question, process.ask(limit, question)
    finally:
        process.close()


def _serve(
    connection: Connection, copied: Connection | None, make: Callable[[], Callable[..., Any]]
) -> None:
    """Answer questions until the other side is gone."""
    if copied is not None:
        copied.close()
    # What a library prints while it dies is no output of ours, and nobody reads its core.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # The timer's signal ends the process, in the midst of a loop in C++ too.
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
            outcome = Outcome(ANSWER, ask(*question))
        except Exception as error:  # whatever a library raises for numbers that it does not like
            outcome = Outcome(EXCEPTION, error)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        try:
            connection.send(outcome)
        except Exception:  # an error that cannot be pickled
            connection.send(Outcome(EXCEPTION, RuntimeError(str(outcome.value))))
