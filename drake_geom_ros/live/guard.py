"""Stands between a node's callbacks and the executor: what fails is counted and logged.

An exception that reached the executor would end the node, and with it the service that others rely
on.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.live.conversions.misread_numbers import refuse_misread_numbers

_LOG_PERIOD = 5.0  # [s] at most one line about the same thing in this time
_MOST_REASONS = 5  # of one input in this time
_SPECIFIC = re.compile(r"'[^']*'|[0-9]+")  # what differs in messages of one kind
_MOST_TOLD_ONCE = 1000  # things that are remembered, for their names may be ever new
_LONGEST_MESSAGE = 1500  # what is quoted in it may be a name of a megabyte


class Guard:
    """Calls what takes messages, answers requests and is due by a timer; from any thread."""

    def __init__(self, logger: Any, count: Callable[[str, str, int], None]) -> None:
        """``count(name, reason, n)`` is called for messages and tasks that failed."""
        self._logger = logger
        self._count = count
        # Of each input, until when [s] which kinds of reasons are told.
        self._reasons: dict[str, dict[str, float]] = {}
        self._silent_until: dict[str, float] = {}  # of the steady clock [s], by what is told of

    def succeeds(self, task: Callable[[], object]) -> bool:
        """Do something that may well be refused; return whether it was done, and log if not."""
        error = _failure_of(task)
        if error is not None:
            self._logger.error(f'not {_name_of(task)}: {str(error) or repr(error)}')
        return error is None

    def take(self, name: str, take: Callable[..., object], *message: Any) -> None:
        """Take a message of the input ``name``; an exception is a refusal of it."""
        error = _failure_of(_take_checked, take, *message)
        if error is not None:
            # RuntimeError is what those raise who refuse; nobody foresaw the others.
            refusal = isinstance(error, RuntimeError)
            self.refused(name, str(error) if refusal else f'internal error: {error!r}')

    def refused(self, name: str, reason: str) -> None:
        """Count and log that a message was refused."""
        self._count(name, reason, 1)
        if self._may_tell_reason(name, reason):
            self._logger.warning(f'a message of {name} was refused: {_shortened(reason)}')

    def refuse(self, name: str, reason: str, count: int) -> None:
        """Count and log parts of a message that were refused while the others were taken."""
        self._count(name, reason, count)
        if self._may_tell_reason(name, reason):
            self._logger.warning(f'of a message of {name}: {_shortened(reason)}')

    def attempt(self, task: Callable[[], object]) -> None:
        """Do what is due; nobody foresaw an exception."""
        error = _failure_of(task)
        if error is not None:
            self.failed(_name_of(task), error)

    def failed(self, name: str, error: Exception) -> None:
        """Count and log an exception that nobody foresaw."""
        self._count(name, f'internal error: {error!r}', 1)
        if self._may_tell(name):
            self._logger.error(f'internal error in {name}: {_shortened(repr(error))}')

    def tell(self, about: str, what: str, *, once: bool = False) -> None:
        """Warn of something that is no failure, now and then if it comes again and again."""
        if self._may_tell(about):
            self._logger.warning(what)
        if once and len(self._silent_until) < _MOST_TOLD_ONCE:
            self._silent_until[about] = math.inf

    def answer(
        self, handler: Callable[[Any, Any, Any], None], scene: Any, request: Any, response: Any
    ) -> Any:
        """Have a handler answer a request, and say in the response whether it did."""
        error = _failure_of(_answer_checked, handler, scene, request, response)
        response.success = error is None
        if isinstance(error, RuntimeError):
            response.message = _shortened(str(error))
        elif isinstance(error, MemoryError):
            response.message = f'the process has too little memory left: ask for less ({error})'
        elif error is not None:
            response.message = f'internal error: {_shortened(repr(error))}'
            name = type(request).__name__
            if self._may_tell(name):
                self._logger.error(f'{name}: {response.message}')
        return response

    def _may_tell_reason(self, name: str, reason: str) -> bool:
        """Return whether to log a reason for refusals: each reason of an input once in a while.

        One that comes again and again must not hide another. Names and numbers in it make no
        other reason, and of ever new ones a few are logged.
        """
        now, kind = time.monotonic(), _SPECIFIC.sub('', reason[:_LONGEST_MESSAGE])
        ends = self._reasons.setdefault(name, {})
        for past in [past for past, end in ends.items() if end <= now]:
            del ends[past]
        if kind in ends or len(ends) >= _MOST_REASONS:
            return False
        ends[kind] = now + _LOG_PERIOD
        return True

    def _may_tell(self, about: str) -> bool:
        """Return whether nothing was logged about something for a while.

        (rclpy throttles by line of code, where one thing would silence another.)
        """
        now = time.monotonic()
        may = now >= self._silent_until.get(about, now)
        if may:
            self._silent_until[about] = now + _LOG_PERIOD
        return may


def _take_checked(take: Callable[..., object], *message: Any) -> None:
    if message:
        refuse_misread_numbers(message[0])
    take(*message)


def _answer_checked(
    handler: Callable[[Any, Any, Any], None], scene: Any, request: Any, response: Any
) -> None:
    refuse_misread_numbers(request)
    handler(scene, request, response)


def _failure_of(task: Callable[..., object], *arguments: Any) -> Exception | None:
    """Do something, and return the exception that it raised instead of raising it."""
    try:
        task(*arguments)
    except Exception as error:
        return error
    return None


def _name_of(task: Callable[..., object]) -> str:
    return task.__name__.lstrip('_')


def _shortened(text: str) -> str:
    """Return a message without its middle where it is too long to be read.

    A NUL is shown: it would end the string of a message, and the reason with it.
    """
    text = text.replace('\0', '\\0')
    half = _LONGEST_MESSAGE // 2
    return text if len(text) <= _LONGEST_MESSAGE else f'{text[:half]} ... {text[-half:]}'
