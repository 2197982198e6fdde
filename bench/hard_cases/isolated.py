"""Questions asked in processes that may be lost: what kills or hangs one costs one answer."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any, NamedTuple


class Outcome(NamedTuple):
    """How a question ended: ``answer``, ``exception``, ``crash`` or ``hang``, and with what."""

    end: str
    value: Any


def outcomes(
    questions: list[Any], ask: Callable[[Any], Any], limit: float
) -> Iterator[tuple[Any, Outcome]]:
    """Yield each question with its outcome; one that takes longer than ``limit`` [s] hangs.

    The questions go to a forked process in turn. When it is lost, a new one goes on after the
    question that was under way; a fork has all imports, and costs next to nothing.
    """
    context = multiprocessing.get_context('fork')
    done = 0
    while done < len(questions):
        receive, send = context.Pipe(duplex=False)
        process = context.Process(target=_answer_all, args=(questions[done:], ask, send))
        process.start()
        send.close()
        while done < len(questions):
            outcome = _next(receive, limit)
            if outcome is None:
                process.join()
                outcome = Outcome('crash', f'signal {-(process.exitcode or 0)}')
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


def _answer_all(questions: list[Any], ask: Callable[[Any], Any], send: Connection) -> None:
    # What libraries print when they abort is not ours to show.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    for question in questions:
        try:
            outcome = Outcome('answer', ask(question))
        except Exception as error:
            outcome = Outcome('exception', error)
        try:
            send.send(outcome)
        except Exception:  # an error that cannot be pickled
            send.send(Outcome('exception', RuntimeError(str(outcome.value))))
