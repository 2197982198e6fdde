"""Which points lie on bodies that the scene knows, by the distances of our own queries. No ROS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.ros.scene.point_blocks import ROWS_AT_ONCE
from drake_geom_ros.sensed_maps.passes import Cubes, find_in_cubes

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
_CUBE, _MOST_CUBES = 0.1, 100  # [m] edge of a cube, and how many there are along an axis at most
_ROOM = 1.01  # balls are looked at before bodies are: rounding must lose none


class _Balls:
    """The balls around bodies, each in its frame: frame, centre (3,) [m], radius [m]."""

    def __init__(self, balls: Sequence[tuple[FrameId, Floats, float]]) -> None:
        frames = [frame.get_value() for frame, _, _ in balls]
        self._frames, self._rows = np.unique(np.array(frames, np.int64), return_inverse=True)
        self._p_FCs = np.array([p_FC for _, p_FC, _ in balls])
        self.radii = np.array([radius for _, _, radius in balls])

    def centres(self, query: QueryObject) -> Floats:
        """Return where the centres (n, 3) [m] are in the world of a query."""
        R_WFs, p_WFs, _ = query.X_WFs(self._frames)
        turned = R_WFs[self._rows] @ self._p_FCs[..., np.newaxis]
        return np.asarray(turned[..., 0] + p_WFs[self._rows])


class SelfFilter:
    """A scene of its own of the bodies that are to be left out, posed as they were then.

    The live scene's would measure each point against the map that it made before, too.
    """

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._frames: dict[FrameId, FrameId] = {}  # from the live scene's to its own
        self._graph = SceneGraph()
        self._balls = _Balls([])

    def near(
        self,
        query: QueryObject,
        geometries: Sequence[GeometryId],
        p_WQs: Floats,
        padding: float,
    ) -> Flags:
        """Return which points (n, 3) [m] are no farther than ``padding`` [m] from geometries.

        ``query`` sees these where they were when the points were measured. Points in them are.
        """
        is_near = np.zeros(len(p_WQs), dtype=np.bool_)
        if not geometries or not len(p_WQs):
            return is_near
        self._know(query, geometries)
        numbers = self._may_be_near(query, p_WQs, padding)
        if not len(numbers):
            return is_near
        context = self._graph.CreateDefaultContext()
        there = FramePoseVector({own: query.X_WF(frame) for frame, own in self._frames.items()})
        context.UpdateFramePoses(there)
        bodies = self._graph.get_query_output_port().Eval(context)
        step = max(1, ROWS_AT_ONCE // len(geometries))
        for k in range(0, len(numbers), step):
            block = numbers[k : k + step]
            found = bodies.ComputeSignedDistanceToPoint(p_WQs[block], padding)
            is_near[block[found.point_index]] = True
        return is_near

    def _know(self, query: QueryObject, geometries: Sequence[GeometryId]) -> None:
        """Make the scene anew where bodies came, went or changed."""
        inspector = query.inspector()
        shapes = [inspector.GetShape(geometry) for geometry in geometries]
        poses = [inspector.GetPoseInFrame(geometry) for geometry in geometries]
        frames = [inspector.GetFrameId(geometry) for geometry in geometries]
        larger = [_padding(inspector, geometry) for geometry in geometries]
        arrays = (X.GetAsMatrix34().tobytes() for X in poses)
        key = (*geometries, *map(id, shapes), *frames, *larger, *arrays)
        if key == self._key:
            return
        graph = SceneGraph()
        source = graph.RegisterSource('bodies')
        own: dict[FrameId, FrameId] = {}
        balls = []
        for k, (geometry, X_FG, frame) in enumerate(zip(geometries, poses, frames, strict=True)):
            if frame not in own:
                own[frame] = graph.RegisterFrame(source, GeometryFrame(f'{len(own)}'))
            instance = GeometryInstance(X_FG, shapes[k], f'{k}')
            properties = inspector.GetProximityProperties(geometry)
            assert properties is not None, 'only bodies that queries see are asked for'
            instance.set_proximity_properties(properties)
            graph.RegisterGeometry(source, own[frame], instance)
            balls.append(_ball(query, geometry, frame))
        self._graph, self._frames, self._balls, self._key = graph, own, _Balls(balls), key
        self._shapes = shapes  # lest another one gets the address of one that is gone

    def _may_be_near(self, query: QueryObject, p_WQs: Floats, padding: float) -> Indices:
        """Return which points may be near: those in cubes that balls of bodies reach into."""
        centres = self._balls.centres(query)
        reach = self._balls.radii[:, np.newaxis] + padding
        low, high = (centres - reach).min(axis=0), (centres + reach).max(axis=0)
        if not np.isfinite(high - low).all():
            return np.arange(len(p_WQs))
        edge = max(_CUBE, float((high - low).max()) / _MOST_CUBES)
        cubes = np.zeros(_cubes(high, low, edge) + 1, dtype=np.bool_)
        firsts, lasts = _cubes(centres - reach, low, edge), _cubes(centres + reach, low, edge)
        for first, last in zip(firsts, lasts + 1, strict=True):
            cubes[tuple(map(slice, first, last))] = True
        found = np.empty(len(p_WQs), dtype=np.int64)
        return found[: find_in_cubes(p_WQs, Cubes(low, edge, cubes), found)]


def _cubes(p_WPs: Floats, low: Floats, edge: float) -> NDArray[np.int64]:
    """Return in which cubes points (..., 3) are, from the lowest corner on: later for larger."""
    return np.asarray(np.floor((p_WPs - low) / edge), dtype=np.int64)


def _ball(
    query: QueryObject, geometry: GeometryId, frame: FrameId
) -> tuple[FrameId, Floats, float]:
    """Return the ball of a geometry with its padding, in its frame: centre and radius [m]."""
    inspector = query.inspector()
    shape = inspector.GetShape(geometry)
    if isinstance(shape, HalfSpace):
        return frame, np.zeros(3), np.inf
    obb = inspector.GetObbInGeometryFrame(geometry)
    if obb is None:
        return frame, np.zeros(3), np.inf
    X_FB = inspector.GetPoseInFrame(geometry) @ obb.pose()
    radius = float(np.linalg.norm(obb.half_width())) + _padding(inspector, geometry)
    return frame, np.array(X_FB.translation()), _ROOM * radius


def _padding(inspector: SceneGraphInspector, geometry: GeometryId) -> float:
    properties = inspector.GetProximityProperties(geometry)
    padding = properties.GetPropertyOrDefault('proximity', 'padding', 0.0) if properties else 0.0
    return float(padding)


def bodies_of(
    query: QueryObject, sources: set[str] | None, leave_out: SourceId | None
) -> list[GeometryId]:
    """Return the geometries with the proximity role of some sources; None: of all but one."""
    inspector = query.inspector()

    def counts(geometry: GeometryId) -> bool:
        if inspector.GetOwningSourceId(geometry) == leave_out:
            return False
        return sources is None or inspector.GetOwningSourceName(geometry) in sources

    return [g for g in inspector.GetAllGeometryIds(Role.kProximity) if counts(g)]
