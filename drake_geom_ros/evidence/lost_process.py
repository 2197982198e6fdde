"""Questions asked in processes that may be lost: what kills or hangs one costs one answer."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

PATIENCE = 20.0  # times the limit by the clock: for what waits and does not compute


class Outcome(NamedTuple):
    """How a question ended: ``answer``, ``exception``, ``crash`` or ``hang``, and with what."""

    end: str
    value: Any


def outcomes(
    questions: list[Any], ask: Callable[[Any], Any], limit: float
) -> Iterator[tuple[Any, Outcome]]:
    """Yield each question with its outcome; one that takes longer than ``limit`` [s] hangs.

    The limit is of processor time, so that a busy machine hangs nobody. The questions go to a
    forked process in turn. When it is lost, a new one goes on after the question that was under
    way; a fork has all imports, and costs next to nothing.
    """
    context = multiprocessing.get_context('fork')
    done = 0
    while done < len(questions):
        receive, send = context.Pipe(duplex=False)
        process = context.Process(target=_answer_all, args=(questions[done:], ask, send, limit))
        process.start()
        send.close()
        while done < len(questions):
            outcome = _next(receive, PATIENCE * limit)
            if outcome is None:
                process.join()
                signalled = -(process.exitcode or 0)
                hung = signalled == signal.SIGPROF
                outcome = Outcome('hang', f'{limit:g} s') if hung else None
                outcome = outcome or Outcome('crash', f'signal {signalled}')
            lost = outcome.end in ('crash', 'hang')
            yield questions[done], outcome
            done += 1
            if lost:
                break
        process.kill()
        process.join()
        receive.close()


def _next(receive: Connection, limit: float) -> Outcome | None:
    """Return the next outcome; None when the process has ended without one."""
    if not receive.poll(limit):
        return Outcome('hang', f'{limit:g} s')
    try:
        outcome: Outcome = receive.recv()
        return outcome
    except EOFError:
        return None


def _answer_all(
    questions: list[Any], ask: Callable[[Any], Any], send: Connection, limit: float
) -> None:
    # What libraries print when they abort is not ours to show.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    # The timer's signal ends the process, in the midst of a loop in C++ too.
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    for question in questions:
        signal.setitimer(signal.ITIMER_PROF, limit)
        try:
            outcome = Outcome('answer', ask(question))
        except Exception as error:
            outcome = Outcome('exception', error)
        try:
            send.send(outcome)
        except Exception:  # an error that cannot be pickled
            send.send(Outcome('exception', RuntimeError(str(outcome.value))))
