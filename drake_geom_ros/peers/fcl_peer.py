"""python-fcl: ``fcl.distance`` and ``fcl.collide`` of two collision objects.

The signed distance may abort the process with a C++ exception that Python cannot catch, end it by
a wrong address (half spaces) or never return (concentric spheres): see ``unsafe``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.geometry import Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.peers.answers import SIGNED_DISTANCE, Ask, PairAnswer, checked, no_tolerance
from drake_geom_ros.peers.measures import kind_of, measures


def fcl_shape(shape: Shape) -> Any:
    """Return a shape of ours as FCL's."""
    import fcl  # noqa: TID251  (the ban is for answers of ours; these are FCL's own)

    kind = kind_of(shape)
    if kind == 'HalfSpace':
        return fcl.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
    if kind == 'Convex':
        vertices, faces = shape.hull_surface()  # type: ignore[attr-defined]
        counted = np.concatenate((np.full((len(faces), 1), 3), faces), axis=1)
        return fcl.Convex(vertices, len(faces), counted.astype(np.int32).ravel())
    return getattr(fcl, kind)(*measures(shape))


class Loaded:
    """FCL as python-fcl offers it: libccd, its tolerance of 1e-6 cannot be set."""

    name = 'python-fcl'
    unsafe = frozenset({SIGNED_DISTANCE})

    def __init__(self, tolerance: float | None) -> None:
        no_tolerance(self.name, tolerance)

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return what asks the query; see Peer."""
        ask = _distance if checked(query) == SIGNED_DISTANCE else _penetration
        return _prepared(ask, shape_a, shape_b)


def _prepared(ask: Callable[[Any, Any], PairAnswer | None], a: Shape, b: Shape) -> Ask:
    import fcl  # noqa: TID251

    objects = [fcl.CollisionObject(fcl_shape(shape), fcl.Transform()) for shape in (a, b)]

    def pose_and_ask(X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer | None:
        for each, X in zip(objects, (X_WA, X_WB), strict=True):
            each.setTransform(fcl.Transform(X.rotation().matrix(), X.translation()))
        return ask(*objects)

    return pose_and_ask


def _distance(a: Any, b: Any) -> PairAnswer:
    """Return the signed distance; FCL gives no normal with it."""
    import fcl  # noqa: TID251

    request = fcl.DistanceRequest(enable_nearest_points=True, enable_signed_distance=True)
    result = fcl.DistanceResult()
    distance = fcl.distance(a, b, request, result)
    points = [None if p is None else np.array(p) for p in result.nearest_points]
    return PairAnswer(distance, None, *points)


def _penetration(a: Any, b: Any) -> PairAnswer | None:
    """Return the one contact that FCL reports, as Drake asks for it.

    FCL tells a contact point, which is not always midway between the surfaces: no witnesses.
    """
    import fcl  # noqa: TID251

    result = fcl.CollisionResult()
    fcl.collide(a, b, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result)
    for contact in result.contacts:
        # Its normal points out of the first object into the second.
        return PairAnswer(-contact.penetration_depth, -np.array(contact.normal), None, None)
    return None
