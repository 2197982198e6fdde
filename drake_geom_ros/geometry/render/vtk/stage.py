"""``Stage``: a scene's VTK actors and renderers for colour, depth and labels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkRenderer

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.render.vtk.actors import actor_of, looks_of
from drake_geom_ros.geometry.render.vtk.surfaces import surface_of_shape, surface_of_triangles
from drake_geom_ros.geometry.render.vtk.windows import hidden_window
from drake_geom_ros.math.array_types import Floats

if TYPE_CHECKING:
    from drake_geom_ros.geometry.render._packing import Packed


# Depths come as 24 bits of a colour, in equal steps from the camera to the farthest surface.
_STEPS = 2**24 - 1
_DEPTH = """
float steps = clamp(-vertexVC.z / reach, 0.0, 1.0) * 16777215.0;
float high = floor(steps / 65536.0);
float middle = floor((steps - high * 65536.0) / 256.0);
float low = floor(steps - high * 65536.0 - middle * 256.0);
fragOutput0 = vec4(high / 255.0, middle / 255.0, low / 255.0, 1.0);
"""
_LABEL = 'fragOutput0 = vec4(code, 1.0);'
_LIGHT = '//VTK::Light::Impl'  # where VTK's own shader computes a colour


class View(NamedTuple):
    """A camera: its pixels, intrinsics in Drake's convention, and visible depths [m]."""

    width: int
    height: int
    focal: tuple[float, float]
    centre: tuple[float, float]
    near: float
    far: float


class _BodyActors(NamedTuple):
    """Actors of a body: those of colour images with their poses in G, and flat ones."""

    looks: list[tuple[Any, Floats]]
    depth: Any
    label: Any | None  # None: left out of label images
    reach: float  # [m] from its origin

    def pose(self, X_CG: Floats, *, seen: bool) -> None:
        """Set the pose (4, 4) of all actors in the camera, or hide them."""
        flat = [(actor, np.eye(4)) for actor in (self.depth, self.label) if actor is not None]
        for actor, T_GA in (*self.looks, *flat):
            actor.SetVisibility(seen)
            if seen:
                matrix = vtkMatrix4x4()
                matrix.DeepCopy((X_CG @ T_GA).ravel().tolist())
                actor.SetUserMatrix(matrix)


