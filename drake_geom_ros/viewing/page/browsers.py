"""Browsers of a page: each has a web socket that gets sections of the board and gives commands."""

from __future__ import annotations

import asyncio
import contextlib
import json
import secrets
from collections.abc import Callable
from typing import Any

from drake_geom_ros.viewing.page.board import Board, finite
from drake_geom_ros.viewing.page.options import CommandError

# Carries out a command of the browser with a key; returns sections for that browser only.
Execute = Callable[[str, dict[str, Any]], dict[str, Any]]

_KEY_BYTES = 8
_MOST_LETTERS = 100_000  # of a command


class Browsers:
    """The open web sockets of a page, all in the event loop of its server."""

    def __init__(self, board: Board, execute: Execute) -> None:
        """Send sections of ``board``; ``execute`` is called in threads of their own."""
        self._board, self._execute = board, execute
        self._connections: dict[str, Any] = {}
        self._loop: asyncio.AbstractEventLoop | None = None

    async def serve(self, connection: Any) -> None:
        """Serve a browser until it leaves."""
        import websockets

        self._loop = asyncio.get_running_loop()
        key = secrets.token_hex(_KEY_BYTES)
        self._connections[key] = connection
        news = asyncio.Event()
        news.set()

        def changed(loop: asyncio.AbstractEventLoop = self._loop) -> None:
            with contextlib.suppress(RuntimeError):  # the loop is closed: the page ends
                loop.call_soon_threadsafe(news.set)

        self._board.watch(changed)
        sending = None
        try:
            await connection.send(_section('hello', {'key': key}))
            sending = asyncio.create_task(self._send(connection, news))
            async for message in connection:
                await self._obey(connection, key, message)
        except websockets.exceptions.ConnectionClosed:
            pass
        finally:
            self._board.leave(changed)
            del self._connections[key]
            if sending is not None:
                sending.cancel()

    def send_to(self, key: str, section: str, value: Any) -> None:
        """Send a section to one browser, from any thread; nothing if it has left."""
        connection, loop = self._connections.get(key), self._loop
        if connection is not None and loop is not None:
            asyncio.run_coroutine_threadsafe(_sent(connection, _section(section, value)), loop)

    async def _send(self, connection: Any, news: asyncio.Event) -> None:
        """Send what changes; of a section that changes faster than it is sent, the newest."""
        import websockets

        serial = 0
        with contextlib.suppress(websockets.exceptions.ConnectionClosed):
            while True:
                await news.wait()
                news.clear()
                serial, texts = self._board.newer_than(serial)
                for text in texts:
                    await connection.send(text)

    async def _obey(self, connection: Any, key: str, message: str | bytes) -> None:
        try:
            command = read_command(message)
            replies = await asyncio.to_thread(self._execute, key, command)
        except CommandError as error:
            replies = {'error': str(error)}
        for section, value in replies.items():
            await connection.send(_section(section, value))


def read_command(message: str | bytes) -> dict[str, Any]:
    """Return the command of a message: an object with its name under ``do``."""
    if not isinstance(message, str) or len(message) > _MOST_LETTERS:
        raise CommandError(f'a command is a text of at most {_MOST_LETTERS} letters')
    try:
        command = json.loads(message)
    except (ValueError, RecursionError) as error:
        raise CommandError(f'a command is JSON: {error}') from None
    if not isinstance(command, dict) or not isinstance(command.get('do'), str):
        raise CommandError('a command is an object with its name under "do"')
    return command


async def _sent(connection: Any, text: str) -> None:
    import websockets

    with contextlib.suppress(websockets.exceptions.ConnectionClosed):
        await connection.send(text)


def _section(section: str, value: Any) -> str:
    return json.dumps({'section': section, 'value': finite(value)})
