"""Whom a page is served to: a check of each request, of the page and of its web socket alike.

A browser lets any web page open a socket to this machine, and a page whose own name is suddenly
that of this machine (DNS rebinding) read what it serves. Such requests name another Host, or come
from another Origin. What is served beyond this machine takes a token, too, as part of the path:
viser's page opens its socket at the path that it was itself loaded from.
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

Process = Callable[[Any, Any], Any]  # of a connection and a request: a response, or None: go on

_THIS_MACHINE = ('localhost', '127.0.0.1', '[::1]')
_EVERYWHERE = ('', '0.0.0.0', '::')
_HTTP_PORT = 80  # which browsers do not name
_TOKEN_BYTES = 16
# Nobody is told the token by a link, and no page of others has this one as a part of its own.
_HEADERS = {'Referrer-Policy': 'no-referrer', 'Content-Security-Policy': "frame-ancestors 'none'"}


class Gate:
    """Answers 403 to what does not come from its own page, opened at the address that was told."""

    def __init__(self, host: str) -> None:
        """Take the address that is listened at; seen from elsewhere, it gets a token."""
        self._host = host.lower()
        self.token = '' if is_local(host) else secrets.token_urlsafe(_TOKEN_BYTES)
        self._own = {*_THIS_MACHINE, _bracketed(self._host)}
        if self.token:
            self._own.add(socket.gethostname().lower())

    def url(self, port: int) -> str:
        """Return the address to open; whoever has it can."""
        shown = socket.gethostname() if self._host in _EVERYWHERE else _bracketed(self._host)
        return f'http://{shown}:{port}' + (f'/{self.token}/' if self.token else '')

    def guarded(self, process: Process | None) -> Process:
        """Return what looks at a request first, and only then has it processed."""

        def look(connection: Any, request: Any) -> Any:
            port = connection.local_address[1]
            hosts, origins = map(request.headers.get_all, ('Host', 'Origin'))
            if reason := self._refusal(port, hosts, origins):
                return connection.respond(http.HTTPStatus.FORBIDDEN, f'{reason}\n')
            path = self._path(request.path)
            if path is None:
                return connection.respond(
                    http.HTTPStatus.FORBIDDEN,
                    'the address lacks its token: open the one that was printed, whole\n',
                )
            response = process and process(connection, dataclasses.replace(request, path=path))
            if response is not None:
                response.headers.update(_HEADERS)
            return response

        return look

    def _refusal(self, port: int, hosts: Sequence[str], origins: Sequence[str]) -> str:
        """Return why a request is none of our page's, empty where it may be."""
        if len(hosts) != 1 or not self._is_own(hosts[0].lower(), port):
            return (
                f'Host {", ".join(hosts) or "(none)"}: this page answers as localhost:{port}, or '
                'by the address that was printed; through a tunnel, from the same port'
            )
        for origin in origins:
            told = urlsplit(origin.lower())
            if told.scheme != 'http' or told.netloc != hosts[0].lower():
                return f'Origin {origin}: only the page itself, http://{hosts[0]}, is answered'
        return ''

    def _is_own(self, told: str, port: int) -> bool:
        """Tell whether a Host is one of ours.

        Beyond this machine any number of an address is: rebinding takes a name.
        """
        name, colon, digits = told.rpartition(':')
        if not colon or told.endswith(']'):
            name, digits = told, str(_HTTP_PORT)
        if digits != str(port):
            return False
        return name in self._own or (bool(self.token) and _is_number(name))

    def _path(self, path: str) -> str | None:
        """Return a path without the token, None of one that has it not."""
        if not self.token:
            return path
        first, _, rest = path.removeprefix('/').partition('/')
        first, mark, asked = first.partition('?')
        if not secrets.compare_digest(first.encode(), self.token.encode()):
            return None
        return f'/{rest}{mark}{asked}'


def is_local(host: str) -> bool:
    """Return whether what is served at an address is seen from this machine only."""
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
