"""Cameras of the browsers of a page: where each looks, by itself."""

from __future__ import annotations

import contextvars
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import DIRECTION_NORM
from drake_geom_ros.viewing.extents import Extent
from drake_geom_ros.viewing.page.options import CommandError

# The browser whose viser client connects; set for the task that serves its web socket, and seen
# by all that this task begins.
BROWSER: contextvars.ContextVar[str] = contextvars.ContextVar('browser', default='')

# Directions from the middle of the scene to the viewer. The top view is inclined a little, since
# the up direction must not be along the view.
PRESETS = {
    'fit': (0.55, -0.7, 0.45),
    'front': (1.0, 0.0, 0.0),
    'back': (-1.0, 0.0, 0.0),
    'left': (0.0, 1.0, 0.0),
    'right': (0.0, -1.0, 0.0),
    'top': (0.0, -0.01, 1.0),
}
_FILLED = 0.94  # share of the picture that a scene fills
_NEAREST = 0.1  # [m] from the middle of a scene
_FLIGHT, _FRAMES = 0.3, 10  # [s] and pictures of a flight
_PICTURE = (1000, 1600)  # [pixels] at most


class Cameras:
    """Cameras by the key of their browser."""

    def __init__(self, server: Any, moved: Callable[[str, dict[str, Any]], None]) -> None:
        """Watch a viser server; ``moved(key, pose)`` is called when a browser's view moves."""
        self._server, self._moved = server, moved
        self._lock = threading.Lock()
        self._clients: dict[str, Any] = {}
        self._wanted: dict[str, tuple[list[float], list[float]]] = {}
        self._dark: dict[str, bool] = {}
        self._extent: Extent | None = None

        # Coroutines, so that they run in the task that has the browser's key.
        async def met(client: Any) -> None:
            self._meet(BROWSER.get(), client)

        async def left(client: Any) -> None:
            with self._lock:
                for key in [key for key, each in self._clients.items() if each is client]:
                    del self._clients[key]

        server.on_client_connect(met)
        server.on_client_disconnect(left)

    def show(self, extent: Extent) -> None:
        """Set the box around the scene; whoever looked at nothing looks at it now."""
        with self._lock:
            first, self._extent = self._extent is None, extent
            clients = list(self._clients.items()) if first else []
        # Where a browser looks until its size is known, and when its view is reset by viser.
        with self._server.atomic():
            camera = self._server.initial_camera
            camera.position, camera.look_at = fitted(extent, PRESETS['fit'], camera.fov, 1.0)
        for key, client in clients:
            if key not in self._wanted:
                self._place(client, *self._fitted(client, 'fit'))

    def preset(self, key: str, name: str) -> None:
        """Let a browser see the whole scene from a side."""
        if name not in PRESETS:
            raise CommandError(f'{name!r} is no view; there are {", ".join(PRESETS)}')
        client = self._client(key)
        self._fly(client, *self._fitted(client, name))

    def fly_to(self, key: str, point: Floats, size: float) -> None:
        """Let a browser look at a point [m] from near by, in the direction in which it looks."""
        client = self._client(key)
        way = client.camera.position - client.camera.look_at
        far = max(4.0 * size, 0.6)
        self._fly(
            client, point + far * way / max(float(np.linalg.norm(way)), DIRECTION_NORM), point
        )

    def place(self, key: str, position: list[float], look_at: list[float]) -> None:
        """Place the camera of a browser, also of one whose picture is not there yet."""
        with self._lock:
            self._wanted[key] = position, look_at
            client = self._clients.get(key)
        if client is not None:
            self._place(client, np.array(position), np.array(look_at))

    def darken(self, key: str, *, dark: bool) -> None:
        """Let a browser draw on a dark ground, or on a light one."""
        with self._lock:
            self._dark[key] = dark
            client = self._clients.get(key)
        if client is not None:
            _set_theme(client, dark)

    def save(self, key: str, name: str) -> None:
        """Let a browser render what it sees, and keep it as a file."""
        import imageio.v3  # comes with viser, and takes long to import

        client = self._client(key)
        height, width = (min(a, b) for a, b in zip(_PICTURE, _size(client), strict=True))
        image = client.get_render(height=height, width=width)
        client.send_file_download(name, imageio.v3.imwrite('<bytes>', image, extension='.png'))

    def _meet(self, key: str, client: Any) -> None:
        with self._lock:
            self._clients[key] = client
            wanted, extent, dark = self._wanted.get(key), self._extent, self._dark.get(key, False)
        _set_theme(client, dark)
        if wanted is not None:
            self._place(client, *map(np.array, wanted))
        elif extent is not None:
            self._place(client, *self._fitted(client, 'fit'))

        async def moved(camera: Any) -> None:
            self._moved(
                key,
                {
                    'position': np.round(camera.position, 4).tolist(),
                    'look_at': np.round(camera.look_at, 4).tolist(),
                },
            )

        client.camera.on_update(moved)

    def _client(self, key: str) -> Any:
        with self._lock:
            client = self._clients.get(key)
        if client is None:
            raise CommandError('the picture of this browser is not there yet')
        return client

    def _fitted(self, client: Any, name: str) -> tuple[Floats, Floats]:
        """Return position and target of a camera that has the whole scene in sight."""
        extent = self._extent or Extent(np.full(3, -1.0), np.ones(3))
        return fitted(extent, PRESETS[name], client.camera.fov, client.camera.aspect)

    def _fly(self, client: Any, position: Floats, look_at: Floats) -> None:
        begin = client.camera.position, client.camera.look_at
        for share in np.linspace(0.0, 1.0, _FRAMES + 1)[1:]:
            eased = share * share * (3.0 - 2.0 * share)
            self._place(
                client,
                begin[0] + eased * (position - begin[0]),
                begin[1] + eased * (look_at - begin[1]),
            )
            time.sleep(_FLIGHT / _FRAMES)

    @staticmethod
    def _place(client: Any, position: Floats, look_at: Floats) -> None:
        with client.atomic():
            client.camera.position, client.camera.look_at = position, look_at


def fitted(
    extent: Extent, way: tuple[float, float, float], fov: float, aspect: float
) -> tuple[Floats, Floats]:
    """Return position and target [m] of a camera that has a box in sight.

    ``way`` (3,) is the direction from the box to the camera, ``fov`` the vertical field of view
    [rad] and ``aspect`` the width of the picture over its height.
    """
    ahead = -np.array(way) / np.linalg.norm(way)
    aside = np.cross(ahead, (0.0, 0.0, 1.0))
    aside /= np.linalg.norm(aside)
    axes = np.stack([aside, np.cross(aside, ahead), ahead])
    corners = np.stack(np.meshgrid(*np.stack(extent).T), axis=-1).reshape(-1, 3) @ axes.T
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    x, y, z = (corners - middle).T
    tangent = _FILLED * np.tan(0.5 * fov)
    far = np.maximum(np.abs(x) / (tangent * aspect), np.abs(y) / tangent) - z
    return middle @ axes - max(float(far.max()), _NEAREST) * ahead, middle @ axes


def _set_theme(client: Any, dark: bool) -> None:
    client.gui.configure_theme(dark_mode=dark, show_share_button=False, show_logo=False)


def _size(client: Any) -> tuple[int, int]:
    return client.camera.image_height, client.camera.image_width
