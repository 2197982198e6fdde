"""Opens a page: viser is imported here, and only when somebody asks for a page."""

from __future__ import annotations

import ipaddress
from typing import Any

from drake_geom_ros.geometry import GeometryError

LOCALHOST = '127.0.0.1'
PORT = 8080


def open_server(host: str = LOCALHOST, port: int = PORT) -> Any:
    """Return a viser server; the next free port where that one is taken.

    Raises GeometryError where viser is not installed, or nothing can be opened there.
    """
    try:
        import viser
    except ImportError as error:
        raise GeometryError(
            f'the page takes viser, which cannot be imported ({error}): pip install viser, or '
            "this package with its extra 'view'"
        ) from None
    try:
        return viser.ViserServer(host=host, port=port, label='drake_geom_ros', verbose=False)
    except (OSError, RuntimeError) as error:
        raise GeometryError(f'no page can be opened at {host}:{port}: {error}') from None


def warning(host: str) -> str:
    """Return what it means to open a page at an address; empty where only this machine sees it."""
    try:
        local = ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = host == 'localhost'
    if local:
        return ''
    return (
        f'whoever reaches {host} sees this page and may move and filter what it shows: there is '
        'no password and no encryption. From elsewhere, an SSH tunnel is safer: '
        f'ssh -L {PORT}:{LOCALHOST}:{PORT} THIS_MACHINE'
    )
