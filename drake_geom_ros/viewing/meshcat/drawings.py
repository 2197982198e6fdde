"""Drawings of shapes, triangles, lines and points as nodes of viser's scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry import ArgumentError, PointCloud, Rgba, Shape
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.meshcat.tree import Drawing
from drake_geom_ros.viewing.scaled_surfaces import parts_of

_CORNERS = 3


def shape_drawing(shape: Shape, rgba: Rgba) -> Drawing:
    """Return the drawing of a shape; raises MeshFileError for a file that is no mesh."""
    parts = parts_of(shape, solid=True)

    def drawing(scene: Any, name: str) -> None:
        for number, part in enumerate(parts):
            surface = part.surface
            scene.add_mesh_simple(
                f'{name}/{number}',
                vertices=surface.vertices * part.scale,
                faces=surface.triangles,
                flat_shading=not surface.smooth,
                side='double' if surface.two_sided else 'front',
                position=part.X_GS.translation(),
                wxyz=part.X_GS.rotation().ToQuaternion().wxyz(),
                **_look(rgba),
            )

    return drawing


def triangles_drawing(
    vertices: ArrayLike, faces: ArrayLike, rgba: Rgba, wireframe: bool, side: str
) -> Drawing:
    """Return the drawing of triangles ``faces`` (3, m) of vertices (3, n) [m].

    Raises ArgumentError for other shapes, or a face of a vertex that is not there.
    """
    points = columns_of(vertices, 'vertices', 1)
    triangles = np.asarray(faces)
    if triangles.ndim != 2 or len(triangles) != _CORNERS or triangles.dtype.kind not in 'iu':
        raise ArgumentError(
            f'faces is {triangles.dtype} {triangles.shape}; it must be integers (3, m)'
        )
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < len(points)):
        raise ArgumentError(
            f'faces has the vertices {triangles.min()} to {triangles.max()}; there are '
            f'{len(points)}'
        )

    def drawing(scene: Any, name: str) -> None:
        scene.add_mesh_simple(
            f'{name}/mesh',
            vertices=points,
            faces=triangles.T,
            wireframe=wireframe,
            flat_shading=not wireframe,
            side=side,
            **_look(rgba),
        )

    return drawing


def segments_drawing(start: ArrayLike, end: ArrayLike, width: float, rgba: Rgba) -> Drawing:
    """Return the drawing of lines between points (3, n) [m], ``width`` [pixels] wide.

    Raises ArgumentError for other shapes.
    """
    starts, ends = columns_of(start, 'start', 1), columns_of(end, 'end', 1)
    if starts.shape != ends.shape:
        raise ArgumentError(f'start has {len(starts)} points, and end has {len(ends)}')

    def drawing(scene: Any, name: str) -> None:
        scene.add_line_segments(
            f'{name}/lines',
            np.stack([starts, ends], axis=1),
            _look(rgba)['color'],
            thickness=width,
            thickness_units='screen',
        )

    return drawing


def points_drawing(cloud: PointCloud, size: float | None, rgba: Rgba) -> Drawing:
    """Return the drawing of points, ``size`` [m] large; None: as the cloud's radius."""

    def drawing(scene: Any, name: str) -> None:
        scene.add_point_cloud(
            f'{name}/points',
            cloud.positions(),
            _look(rgba)['color'],
            point_size=cloud.radius() if size is None else size,
            point_shape='circle',
            precision='float32',
        )

    return drawing


def _look(rgba: Rgba) -> dict[str, Any]:
    """Return the arguments of viser's nodes for a colour."""
    opaque = rgba.a() >= 1.0
    colour = tuple(round(255.0 * part) for part in (rgba.r(), rgba.g(), rgba.b()))
    return {'color': colour, 'opacity': None if opaque else rgba.a()}


def columns_of(points: Any, name: str, least: int) -> Floats:
    """Return points (n, 3) of columns (3, n); raises ArgumentError for others."""
    array = np.array(points, dtype=np.float64)
    if (
        array.ndim != 2
        or len(array) != 3
        or array.shape[1] < least
        or not np.isfinite(array).all()
    ):
        raise ArgumentError(
            f'{name} has the shape {array.shape}; it must be (3, n), finite, with n >= {least}'
        )
    return array.T
