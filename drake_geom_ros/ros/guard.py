"""Stands between a node's callbacks and the executor: what fails is counted and logged.

An exception that reached the executor would end the node, and with it the service that others rely
on.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.ros.outputs.diagnostics import Diagnostics
from drake_geom_ros.ros.services.table import shortened

_LOG_PERIOD = 5.0  # [s] at most one line about the same thing in this time


class Guard:
    """Calls what takes messages, answers requests and is due by a timer; from any thread."""

    def __init__(self, logger: Any, diagnostics: Diagnostics) -> None:
        self._logger = logger
        self._diagnostics = diagnostics
        self._silent_until: dict[str, float] = {}  # of the steady clock [s], by what is told of

    def take(self, name: str, take: Callable[..., Any], *message: Any) -> None:
        """Take a message of the input ``name``; an exception is a refusal of it."""
        try:
            take(*message)
        except Exception as error:
            # RuntimeError is what those raise who refuse; nobody foresaw the others.
            reason = (
                str(error) if isinstance(error, RuntimeError) else f'internal error: {error!r}'
            )
            self._diagnostics.refuse(name, reason)
            if self._may_tell(name):
                self._logger.warning(f'a message of {name} was refused: {shortened(reason)}')

    def attempt(self, task: Callable[[], None]) -> None:
        """Do what is due; nobody foresaw an exception."""
        try:
            task()
        except Exception as error:
            name = task.__name__.lstrip('_')
            self._diagnostics.refuse(name, f'internal error: {error!r}')
            if self._may_tell(name):
                self._logger.error(f'internal error in {name}: {shortened(repr(error))}')

    def answer(self, answer: Callable[[Any, Any], Any], request: Any, response: Any) -> Any:
        """Answer a request; what ``answer`` itself does not refuse nobody foresaw."""
        try:
            answer(request, response)
        except Exception as error:
            text = f'internal error: {shortened(repr(error))}'
            response.success, response.message = False, text
            name = type(request).__name__
            if self._may_tell(name):
                self._logger.error(f'{name}: {text}')
        return response

    def _may_tell(self, about: str) -> bool:
        """Return whether nothing was told about something for a while.

        (rclpy throttles by line of code, where one thing would silence another.)
        """
        now = time.monotonic()
        may = now >= self._silent_until.get(about, now)
        if may:
            self._silent_until[about] = now + _LOG_PERIOD
        return may
