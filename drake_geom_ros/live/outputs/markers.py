"""~/markers: what RViz shows of the scene, as it is really checked.

Namespaces: ``proximity`` (translucent) and ``illustration`` for geometry by its role;
``contacts`` (witness points), ``normals`` (out of B into A) and ``distances`` (from witness to
witness) for the pairs; ``contact_surfaces``, coloured by pressure; those of sensed maps stand in
``obstacle_markers``. A geometry keeps its marker ids
while it lives: three are set aside for each, because RViz has no capsule and a cylinder with two
balls stands for one. Hulls and meshes are drawn as the triangles of the hull that queries see,
solids as their own. A half space is a plate.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryError,
    GeometryId,
    HalfSpace,
    Mesh,
    Shape,
    SignedDistanceResults,
    Sphere,
)
from drake_geom_ros.live.conversions.fields import fill_pose
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.looks import NORMAL_LENGTH, PAIR_COLOURS, Colour, mesh_surface
from drake_geom_ros.viewing.patches import Patches

# visualization_msgs/Marker
CUBE, SPHERE, CYLINDER, LINE_LIST, CUBE_LIST, SPHERE_LIST, TRIANGLE_LIST = 1, 2, 3, 5, 6, 7, 11
ADD, DELETE, DELETE_ALL = 0, 2, 3

_PLATE = 20.0  # [m] side of the plate that stands for a half space
_PLATE_THICKNESS = 0.01  # [m]
_POINT_SIZE, _LINE_WIDTH = 0.02, 0.004  # [m]
_IDS_A_GEOMETRY = 3
_ID_RANGE = 2**31  # marker ids are int32


@dataclass(frozen=True)
class MarkerPart:
    """One marker of a geometry: its kind, pose in the geometry's frame, and scale [m]."""

    kind: int
    X_GP: RigidTransform
    scale: tuple[float, float, float]
    triangles: NDArray[np.float64] | None = None  # corners (3 m, 3) [m]


def parts_of(shape: Shape, solid: bool = False) -> list[MarkerPart]:
    """Return the markers that draw a shape in its geometry's frame, a mesh as a solid if it is.

    A solid of more than MOST_DRAWN triangles is drawn as its hull.
    """
    here = RigidTransform()
    if isinstance(shape, Sphere):
        return [MarkerPart(SPHERE, here, (2 * shape.radius(),) * 3)]
    if isinstance(shape, Box):
        return [MarkerPart(CUBE, here, (shape.width(), shape.depth(), shape.height()))]
    if isinstance(shape, Ellipsoid):
        return [MarkerPart(SPHERE, here, (2 * shape.a(), 2 * shape.b(), 2 * shape.c()))]
    if isinstance(shape, Cylinder):
        return [
            MarkerPart(CYLINDER, here, (2 * shape.radius(), 2 * shape.radius(), shape.length()))
        ]
    if isinstance(shape, Capsule):
        across, half = 2 * shape.radius(), shape.length() / 2
        ends = [RigidTransform([0.0, 0.0, z]) for z in (-half, half)]
        return [
            MarkerPart(CYLINDER, here, (across, across, shape.length())),
            *(MarkerPart(SPHERE, X, (across,) * 3) for X in ends),
        ]
    if isinstance(shape, HalfSpace):
        X_GP = RigidTransform([0.0, 0.0, -_PLATE_THICKNESS / 2])
        return [MarkerPart(CUBE, X_GP, (_PLATE, _PLATE, _PLATE_THICKNESS))]
    if not isinstance(shape, (Convex, Mesh)):
        raise GeometryError(f'RViz has no marker for {shape!r}')
    vertices, triangles = mesh_surface(shape, solid)
    return [MarkerPart(TRIANGLE_LIST, here, (1.0, 1.0, 1.0), vertices[triangles.ravel()])]


