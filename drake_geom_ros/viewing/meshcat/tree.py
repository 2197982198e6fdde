"""Tree of poses and objects by Meshcat's paths, as nodes of viser's scene."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math import RigidTransform

PREFIX = '/drake'  # of paths that do not begin with a slash
_OBJECT = '<object>'

# Adds nodes below a path of viser's scene.
Drawing = Callable[[Any, str], None]


def full_path(path: str) -> str:
    """Return a path from the root, without empty parts; ``''`` is that of all relative ones.

    Raises ArgumentError for a path that is no text.
    """
    if not isinstance(path, str):
        raise ArgumentError(f'path={path!r} must be a text such as "robot/hand"')
    whole = path if path.startswith('/') else f'{PREFIX}/{path}'
    return '/' + '/'.join(part for part in whole.split('/') if part)


class SceneTree:
    """Frames of viser's scene by path, each with one object at most.

    Any thread may call it. Callers see a path as soon as it or one below it was set.
    """

    def __init__(self, scene: Any) -> None:
        """Draw into the scene of a viser server."""
        self._scene = scene
        self._frames: dict[str, Any] = {}
        self._objects: dict[str, Any] = {}
        self._lock = threading.RLock()

    def has(self, path: str) -> bool:
        """Return whether a path exists; the root always does."""
        whole = full_path(path)
        with self._lock:
            return whole == '/' or whole in self._frames

    def draw(self, path: str, drawing: Drawing) -> None:
        """Replace the object at a path by what ``drawing(scene, name)`` adds below ``name``."""
        with self._lock:
            whole = full_path(path)
            self._frame(whole)
            if whole in self._objects:
                self._objects.pop(whole).remove()
            name = f'{whole}/{_OBJECT}'
            self._objects[whole] = self._scene.add_frame(name, show_axes=False)
            drawing(self._scene, name)

    def pose(self, path: str, X_PF: RigidTransform) -> None:
        """Set the pose of a path in its parent."""
        with self._lock:
            frame = self._frame(full_path(path))
            frame.position = X_PF.translation()
            frame.wxyz = X_PF.rotation().ToQuaternion().wxyz()

    def show(self, path: str, visible: bool) -> None:
        """Show or hide a path with all that is below it."""
        with self._lock:
            self._frame(full_path(path)).visible = visible

    def delete(self, path: str) -> None:
        """Remove a path with all that is below it; one that does not exist is no error."""
        whole = full_path(path)
        with self._lock:
            frame = self._frames.get(whole)
            if whole == '/':
                for top in [name for name in self._frames if name.count('/') == 1]:
                    self._frames[top].remove()
            elif frame is not None:
                frame.remove()
            below = '/' if whole == '/' else f'{whole}/'
            gone = [name for name in self._frames if name == whole or name.startswith(below)]
            for name in gone:
                del self._frames[name]
                self._objects.pop(name, None)

    def _frame(self, path: str) -> Any:
        """Return the frame of a path, made with its parents if it is not there."""
        if path == '/':
            raise ArgumentError("path='/' is the root, which has no pose and no object")
        if path not in self._frames:
            parent = path.rpartition('/')[0]
            if parent:
                self._frame(parent)
            self._frames[path] = self._scene.add_frame(path, show_axes=False)
        return self._frames[path]