class Stage:
    """Actors of a packed scene; made, used and released in the thread of its context."""

    def __init__(self, packed: Packed, clear_color: Floats) -> None:
        """Make the actors before a background ``clear_color`` (3,); GeometryError for textures."""
        self.packed = packed
        self._window = hidden_window()
        self._renderers = {}
        for kind, background in (
            *(('color', clear_color), ('depth', np.ones(3)), ('label', np.ones(3))),
        ):
            self._renderers[kind] = renderer = vtkRenderer()
            renderer.SetBackground(*background.tolist())
            camera = renderer.GetActiveCamera()
            camera.SetPosition(0.0, 0.0, 0.0)
            camera.SetFocalPoint(0.0, 0.0, 1.0)
            camera.SetViewUp(0.0, -1.0, 0.0)
        self._bodies = [self._body(row) for row in range(len(packed.ids))]

    def close(self) -> None:
        """Release the context."""
        self._window.Finalize()

    def _body(self, row: int) -> _BodyActors:
        """Add the actors of a body."""
        packed, bodies = self.packed, self.packed.bodies
        surface = surface_of_shape(packed.shapes[row])
        if surface is None:
            first, last = bodies.vertex_starts[row : row + 2].tolist()
            begin, end = bodies.triangle_starts[row : row + 2].tolist()
            triangles = bodies.triangles[begin:end] - first
            surface = surface_of_triangles(bodies.p_GVs[first:last], triangles)
        looks = looks_of(packed, row, surface)
        for actor, _ in looks:
            self._renderers['color'].AddActor(actor)
        depth, label = _flat(surface, _DEPTH), None
        self._renderers['depth'].AddActor(depth)
        if bodies.is_labelled[row]:
            label = _flat(surface, _LABEL)
            high, low = divmod(int(bodies.labels[row]), 256)
            _uniforms(label).SetUniform3f('code', [high / 255.0, low / 255.0, 0.0])
            self._renderers['label'].AddActor(label)
        sides = np.reshape(surface.GetBounds(), (3, 2))
        return _BodyActors(looks, depth, label, float(np.linalg.norm(np.abs(sides).max(axis=1))))

    def pose(self, R_CGs: Floats, p_CGs: Floats, placed: NDArray[np.bool_]) -> float:
        """Set the poses of bodies in the camera; return a depth [m] beyond all of them."""
        X_CGs = np.zeros((len(self._bodies), 4, 4))
        X_CGs[:, :3, :3], X_CGs[:, :3, 3], X_CGs[:, 3, 3] = R_CGs, p_CGs, 1.0
        farthest = 0.0
        for body, X_CG, seen in zip(self._bodies, X_CGs, placed.tolist(), strict=True):
            body.pose(X_CG, seen=seen)
            if seen:
                farthest = max(farthest, X_CG[2, 3] + body.reach)
        return farthest

    def color(self, view: View) -> NDArray[np.uint8]:
        """Return red, green, blue and alpha (height, width, 4)."""
        image = self._drawn('color', view)
        image[..., 3] = 255
        return image

    def depth(self, view: View) -> NDArray[np.float64]:
        """Return depths [m] (height, width), infinity for the background."""
        reach = float(np.float32(view.far))
        for body in self._bodies:
            _uniforms(body.depth).SetUniformf('reach', reach)
        parts = self._drawn('depth', view)[..., :3].astype(np.int64)
        steps = parts @ np.array([2**16, 2**8, 1])
        depths: NDArray[np.float64] = (steps + 0.5) * (reach / _STEPS)
        depths[steps == _STEPS] = np.inf
        return depths

    def label(self, view: View, empty: int) -> NDArray[np.int16]:
        """Return labels (height, width), ``empty`` for the background."""
        parts = self._drawn('label', view).astype(np.int16)
        labels = parts[..., 0] * 256 + parts[..., 1]
        labels[parts[..., 2] > 0] = empty
        return labels

    def _drawn(self, kind: str, view: View) -> NDArray[np.uint8]:
        """Return the pixels (height, width, 4) of one of the renderers; raises GeometryError."""
        window, renderer = self._window, self._renderers[kind]
        window.SetSize(view.width, view.height)
        camera = renderer.GetActiveCamera()
        camera.SetClippingRange(view.near, view.far)
        camera.SetExplicitProjectionTransformMatrix(_projection(view))
        camera.UseExplicitProjectionTransformMatrixOn()
        window.AddRenderer(renderer)
        window.Render()
        pixels = vtkUnsignedCharArray()
        window.GetRGBACharPixelData(0, 0, view.width - 1, view.height - 1, 0, pixels)
        window.RemoveRenderer(renderer)
        if pixels.GetNumberOfTuples() != view.width * view.height:
            raise GeometryError(
                f'VTK drew no image of {view.width} x {view.height} pixels: more than this '
                'machine has room for'
            )
        image: NDArray[np.uint8] = vtk_to_numpy(pixels).reshape(view.height, view.width, 4)
        return image[::-1].copy()


def _flat(surface: Any, shader: str) -> Any:
    """Return an actor whose pixels have a shader's value instead of a colour."""
    actor = actor_of(surface)
    actor.GetShaderProperty().AddFragmentShaderReplacement(_LIGHT, True, shader, False)
    return actor


def _uniforms(actor: Any) -> Any:
    """Return the numbers that an actor's shader reads."""
    return actor.GetShaderProperty().GetFragmentCustomUniforms()


def _projection(view: View) -> Any:
    """Return OpenGL's projection: x right, y up, z back, to a cube of [-1, 1].

    As in Drake, pixel u looks along (u + 0.5 - center_x) / focal_x.
    """
    w, h, near, far = view.width, view.height, view.near, view.far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = 2.0 * view.focal[0] / w, 2.0 * view.focal[1] / h
    matrix[0, 2], matrix[1, 2] = 1.0 - 2.0 * view.centre[0] / w, 2.0 * view.centre[1] / h - 1.0
    matrix[2, 2], matrix[2, 3] = (near + far) / (near - far), 2.0 * near * far / (near - far)
    matrix[3, 2] = -1.0
    made = vtkMatrix4x4()
    made.DeepCopy(matrix.ravel().tolist())
    return made
