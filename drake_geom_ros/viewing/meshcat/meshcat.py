"""``Meshcat``: objects, poses, cameras and controls by pydrake's names, on our page."""

from __future__ import annotations

import dataclasses
import enum
import socket
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry import (
    ArgumentError,
    GeometryError,
    PointCloud,
    Rgba,
    Shape,
    TriangleSurfaceMesh,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.missing import refuse_missing_member
from drake_geom_ros.viewing.meshcat.controls import Controls
from drake_geom_ros.viewing.meshcat.drawings import (
    columns_of,
    points_drawing,
    segments_drawing,
    shape_drawing,
    triangles_drawing,
)
from drake_geom_ros.viewing.meshcat.tree import SceneTree
from drake_geom_ros.viewing.page.serving import LOCALHOST, open_server

_FIRST_PORT, _FIRST_ALLOWED = 7000, 1024
_OF_MESHCAT = ('/Background', '/Grid', '/Axes', '/Lights', '/Cameras')
_SHAPES, _LINES = Rgba(0.9, 0.9, 0.9, 1.0), Rgba(0.1, 0.1, 0.1, 1.0)  # pydrake's defaults


@dataclasses.dataclass
class MeshcatParams:
    """Address at which a ``Meshcat`` listens.

    ``host`` is this machine only by default; ``port`` None is the first free one from 7000, 0 any
    free one.
    """

    host: str = LOCALHOST
    port: int | None = None


class Meshcat:
    """A page in the browser with objects by path, beside buttons and sliders.

    A path such as ``robot/hand`` is below ``/drake``; its pose is that of its parents and its own.
    It is open until the process ends, or ``close`` is called. Any thread may use it. Names and
    arguments are pydrake's; times in recordings are ignored, since there are none.
    """

    class SideOfFaceToRender(enum.Enum):
        """From where the triangles of a mesh are seen."""

        kFrontSide = 'front'
        kBackSide = 'back'
        kDoubleSide = 'double'

    def __init__(
        self, port: int | MeshcatParams | None = None, *, params: MeshcatParams | None = None
    ) -> None:
        """Open the page, on the first free port from 7000, or on ``port`` (0: any).

        Raises:
            GeometryError: viser is missing (the extra ``view``), or the port is taken.
        """
        if isinstance(port, MeshcatParams):
            params, port = port, None
        chosen = params or MeshcatParams(port=port)
        served = open_server(chosen.host, _port_of(chosen))
        self._server: Any = served.server
        self._url = served.url
        if chosen.port and self.port() != chosen.port:
            self.close()
            raise GeometryError(f'port={chosen.port} is taken on {chosen.host}')
        scene, gui = self._server.scene, self._server.gui
        scene.set_up_direction('+z')
        scene.configure_environment_map(None)  # takes a browser without a GPU seconds
        scene.configure_default_lights(cast_shadow=False)
        gui.configure_theme(control_width='large', show_share_button=False, show_logo=False)
        gui.main_panel.dock_right()
        self._tree, self._controls = SceneTree(scene), Controls(gui)

    def web_url(self) -> str:
        """Return the address to open in a browser."""
        return self._url

    def port(self) -> int:
        """Return the port that it is served at."""
        return int(self._server.get_port())

    def close(self) -> None:
        """Close the page; pydrake closes it with its last reference."""
        self._server.stop()

    def Flush(self) -> None:
        """Send what was drawn to the browsers without delay."""
        self._server.flush()

    def GetNumActiveConnections(self) -> int:
        """Return the number of browsers that show the page."""
        return len(self._server.get_clients())

    def HasPath(self, path: str) -> bool:
        """Return whether something was set at a path, or below it."""
        return self._tree.has(path)

    def Delete(self, path: str = '') -> None:
        """Remove a path with all that is below it; by default all relative paths."""
        self._tree.delete(path)

    def SetObject(
        self,
        path: str,
        shape: Shape | TriangleSurfaceMesh | None = None,
        rgba: Rgba | None = None,
        wireframe: bool = False,
        wireframe_line_width: float = 1.0,
        side: SideOfFaceToRender = SideOfFaceToRender.kDoubleSide,
        *,
        point_size: float | None = None,
        cloud: PointCloud | None = None,
        mesh: TriangleSurfaceMesh | None = None,
    ) -> None:
        """Show a shape, a triangle mesh or a cloud of points at a path, instead of the one before.

        Args:
            path: of the object, such as ``robot/hand``.
            shape: any shape of ``geometry``, or a ``TriangleSurfaceMesh``. Meshes are drawn as
                their triangles.
            rgba: its colour; by default light grey for shapes and dark grey for meshes.
            wireframe: draw the edges of a mesh only.
            wireframe_line_width: ignored; the browser draws edges one pixel wide.
            side: from where a mesh is seen.
            point_size: [m] of the points of a cloud; its radius by default.
            cloud: the name of ``shape`` for a ``PointCloud``.
            mesh: the name of ``shape`` for a mesh.

        Raises:
            ArgumentError: nothing to show, or a shape that is none.
        """
        objects = [each for each in (shape, cloud, mesh) if each is not None]
        thing = objects[0] if len(objects) == 1 else None
        if not isinstance(thing, (Shape, TriangleSurfaceMesh)):
            raise ArgumentError(
                f'SetObject takes one Shape, TriangleSurfaceMesh or PointCloud, not {objects}'
            )
        if not isinstance(rgba, Rgba | None):
            raise ArgumentError(f'rgba={rgba!r} must be an Rgba; point_size goes by its name')
        if isinstance(thing, TriangleSurfaceMesh):
            points = np.array(thing.vertices()).T
            faces = thing.triangle_array().T
            self.SetTriangleMesh(path, points, faces, rgba or _LINES, wireframe, side=side)
        elif isinstance(thing, PointCloud):
            self._tree.draw(path, points_drawing(thing, point_size, rgba or _SHAPES))
        else:
            self._tree.draw(path, shape_drawing(thing, rgba or _SHAPES))

    def SetTriangleMesh(
        self,
        path: str,
        vertices: ArrayLike,
        faces: ArrayLike,
        rgba: Rgba = _LINES,
        wireframe: bool = False,
        wireframe_line_width: float = 1.0,
        side: SideOfFaceToRender = SideOfFaceToRender.kDoubleSide,
    ) -> None:
        """Show triangles at a path instead of the object before.

        Args:
            path: of the object.
            vertices: (3, n) [m] in the frame of the path.
            faces: (3, m) numbers of vertices.
            rgba: the colour.
            wireframe: draw the edges only.
            wireframe_line_width: ignored; the browser draws edges one pixel wide.
            side: from where they are seen; a triangle is counter-clockwise from its front.

        Raises:
            ArgumentError: other shapes, or a face of a vertex that is not there.
        """
        self._tree.draw(path, triangles_drawing(vertices, faces, rgba, wireframe, side.value))

    def SetLine(
        self, path: str, vertices: ArrayLike, line_width: float = 1.0, rgba: Rgba = _LINES
    ) -> None:
        """Show a line through points (3, n) [m] at a path, ``line_width`` [pixels] wide."""
        points = columns_of(vertices, 'vertices', 2)
        self.SetLineSegments(path, points[:-1].T, points[1:].T, line_width, rgba)

    def SetLineSegments(
        self,
        path: str,
        start: ArrayLike,
        end: ArrayLike,
        line_width: float = 1.0,
        rgba: Rgba = _LINES,
    ) -> None:
        """Show lines from ``start`` (3, n) to ``end`` (3, n) [m] at a path.

        They are ``line_width`` [pixels] wide. Raises ArgumentError for other shapes.
        """
        self._tree.draw(path, segments_drawing(start, end, line_width, rgba))

    def SetTransform(
        self,
        path: str,
        X_ParentPath: RigidTransform | None = None,
        time_in_recording: float | None = None,
        *,
        matrix: ArrayLike | None = None,
    ) -> None:
        """Set the pose of a path in its parent: a RigidTransform, or a matrix (4, 4) of one.

        Raises:
            ArgumentError: neither or both are given.
            RuntimeError: a matrix that scales or shears.
        """
        if (X_ParentPath is None) == (matrix is None):
            raise ArgumentError('SetTransform takes one of X_ParentPath and matrix')
        pose = matrix if X_ParentPath is None else X_ParentPath
        X_PF = pose if isinstance(pose, RigidTransform) else RigidTransform(np.asarray(pose))
        self._tree.pose(path, X_PF)

    def SetProperty(
        self,
        path: str,
        property: str,
        value: bool | float | Iterable[float],
        time_in_recording: float | None = None,
    ) -> None:
        """Set the property ``visible`` of a path.

        Another one, and those of Meshcat's own paths such as ``/Background``, are a warning: they
        do not exist on this page.
        """
        if property == 'visible' and not path.startswith(_OF_MESHCAT):
            self._tree.show(path, bool(value))
            return
        warnings.warn(
            f'SetProperty({path!r}, {property!r}, {value!r}) has no effect: the page has the '
            "property 'visible' of paths only",
            stacklevel=2,
        )

    def SetCameraPose(self, camera_in_world: ArrayLike, target_in_world: ArrayLike) -> None:
        """Place the camera (3,) [m], looking at a point (3,) [m], in all browsers.

        Raises ArgumentError for the same point twice, or no points.
        """
        points = []
        for name, values in (
            ('camera_in_world', camera_in_world),
            ('target_in_world', target_in_world),
        ):
            point = np.array(values, dtype=np.float64).ravel()
            if point.shape != (3,) or not np.isfinite(point).all():
                raise ArgumentError(f'{name}={point.tolist()} must be a point (3,) [m]')
            points.append(point)
        camera, target = points
        if (camera == target).all():
            raise ArgumentError(f'the camera cannot look at where it is: {camera.tolist()}')
        self._server.initial_camera.position = camera
        self._server.initial_camera.look_at = target
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.position = camera
                client.camera.look_at = target

    def AddButton(self, name: str, keycode: str = '') -> None:
        """Add a button, or set the clicks of the one of this name to 0.

        ``keycode`` is JavaScript's code of a key that clicks it, such as ``KeyG``. Raises
        GeometryError if a slider has the name, or the button another key.
        """
        self._controls.add_button(name, keycode)

    def GetButtonClicks(self, name: str) -> int:
        """Return how often a button was clicked in all browsers since it was added."""
        return self._controls.clicks(name)

    def GetButtonNames(self) -> list[str]:
        """Return the names of all buttons, sorted."""
        return self._controls.names('button')

    def DeleteButton(self, name: str, strict: bool = True) -> bool:
        """Remove a button, and return whether it was there.

        Raises GeometryError if it was not, unless ``strict`` is False.
        """
        return self._controls.delete(name, 'button', strict)

    def AddSlider(
        self,
        name: str,
        min: float,
        max: float,
        step: float,
        value: float,
        decrement_keycode: str = '',
        increment_keycode: str = '',
    ) -> float:
        """Add a slider, and return its value.

        Args:
            name: its label.
            min: its smallest value.
            max: its largest value.
            step: values are multiples of it within the range, as far as there are any.
            value: the first value, which is rounded.
            decrement_keycode: JavaScript's code of a key that moves it by a step, such as
                ``ArrowLeft``.
            increment_keycode: likewise, the other way.

        Raises:
            GeometryError: a control of that name exists.
            ArgumentError: a range or step that is none, an unknown key.
        """
        return self._controls.add_slider(
            name, min, max, step, value, decrement_keycode, increment_keycode
        )

    def SetSliderValue(self, name: str, value: float) -> float:
        """Set the value of a slider in all browsers, and return it as rounded by its step."""
        return self._controls.set_slider(name, value)

    def GetSliderValue(self, name: str) -> float:
        """Return the value of a slider, as the browsers moved it."""
        return self._controls.slider(name)

    def GetSliderNames(self) -> list[str]:
        """Return the names of all sliders, sorted."""
        return self._controls.names('slider')

    def DeleteSlider(self, name: str, strict: bool = True) -> bool:
        """Remove a slider, and return whether it was there.

        Raises GeometryError if it was not, unless ``strict`` is False.
        """
        return self._controls.delete(name, 'slider', strict)

    def DeleteAddedControls(self) -> None:
        """Remove all buttons and sliders."""
        self._controls.delete_all()

    if not TYPE_CHECKING:  # mypy would take any method for one that is there
        __getattr__ = refuse_missing_member


def StartMeshcat() -> Meshcat:
    """Open a page for ``Meshcat`` and print its address.

    Raises GeometryError if viser is missing (the extra ``view``), or no port is free.
    """
    meshcat = Meshcat()
    print(f'Meshcat listening for connections at {meshcat.web_url()}')
    return meshcat


def _port_of(params: MeshcatParams) -> int:
    """Return a port to try first; raises ArgumentError for one that is none."""
    port = params.port
    if port is None:
        return _FIRST_PORT
    if port == 0:
        with socket.socket() as trial:
            trial.bind((params.host or LOCALHOST, 0))
            free: int = trial.getsockname()[1]
            return free
    if not isinstance(port, int) or port < _FIRST_ALLOWED:
        raise ArgumentError(f'port={port!r} must be None, 0, or a number from {_FIRST_ALLOWED}')
    return port
