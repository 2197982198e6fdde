"""Coal: ``coal.distance`` and ``coal.collide`` of two geometries.

A mesh as a solid is a BVHModel: a surface, signed by its triangles where they are crossed, and
without an inside.
"""

from __future__ import annotations

import functools
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
)
from drake_geom_ros.geometry import Shape
from drake_geom_ros.math import RigidTransform


def coal_shape(shape: Shape) -> Any:
    """Return a shape of ours as Coal's."""
    import coal

    if isinstance(shape, SolidMesh):
        return _surface(shape)
    kind = kind_of(shape)
    if kind == 'HalfSpace':
        return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
    if kind == 'Convex':
        points = coal.StdVec_Vec3s()
        points.extend(list(shape.hull_surface()[0]))  # type: ignore[attr-defined]
        return coal.Convex.convexHull(points, True, 'Qt')
    return getattr(coal, kind)(*measures(shape))


@functools.lru_cache(maxsize=8)
def _surface(shape: SolidMesh) -> Any:
    import coal

    vertices, triangles = shape.surface()
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(vertices))
    faces.extend([coal.Triangle(*corners) for corners in triangles.tolist()])
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(vertices))
    model.addSubModel(points, faces)
    model.endModel()
    return model


class CoalPeer:
    """Coal with its own settings, or with one tolerance for both GJK and EPA."""

    name = 'Coal'

    def __init__(self, tolerance: float | None) -> None:
        self._tolerance = tolerance

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return what asks the query; see Peer."""
        import coal

        if checked(query) == SIGNED_DISTANCE:
            of_surfaces = isinstance(shape_a, SolidMesh) and isinstance(shape_b, SolidMesh)
            return self._distance(coal, coal_shape(shape_a), coal_shape(shape_b), of_surfaces)
        return self._penetration(coal, coal_shape(shape_a), coal_shape(shape_b))

    def _set(self, request: Any) -> Any:
        if self._tolerance is not None:
            request.gjk_tolerance = request.epa_tolerance = self._tolerance
        return request

    def _distance(self, coal: Any, a: Any, b: Any, of_surfaces: bool) -> Ask:
        request, result = self._set(coal.DistanceRequest()), coal.DistanceResult()

        def ask(X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer:
            result.clear()
            distance = coal.distance(a, _pose(coal, X_WA), b, _pose(coal, X_WB), request, result)
            points = result.getNearestPoint1(), result.getNearestPoint2()
            if of_surfaces:  # two of them leave the normal as it was
                return PairAnswer(distance, None, *(np.array(p) for p in points))
            return PairAnswer(distance, -result.normal, *(np.array(p) for p in points))

        return ask

    def _penetration(self, coal: Any, a: Any, b: Any) -> Ask:
        request, result = self._set(coal.CollisionRequest()), coal.CollisionResult()

        def ask(X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer | None:
            result.clear()
            coal.collide(a, _pose(coal, X_WA), b, _pose(coal, X_WB), request, result)
            for contact in result.getContacts():
                points = contact.getNearestPoint1(), contact.getNearestPoint2()
                return PairAnswer(
                    contact.penetration_depth, -contact.normal, *(np.array(p) for p in points)
                )
            return None

        return ask


def _pose(coal: Any, X: RigidTransform) -> Any:
    return coal.Transform3s(X.rotation().matrix(), X.translation())