class MarkerWriter:
    """Makes markers in the world frame; ``types`` holds Marker, Point and ColorRGBA."""

    def __init__(self, types: Any, world_frame: str, stamp: Any) -> None:
        self._types = types
        self._world_frame = world_frame
        self._stamp = stamp

    def _marker(self, namespace: str, number: int, action: int = ADD) -> Any:
        marker = self._types.Marker(ns=namespace, id=number, action=action)
        marker.header.frame_id = self._world_frame
        marker.header.stamp = self._stamp
        return marker

    def geometry(
        self,
        namespace: str,
        id: GeometryId,
        parts: list[MarkerPart],
        colour: Colour,
        X_WG: RigidTransform,
    ) -> list[Any]:
        """Return the markers of a geometry."""
        markers = []
        for number, part in enumerate(parts):
            marker = self._marker(namespace, _marker_id(id, number))
            marker.type = part.kind
            fill_pose(marker.pose, X_WG @ part.X_GP)
            _fill_scale_and_colour(marker, part.scale, colour)
            if part.triangles is not None:
                marker.points = self._points(part.triangles)
            markers.append(marker)
        return markers

    def removed(self, namespace: str, id: GeometryId, numbers: Iterable[int]) -> list[Any]:
        """Return the deletions of some of a geometry's markers."""
        return [self._marker(namespace, _marker_id(id, k), DELETE) for k in numbers]

    def pairs(self, results: SignedDistanceResults) -> list[Any]:
        """Return the markers of pairs: contacts and normals of those that overlap, gaps of all."""
        p_WCas, p_WCbs, nhats = results.p_WCa, results.p_WCb, results.nhat_BA_W
        touching = results.distance <= 0.0
        tips = p_WCas + NORMAL_LENGTH * nhats
        return [
            self._list(SPHERE_LIST, 'contacts', np.stack((p_WCas, p_WCbs), axis=1)[touching]),
            self._list(LINE_LIST, 'normals', np.stack((p_WCas, tips), axis=1)[touching]),
            self._list(LINE_LIST, 'distances', np.stack((p_WCas, p_WCbs), axis=1)[~touching]),
        ]

    def cubes(
        self, namespace: str, centres: Floats, edge: float, colour: Colour, X_WM: RigidTransform
    ) -> Any:
        """Return one marker of cubes at ``centres`` (n, 3) [m] in M; without any, its deletion."""
        marker = self._marker(namespace, 0, ADD if len(centres) else DELETE)
        marker.type = CUBE_LIST
        fill_pose(marker.pose, X_WM)
        _fill_scale_and_colour(marker, (edge, edge, edge), colour)
        marker.points = self._points(centres)
        return marker

    def surfaces(self, patches: Patches) -> Any:
        """Return the marker of all contact surfaces; without any, its deletion."""
        marker = self._marker('contact_surfaces', 0, ADD if len(patches) else DELETE)
        marker.type = TRIANGLE_LIST
        marker.pose.orientation.w = 1.0
        _fill_scale_and_colour(marker, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0))
        corners = patches.triangles.ravel()
        marker.points = self._points(patches.vertices[corners])
        colours = patches.colours()[corners].tolist()
        marker.colors = [self._types.ColorRGBA(r=r, g=g, b=b, a=1.0) for r, g, b in colours]
        return marker

    def _list(self, kind: int, namespace: str, points: NDArray[np.float64]) -> Any:
        """Return one marker of many points (k, 2, 3); without any, its deletion."""
        marker = self._marker(namespace, 0, ADD if len(points) else DELETE)
        marker.type = kind
        marker.pose.orientation.w = 1.0
        size = _POINT_SIZE if kind == SPHERE_LIST else _LINE_WIDTH
        _fill_scale_and_colour(marker, (size, size, size), PAIR_COLOURS[namespace])
        marker.points = self._points(points.reshape(-1, 3))
        return marker

    def _points(self, points: NDArray[np.float64]) -> list[Any]:
        return [self._types.Point(x=x, y=y, z=z) for x, y, z in points.tolist()]


def _marker_id(id: GeometryId, number: int) -> int:
    return (_IDS_A_GEOMETRY * id.get_value() + number) % _ID_RANGE


def _fill_scale_and_colour(marker: Any, scale: tuple[float, float, float], colour: Colour) -> None:
    marker.scale.x, marker.scale.y, marker.scale.z = scale
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = colour
