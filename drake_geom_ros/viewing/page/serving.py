"""Server of a page; viser is imported only when a page is opened."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import http.client
import socket
import threading
from collections.abc import Awaitable, Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.viewing.page.cameras import BROWSER
from drake_geom_ros.viewing.page.request_guard import Process, RequestGuard, is_local

_FOLDER = Path(__file__).parent / 'static'
_STYLES = ('page.css',)
_SCRIPTS = ('elements.js', 'link.js', 'pairs.js', 'panels.js', 'timeline.js', 'page.js')
PICTURE = '/3d/'  # the path of viser's page, followed by the key of the browser that shows it
SOCKET = '/link'  # the path of the web socket of the document
Handler = Callable[[Any], Awaitable[None]]

LOCALHOST = '127.0.0.1'
PORT = 8080

_SELF = {'': LOCALHOST, '0.0.0.0': LOCALHOST, '::': '::1'}  # address of this server by host
_STRANGER = 'stranger.invalid'  # a reserved name that cannot exist
_PATIENCE = 10.0  # [s] for a response of this server
_MOST_PORT = 65535
_patching = threading.Lock()


class Served:
    """A viser server behind our document, and the address to open.

    Beyond this machine the address has a token. ``serve`` is called with the web socket of each
    browser that has the document; until it is set, viser's own page is served instead.
    """

    def __init__(self, guard: RequestGuard) -> None:
        self._guard = guard
        self.server: Any = None
        self.serve: Callable[[Any], Awaitable[None]] | None = None

    @property
    def url(self) -> str:
        """The address to open."""
        return self._guard.url(self.server.get_port())

    def answering(self, process: Process | None) -> Process:
        """Return the handler of requests: our document, and viser's page below its path."""

        def answer(connection: Any, request: Any) -> Any:
            path = urlsplit(request.path).path
            is_socket = request.headers.get('Upgrade', '').lower() == 'websocket'
            if self.serve is not None and path == '/' and not is_socket:
                response = connection.respond(http.HTTPStatus.OK, '')
                response.body = document()
                for name in ('Content-Length', 'Content-Type'):
                    del response.headers[name]
                response.headers['Content-Length'] = str(len(response.body))
                response.headers['Content-Type'] = 'text/html; charset=utf-8'
                return response
            if path.startswith(PICTURE) and not is_socket:
                request = dataclasses.replace(request, path='/')
            return process and process(connection, request)

        return self._guard.guarded(answer)

    def handling(self, handler: Handler) -> Handler:
        """Return the handler of web sockets: our document's, and viser's with their browser."""

        async def handle(connection: Any) -> None:
            path = urlsplit(self._guard.path_of(connection.request.path) or '').path
            if path == SOCKET:
                if self.serve is not None:
                    await self.serve(connection)
                return
            BROWSER.set(path.removeprefix(PICTURE).strip('/'))
            await handler(connection)

        return handle


def open_server(host: str = LOCALHOST, port: int = PORT, *, frames: Sequence[str] = ()) -> Served:
    """Return a viser server at the port, or at the next free one if that is taken.

    It responds only to its own page, and beyond this machine only with the token. Pages of the
    origins ``frames`` may show it in a frame, with the token. Raises GeometryError if viser is not
    installed, or the address cannot be opened.
    """
    try:
        import viser
        import websockets.asyncio.server as sockets
    except ImportError as error:
        raise GeometryError(
            f'the page takes viser, which cannot be imported ({error}): pip install viser, or '
            "this package with its extra 'view'"
        ) from None
    guard = RequestGuard(host, frames)
    served = Served(guard)
    try:
        _check_address(host, port)
        with _every_server_behind(served, sockets):
            server = viser.ViserServer(host=host, port=port, label='drake_geom_ros', verbose=False)
    except (OSError, RuntimeError) as error:
        raise GeometryError(f'no page can be opened at {host}:{port}: {error}') from None
    # Any user of the page could request sharing, which uses a third party's relay.
    server.request_share_url = lambda verbose=True: None
    try:
        refused = _refuses_strangers(host, server.get_port())
    except OSError:
        refused = False
    if not refused:
        server.stop()
        raise GeometryError(
            f'the page at {host}:{port} would answer any web page in a browser of this machine: '
            'this version of viser makes its server otherwise than 1.1 does; pip install '
            'viser==1.1.1'
        )
    served.server = server
    return served


def warning(host: str) -> str:
    """Return a warning about serving a page at an address; empty for this machine only."""
    if is_local(host):
        return ''
    return (
        f'whoever reaches {host} and has the address with its token sees this page and may move '
        'and filter what it shows, and there is no encryption: who listens to the network '
        'reads both. From elsewhere, an SSH tunnel is safer: '
        f'ssh -L {PORT}:{LOCALHOST}:{PORT} THIS_MACHINE'
    )


@contextlib.contextmanager
def _every_server_behind(served: Served, sockets: Any) -> Iterator[None]:
    """Put web socket servers that are made within the context behind our document and guard.

    websockets has ``process_request`` for this, but viser, which makes the server, does not pass
    one on. A proxy would leave viser's own port open to the same pages. Therefore the factory is
    replaced while viser makes its server; a trial request then checks that the guard responds.
    """
    with _patching:
        serve = sockets.serve

        def guarded(
            handler: Any, *arguments: Any, process_request: Any = None, **options: Any
        ) -> Any:
            return serve(
                served.handling(handler),
                *arguments,
                process_request=served.answering(process_request),
                **options,
            )

        sockets.serve = guarded
        try:
            yield
        finally:
            sockets.serve = serve


def _check_address(host: str, port: int) -> None:
    """Raise OSError for an address of another machine, and if no port is free.

    viser would wait for either without end.
    """
    if not 1 <= port <= _MOST_PORT:
        raise OSError(f'a port is a number from 1 to {_MOST_PORT}')
    (family, kind, protocol, _, address), *_ = socket.getaddrinfo(
        host or None, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )
    with socket.socket(family, kind, protocol) as trial:
        trial.bind(address)
    for each in range(port, _MOST_PORT + 1):
        with socket.socket(family, kind, protocol) as trial, contextlib.suppress(OSError):
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((address[0], each, *address[2:]))
            return
    raise OSError(f'no port from {port} to {_MOST_PORT} is free')


def _refuses_strangers(host: str, port: int) -> bool:
    """Return whether the server refuses a request with another Host; raises OSError."""
    connection = http.client.HTTPConnection(_SELF.get(host, host), port, timeout=_PATIENCE)
    try:
        connection.putrequest('GET', '/', skip_host=True)
        connection.putheader('Host', f'{_STRANGER}:{port}')
        connection.endheaders()
        return connection.getresponse().status == http.HTTPStatus.FORBIDDEN
    except http.client.HTTPException:
        return False
    finally:
        connection.close()


@functools.cache
def document() -> bytes:
    """Return the document, one file, so that no address in it depends on a token."""
    template = (_FOLDER / 'page.html').read_text(encoding='utf-8')
    style, script = (
        '\n'.join((_FOLDER / name).read_text(encoding='utf-8') for name in names)
        for names in (_STYLES, _SCRIPTS)
    )
    return template.replace('/* style */', style).replace('/* script */', script).encode()
