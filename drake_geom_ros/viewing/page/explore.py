"""The page of a scene inside a notebook: an interactive view beside ``viewing.notebook.show``."""

from __future__ import annotations

from html import escape
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector, SceneGraph
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.page.serving import LOCALHOST, PORT, open_server

__all__ = ['NotebookPage', 'explore']

# Notebooks that may show the page in a frame: Jupyter on this machine, and VS Code.
_NOTEBOOKS = ('http://localhost:*', 'http://127.0.0.1:*', 'vscode-webview:')


class _JointsOfStates(Protocol):
    """Protocol of joints of states, such as ``drake_geom_ros.batch.Joints``."""

    @property
    def frame_ids(self) -> list[FrameId]: ...
    def poses(self, states: NDArray[np.float64]) -> NDArray[np.float64]: ...


class NotebookPage:
    """A page that a notebook shows in a frame, and that a cell can pose until it is closed."""

    def __init__(self, page: Page, scene: LocalScene, joints: Any, height: int) -> None:
        self._page, self._scene, self._joints, self._height = page, scene, joints, height

    @property
    def url(self) -> str:
        """The address of the page, with a token, for a browser of this machine."""
        return self._page.url

    def pose(self, q: ArrayLike) -> None:
        """Show another state q (c,) [rad] or [m] of the joints.

        Raises ArgumentError without joints.
        """
        if self._joints is None:
            raise ArgumentError('pose(q) needs joints: explore(scene_graph, joints, q)')
        (poses,) = self._joints.poses(np.asarray(q, dtype=np.float64)[None])
        self._scene.pose(FramePoseVector.FromArrays(self._joints.frame_ids, poses))

    def close(self) -> None:
        """Stop serving; the frame shows nothing new from then on."""
        self._page.close()

    def _repr_html_(self) -> str:
        """Return the frame; notebooks call this."""
        return (
            f'<iframe src="{escape(self.url)}" title="drake_geom_ros" style="width: 100%; '
            f'height: {self._height}px; border: 1px solid #d7dde4"></iframe>'
        )


def explore(
    scene_graph: SceneGraph,
    joints: _JointsOfStates | None = None,
    q: ArrayLike | None = None,
    *,
    max_distance: float = 0.05,
    contacts: bool = False,
    height: int = 560,
    port: int = PORT,
) -> NotebookPage:
    """Return the interactive page of a scene, which a notebook shows as the result of a cell.

    The page is served on this machine, behind a token, and may be shown in a frame by notebooks
    of this machine: Jupyter at ``localhost`` or ``127.0.0.1``, and VS Code. It needs the extra
    ``view``. Filters of the page change the scene graph.

    Args:
        scene_graph: The scene; frames have the poses of its file.
        joints: The joints of ``q``, which ``pose`` moves later.
        q: Joint values (c,) [rad] or [m].
        max_distance: Pairs up to this distance [m] are in the table.
        contacts: Whether to show contact surfaces.
        height: Height of the frame [pixels].
        port: The first port that is tried.

    Raises:
        ArgumentError: ``joints`` and ``q`` do not go together.
        GeometryError: viser is not installed, or no port is free.
    """
    if (joints is None) != (q is None):
        raise ArgumentError('joints and q go together')
    scene = LocalScene(scene_graph, scene_graph.CreateSharedContext(partial=True))
    served = open_server(LOCALHOST, port, frames=_NOTEBOOKS)
    page = Page(served, scene, max_distance=max_distance, contacts=contacts, title='notebook')
    shown = NotebookPage(page, scene, joints, height)
    if q is not None:
        shown.pose(q)
    return shown
