"""Whom the page's server answers: asked over real sockets, as a hostile web page would ask."""

import base64
import os
import socket
from urllib.parse import urlsplit

import pytest
from viewing.page.pages import TEXT, page_of
from viewing.scenes import local_scene

pytest.importorskip('viser', reason='draws the page')

import viser
from websockets.asyncio import server as sockets

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.page.serving import open_server

PATIENCE = 60.0  # [s]
SOCKET = 'socket'
PAGE = 'page'


@pytest.fixture(scope='module')
def here():
    """Return a page that this machine alone sees."""
    with page_of(TEXT) as (page, _):
        yield page


@pytest.fixture(scope='module')
def beyond():
    """Return a page that is open to all addresses, the token of its address, and its port."""
    page = Page(open_server('0.0.0.0', 18080), local_scene(TEXT))
    yield page, urlsplit(page.url).path.strip('/')
    page.close()


def ask(page, kind, *headers, path='/'):
    """Return status and answer of a request with just these headers."""
    lines = [f'GET {path} HTTP/1.1', *headers]
    if kind == SOCKET:
        key = base64.b64encode(os.urandom(16)).decode()
        lines += ['Upgrade: websocket', 'Connection: Upgrade', 'Sec-WebSocket-Version: 13']
        lines += [
            f'Sec-WebSocket-Key: {key}',
            f'Sec-WebSocket-Protocol: viser-v{viser.__version__}',
        ]
    with socket.create_connection(('127.0.0.1', page.port), PATIENCE) as connection:
        connection.sendall('\r\n'.join([*lines, '', '']).encode())
        answer = b''
        while b'\r\n\r\n' not in answer or (kind == PAGE and len(answer) < 2000):
            if not (more := connection.recv(65536)):
                break
            answer += more
    return int(answer.split()[1]), answer.decode(errors='replace')


def served(kind):
    return 101 if kind == SOCKET else 200


@pytest.mark.parametrize('kind', [PAGE, SOCKET])
@pytest.mark.parametrize('name', ['localhost', '127.0.0.1', '[::1]', 'LOCALHOST'])
def test_the_page_itself_is_served(here, kind, name):
    host = f'{name}:{here.port}'
    for origin in ([], [f'Origin: http://{host}']):
        status, answer = ask(here, kind, f'Host: {host}', *origin)
        assert status == served(kind), answer
    if kind == PAGE:
        assert "frame-ancestors 'self'\r" in answer
        assert 'no-referrer' in answer


@pytest.mark.parametrize('kind', [PAGE, SOCKET])
@pytest.mark.parametrize(
    'host',
    [
        *('evil.example:{port}', 'evil.example', 'localhost', '127.0.0.1', '[::1]', ''),
        *('localhost:1', 'localhost.evil.example:{port}', 'evil.example:{port}:{port}'),
        *('192.168.1.2:{port}', '0.0.0.0:{port}', '127.0.0.1:{port}, evil.example', '::1'),
    ],
)
def test_another_host_is_refused(here, kind, host):
    """A name that rebinding turned to this machine, or a server that is another one."""
    status, answer = ask(here, kind, f'Host: {host.format(port=here.port)}')
    assert status == 403
    assert f'answers as localhost:{here.port}' in answer
    assert 'Sec-WebSocket-Accept' not in answer


@pytest.mark.parametrize('kind', [PAGE, SOCKET])
def test_no_host_and_two_are_refused(here, kind):
    good = f'Host: localhost:{here.port}'
    for headers in ([], [good, 'Host: evil.example'], ['Host: evil.example', good]):
        assert ask(here, kind, *headers)[0] in (400, 403)


