"""Peer python-fcl: ``fcl.distance`` and ``fcl.collide`` of two collision objects.

The signed distance may abort the process by a C++ exception that Python cannot catch, crash it
(half spaces) or never return (concentric spheres). Therefore it runs in a process that may be
lost.

A solid mesh is a BVHModel, a surface without an inside: its distance is unsigned, and a body
inside is as far away as the nearest triangle.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.cross_check.answers import (
    SIGNED_DISTANCE,
    Ask,
    PairAnswer,
    SolidMesh,
    checked,
    kind_of,
    measures,
    no_tolerance,
)
from drake_geom_ros.cross_check.tolerances import BESIDE_GRID
from drake_geom_ros.geometry import OccupiedCells, Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells, MapError
from drake_geom_ros.sensed_maps.octree import binary_of_cells


def fcl_shape(shape: Shape) -> Any:
    """Return the FCL shape of a shape."""
    import fcl  # noqa: TID251  (banned elsewhere, so that no result depends on FCL)

    if isinstance(shape, SolidMesh):
        return _surface(shape)
    if isinstance(shape, OccupiedCells):
        return _octree(shape)
    kind = kind_of(shape)
    if kind == 'HalfSpace':
        return fcl.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
    if kind == 'Convex':
        vertices, faces = shape.hull_surface()  # type: ignore[attr-defined]
        counted = np.concatenate((np.full((len(faces), 1), 3), faces), axis=1)
        return fcl.Convex(vertices, len(faces), counted.astype(np.int32).ravel())
    return getattr(fcl, kind)(*measures(shape))


def is_octree(shape: OccupiedCells) -> bool:
    """Return whether the cells lie on the grid of an OctoMap, within its reach."""
    places = shape.centres() / shape.resolution() - 0.5
    if np.abs(places - np.rint(places)).max() > BESIDE_GRID:
        return False
    try:
        binary_of_cells(_cells(shape))
    except MapError:
        return False
    return True


def _cells(shape: OccupiedCells) -> Cells:
    return Cells.of_points(shape.centres(), shape.resolution())


def _octree(shape: OccupiedCells) -> Any:
    """Return cells as FCL's octree, from the bytes of a binary OctoMap."""
    import fcl  # noqa: TID251

    data = binary_of_cells(_cells(shape)).data
    return fcl.OcTree(shape.resolution(), np.frombuffer(data, np.int8).tolist())


@functools.lru_cache(maxsize=8)
def _surface(shape: SolidMesh) -> Any:
    import fcl  # noqa: TID251

    vertices, triangles = shape.surface()
    model = fcl.BVHModel()
    model.beginModel(len(triangles), len(vertices))
    model.addSubModel(vertices, triangles)
    model.endModel()
    return model


class FclPeer:
    """FCL by python-fcl, with libccd, whose tolerance of 1e-6 cannot be set."""

    name = 'python-fcl'

    def __init__(self, tolerance: float | None) -> None:
        no_tolerance(self.name, tolerance)

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return a function that queries the shapes; see Peer."""
        if any(isinstance(shape, (SolidMesh, OccupiedCells)) for shape in (shape_a, shape_b)):
            asks = _unsigned_distance, _contact_of_surface
        else:
            asks = _distance, _penetration
        return _prepared(asks[checked(query) != SIGNED_DISTANCE], shape_a, shape_b)


def _prepared(ask: Callable[[Any, Any], PairAnswer | None], a: Shape, b: Shape) -> Ask:
    import fcl  # noqa: TID251

    objects = [fcl.CollisionObject(fcl_shape(shape), fcl.Transform()) for shape in (a, b)]

    def pose_and_ask(X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer | None:
        for each, X in zip(objects, (X_WA, X_WB), strict=True):
            each.setTransform(fcl.Transform(X.rotation().matrix(), X.translation()))
        return ask(*objects)

    return pose_and_ask


def _distance(a: Any, b: Any) -> PairAnswer:
    """Return the signed distance, for which FCL has no normal."""
    import fcl  # noqa: TID251

    request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)
    result = fcl.DistanceResult()
    distance = fcl.distance(a, b, request, result)
    points = [None if p is None else np.array(p) for p in result.nearest_points]
    return PairAnswer(distance, None, *points)


def _unsigned_distance(a: Any, b: Any) -> PairAnswer:
    """Return the distance of surfaces; where they cross FCL returns -1 or its initial value.

    Witness points are omitted, since that of a sphere is in the sphere's own frame.
    """
    import fcl  # noqa: TID251

    distance = fcl.distance(a, b, fcl.DistanceRequest(), fcl.DistanceResult())
    return PairAnswer(distance, None, None, None)


def _contact_of_surface(a: Any, b: Any) -> PairAnswer | None:
    """Return ``_penetration``, corrected for negative depths of spheres in a BVHModel."""
    contact = _penetration(a, b)
    return contact and contact._replace(distance=-abs(contact.distance))


def _penetration(a: Any, b: Any) -> PairAnswer | None:
    """Return the only contact that FCL reports, requested as by Drake.

    FCL's contact point is not always midway between the surfaces, so there are no witnesses.
    """
    import fcl  # noqa: TID251

    result = fcl.CollisionResult()
    fcl.collide(a, b, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result)
    for contact in result.contacts:
        # Its normal points out of the first object into the second.
        return PairAnswer(-contact.penetration_depth, -np.array(contact.normal), None, None)
    return None
