"""Distances of sensed maps for rules that count cells or points.

A rule with ``min_points`` N takes a map to be as far as its N-th nearest cell or point. Each of
these is taken as a ball around it, so its distance is a lower bound.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    GeometryId,
    OccupiedCells,
    PointCloud,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    SceneGraphInspector,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.proximity_rules import Measured, WatchedPairs

_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)  # of coordinates that two poses transform


class _Alone(NamedTuple):
    """A scene of one body, at its own frame, to measure points in."""

    shape: Shape
    properties: ProximityProperties | None  # with its padding, and whether it is solid
    query: QueryObject

    def is_of(self, shape: Shape, properties: ProximityProperties | None) -> bool:
        """Return whether it is of a body of this shape with these properties."""
        return self.shape is shape and self.properties is properties


class CountedPoints:
    """Distances of the N-th nearest cells of maps from bodies."""

    def __init__(self) -> None:
        self._alone: dict[int, _Alone] = {}  # by the value of the id of a body

    def counted(
        self, measured: Measured, query: QueryObject, watched: WatchedPairs, farthest: float
    ) -> Measured:
        """Return a measurement with the distances that count for rules with ``min_points``.

        ``farthest`` [m] is how far rules look; of points beyond only that is known.
        """
        counts = np.unique(watched.min_points[watched.min_points > 1]).tolist()
        if not counts:  # as in most scenes
            return measured
        inspector, distances = query.inspector(), {c: measured.distance.copy() for c in counts}
        for k in _pairs_with_a_map(measured, inspector):
            a, b = int(measured.id_A[k]), int(measured.id_B[k])
            needed = _counts_of(watched, a, b)
            if not needed:
                continue
            is_first = _is_map(inspector, a)
            body, its_map = GeometryId(b if is_first else a), GeometryId(a if is_first else b)
            lower = self._lower_bounds(query, body, its_map, farthest)
            nearest = float(measured.distance[k] - measured.error_bound[k])
            for count in needed:
                nth = math.inf
                if len(lower) >= count:
                    nth = float(np.partition(lower, count - 1)[count - 1])
                # The bound of the pair is taken off this again.
                distances[count][k] = max(nth, nearest) + measured.error_bound[k]
        return measured._replace(counted=distances)

    def _lower_bounds(
        self, query: QueryObject, body: GeometryId, its_map: GeometryId, farthest: float
    ) -> Floats:
        """Return lower bounds [m] of the distances of those cells that may be so near."""
        inspector = query.inspector()
        positions, reach = _balls(inspector, its_map)
        Rs, ps = query.X_WGs([body.get_value(), its_map.get_value()])
        p_BQs = (positions @ Rs[1].T + (ps[1] - ps[0])) @ Rs[0]
        near = _near(inspector, body, p_BQs, farthest + reach)
        results = self._query_of(inspector, body).ComputeSignedDistanceToPoint(
            near, farthest + reach
        )
        largest = max(float(np.abs(each).max(initial=0.0)) for each in (positions, ps))
        slack = reach + _ROUNDING * (1.0 + largest)
        return np.asarray(results.distance) - np.asarray(results.error_bound) - slack

    def _query_of(self, inspector: SceneGraphInspector, body: GeometryId) -> QueryObject:
        """Return a query object of a body alone, at its frame."""
        now = inspector.GetShape(body), inspector.GetProximityProperties(body)
        cached = self._alone.get(body.get_value())
        if cached is None or not cached.is_of(*now):
            instance = inspector.CloneGeometryInstance(body)
            instance.set_pose(RigidTransform())
            scene_graph = SceneGraph()
            scene_graph.RegisterAnchoredGeometry(scene_graph.RegisterSource('body'), instance)
            context = scene_graph.CreateDefaultContext()
            query = scene_graph.get_query_output_port().Eval(context)
            cached = self._alone[body.get_value()] = _Alone(*now, query)
        return cached.query


def _is_map(inspector: SceneGraphInspector, value: int) -> bool:
    return isinstance(inspector.GetShape(GeometryId(value)), OccupiedCells | PointCloud)


def _pairs_with_a_map(measured: Measured, inspector: SceneGraphInspector) -> list[int]:
    """Return the rows of the pairs of a sensed map and a body."""
    ids = np.unique(np.concatenate((measured.id_A, measured.id_B))).tolist()
    maps = [value for value in ids if _is_map(inspector, value)]
    of_one = np.isin(measured.id_A, maps) != np.isin(measured.id_B, maps)
    rows: list[int] = np.flatnonzero(of_one).tolist()
    return rows


def _counts_of(watched: WatchedPairs, a: int, b: int) -> set[int]:
    """Return the ``min_points`` above 1 of the rules that watch a pair, by its ids."""
    rows = np.searchsorted(watched.ids, (a, b))
    return {
        int(watched.min_points[group])
        for group in np.flatnonzero(watched.min_points > 1).tolist()
        if watched.watches(group, rows[:1], rows[1:]).any()
    }


def _balls(
    inspector: SceneGraphInspector, its_map: GeometryId
) -> tuple[NDArray[np.float64], float]:
    """Return the centres (n, 3) [m] of the cells of a map, and how far each reaches [m]."""
    shape = inspector.GetShape(its_map)
    properties = inspector.GetProximityProperties(its_map) or ProximityProperties()
    margin = float(properties.GetPropertyOrDefault('map', 'margin', 0.0))
    padding = float(properties.GetPropertyOrDefault('proximity', 'padding', 0.0))
    if isinstance(shape, OccupiedCells):
        return shape.centres(), math.sqrt(3.0) * (0.5 * shape.resolution() + margin) + padding
    assert isinstance(shape, PointCloud)
    return shape.positions(), shape.radius() + margin + padding


def _near(
    inspector: SceneGraphInspector, body: GeometryId, p_BQs: Floats, farthest: float
) -> Floats:
    """Return the points (m, 3) in a body's frame that may be within a distance [m] of it."""
    obb = inspector.GetObbInGeometryFrame(body)
    if obb is None:
        return p_BQs
    X_BO = obb.pose()
    p_OQs = (p_BQs - X_BO.translation()) @ X_BO.rotation().matrix()
    padding = inspector.GetProximityProperties(body)
    room = farthest + (
        padding.GetPropertyOrDefault('proximity', 'padding', 0.0) if padding else 0.0
    )
    return p_BQs[(np.abs(p_OQs) <= obb.half_width() + room).all(axis=1)]