@pytest.mark.parametrize('kind', [PAGE, SOCKET])
@pytest.mark.parametrize(
    'origin',
    [
        *('http://evil.example', 'null', '', 'http://localhost', 'http://localhost:1'),
        *('https://localhost:{port}', 'http://127.0.0.1:{port}', 'file://', 'localhost:{port}'),
        *('http://localhost:{port}.evil.example', 'http://user@localhost:{port}'),
    ],
)
def test_another_origin_is_refused(here, kind, origin):
    told = f'Origin: {origin.format(port=here.port)}'
    good = f'Origin: http://localhost:{here.port}'
    for headers in ([told], [good, told], [told, good]):
        status, answer = ask(here, kind, f'Host: localhost:{here.port}', *headers)
        assert status == 403
        assert 'only the page itself' in answer


@pytest.mark.parametrize('kind', [PAGE, SOCKET])
def test_beyond_this_machine_a_token_is_needed(beyond, kind):
    page, token = beyond
    assert len(token) >= 20
    assert page.url == f'http://{socket.gethostname()}:{page.port}/{token}/'
    names = 'localhost', '127.0.0.1', '192.168.7.8', '[fd00::1]', socket.gethostname()
    for name in names:
        headers = f'Host: {name}:{page.port}', f'Origin: http://{name}:{page.port}'
        for path in (f'/{token}', f'/{token}/', f'/{token}/?x=1', f'/{token}?x=1'):
            assert ask(page, kind, *headers, path=path)[0] == served(kind)
        for path in ('/', f'/{token}x', f'/{token[:-1]}', f'/x/{token}', f'/?{token}', '//'):
            status, answer = ask(page, kind, *headers, path=path)
            assert status == 403
            assert 'token' in answer
    for headers in (
        [f'Host: evil.example:{page.port}'],
        [f'Host: localhost:{page.port}', 'Origin: http://evil.example'],
    ):
        assert ask(page, kind, *headers, path=f'/{token}')[0] == 403


def test_two_pages_have_two_tokens(beyond):
    other = Page(open_server('0.0.0.0', 18080), local_scene(TEXT))
    try:
        assert urlsplit(other.url).path != urlsplit(beyond[0].url).path
        assert other.port != beyond[0].port
    finally:
        other.close()


def test_here_the_address_is_plain(here):
    assert here.url == f'http://127.0.0.1:{here.port}'


def test_a_client_reads_the_scene_from_its_own_page_alone(here):
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    address = f'ws://127.0.0.1:{here.port}'
    protocol = [f'viser-v{viser.__version__}']
    with connect(address, subprotocols=protocol, origin=f'http://127.0.0.1:{here.port}') as client:
        assert len(client.recv(timeout=PATIENCE)) > 0
    with pytest.raises(InvalidStatus, match='403'):
        connect(address, subprotocols=protocol, origin='http://evil.example')


def test_a_viser_that_does_not_ask_the_gate_serves_nothing(monkeypatch):
    """As one would that makes its server in another way."""
    serve, ports = sockets.serve, []

    class Ungated(viser.ViserServer):
        def __init__(self, **options):
            gated, sockets.serve = sockets.serve, serve
            super().__init__(**options)
            sockets.serve = gated
            ports.append(self.get_port())

    monkeypatch.setattr(viser, 'ViserServer', Ungated)
    with pytest.raises(GeometryError, match='would answer any web page'):
        open_server(port=18080)
    with pytest.raises(OSError, match='refused'):
        socket.create_connection(('127.0.0.1', ports[0]), PATIENCE)
    assert sockets.serve is serve


def test_an_address_of_another_machine_is_refused_at_once():
    for host in ('203.0.113.7', 'nowhere.invalid'):
        with pytest.raises(GeometryError, match='no page can be opened at'):
            open_server(host)


@pytest.mark.parametrize('port', [-1, 0, 65536, 99999])
def test_a_port_that_is_none_is_refused_at_once(port):
    with pytest.raises(GeometryError, match='a port is a number from 1 to 65535'):
        open_server(port=port)


def test_where_the_last_port_is_taken_no_page_is_opened():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 65535))
        taken.listen()
        with pytest.raises(GeometryError, match='no port from 65535 to 65535 is free'):
            open_server(port=65535)


def test_no_relay_is_asked_to_share_the_page(here):
    assert here._server.request_share_url() is None
