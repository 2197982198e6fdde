"""Access check of each request, for the page and for its web socket.

A browser lets any web page open a socket to this machine, and a page whose host name suddenly
resolves to this machine (DNS rebinding) read its responses. Such requests have another Host or
Origin. A page that is served beyond this machine also requires a token in the path: viser's page
opens its socket at the path that it was loaded from.
"""

from __future__ import annotations

import dataclasses
import http
import ipaddress
import secrets
import socket
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import urlsplit

Process = Callable[[Any, Any], Any]  # (connection, request) -> response, or None to go on

_THIS_MACHINE = ('localhost', '127.0.0.1', '[::1]')
_EVERYWHERE = ('', '0.0.0.0', '::')
_HTTP_PORT = 80  # which browsers do not name
_TOKEN_BYTES = 16


class RequestGuard:
    """Responds 403 to requests that do not come from the page itself at its own address."""

    def __init__(self, host: str, frames: Sequence[str] = ()) -> None:
        """Guard a server that listens at ``host``; beyond this machine with a token.

        Pages of the origins ``frames``, such as ``http://localhost:*``, may embed this one, which
        has a token then, too. Without them only this page itself may, which embeds viser's.
        """
        self._host = host.lower()
        needs_token = bool(frames) or not is_local(host)
        self.token = secrets.token_urlsafe(_TOKEN_BYTES) if needs_token else ''
        # Links do not leak the token.
        self._headers = {
            'Referrer-Policy': 'no-referrer',
            'Content-Security-Policy': ' '.join(("frame-ancestors 'self'", *frames)),
        }
        self._own = {*_THIS_MACHINE, _bracketed(self._host)}
        if not is_local(host):
            self._own.add(socket.gethostname().lower())

    def url(self, port: int) -> str:
        """Return the address to open, which grants access."""
        shown = socket.gethostname() if self._host in _EVERYWHERE else _bracketed(self._host)
        return f'http://{shown}:{port}' + (f'/{self.token}/' if self.token else '')

    def guarded(self, process: Process | None) -> Process:
        """Return a request handler that checks a request before ``process`` handles it."""

        def look(connection: Any, request: Any) -> Any:
            port = connection.local_address[1]
            hosts, origins = map(request.headers.get_all, ('Host', 'Origin'))
            if reason := self._refusal(port, hosts, origins):
                return connection.respond(http.HTTPStatus.FORBIDDEN, f'{reason}\n')
            path = self.path_of(request.path)
            if path is None:
                return connection.respond(
                    http.HTTPStatus.FORBIDDEN,
                    'the address lacks its token: open the one that was printed, whole\n',
                )
            response = process and process(connection, dataclasses.replace(request, path=path))
            if response is not None:
                response.headers.update(self._headers)
            return response

        return look

    def _refusal(self, port: int, hosts: Sequence[str], origins: Sequence[str]) -> str:
        """Return why a request cannot come from the page itself; empty if it can."""
        if len(hosts) != 1 or not self._is_own(hosts[0].lower(), port):
            return (
                f'Host {", ".join(hosts) or "(none)"}: this page answers as localhost:{port}, or '
                'by the address that was printed; through a tunnel, from the same port'
            )
        for origin in origins:
            url = urlsplit(origin.lower())
            if url.scheme != 'http' or url.netloc != hosts[0].lower():
                return f'Origin {origin}: only the page itself, http://{hosts[0]}, is answered'
        return ''

    def _is_own(self, host: str, port: int) -> bool:
        """Return whether a Host header names this server.

        Beyond this machine any numeric address does, since rebinding needs a name.
        """
        name, colon, digits = host.rpartition(':')
        if not colon or host.endswith(']'):
            name, digits = host, str(_HTTP_PORT)
        if digits != str(port):
            return False
        return name in self._own or (bool(self.token) and _is_number(name))

    def path_of(self, path: str) -> str | None:
        """Return a path without the token, or None if it lacks the token."""
        if not self.token:
            return path
        first, _, rest = path.removeprefix('/').partition('/')
        first, mark, query = first.partition('?')
        if not secrets.compare_digest(first.encode(), self.token.encode()):
            return None
        return f'/{rest}{mark}{query}'


def is_local(host: str) -> bool:
    """Return whether an address is reachable from this machine only."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def _bracketed(host: str) -> str:
    return f'[{host}]' if ':' in host else host


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name.removeprefix('[').removesuffix(']'))
    except ValueError:
        return False
    return True
