"""The self filter: points on bodies of the scene, by the distances of point queries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphInspector,
    Shape,
    SourceId,
)
from drake_geom_ros.live.scene.body_shadows import Balls, are_in_shadow
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.sensed_maps.passes import Cubes, find_in_cubes

_CUBE, _MOST_CUBES = 0.1, 100  # [m] edge of a cube, and how many there are along an axis at most
_SMALL, _SMALLEST = 0.3, 0.005  # edge of a small cube: of the noise, and [m]
_MOST_SMALL = 2.0**62  # small cubes, numbered by whole numbers
_ROWS = 100_000  # of a point and a body, that are asked for at once: 10 MB
_ROOM = 1.01  # balls are looked at before bodies are: rounding must lose none


class Body(NamedTuple):
    """A geometry on which points are left out, in the frame of that number of ``Bodies``."""

    shape: Shape
    properties: ProximityProperties  # but for its padding: a sensor sees the body without it
    X_FG: RigidTransform
    frame: int
    centre: Floats  # (3,) [m] in F, of a ball around it
    radius: float  # [m]
    padding: float | None = None  # [m] of the shell around it; None: as of most


class Bodies(NamedTuple):
    """Bodies, and the ids of the frames that they are on."""

    bodies: list[Body]
    frames: NDArray[np.int64]


class BodiesThen(NamedTuple):
    """Bodies where they were; the same ones have the same number."""

    number: int
    bodies: Bodies | None  # None: whoever is told has had them
    R_WFs: Floats  # (f, 3, 3) of their frames
    p_WFs: Floats  # (f, 3) [m]


class Zones(NamedTuple):
    """Points on bodies, and points beside them, in the shell."""

    on_bodies: Flags  # (n,) no farther from a body than the noise, or inside
    in_shell: Indices  # (m,) numbers of points that are farther, and within the padding
    distances: Floats  # (m,) [m] lower bounds of their least distances from a body


class KnownBodies:
    """Describes bodies once for as long as they are what they are."""

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._number = 0
        self._bodies = Bodies([], np.zeros(0, dtype=np.int64))
        self._shapes: list[Shape] = []
        self._frames: list[FrameId] = []

    @property
    def frames(self) -> list[FrameId]:
        """The frames that the bodies are on."""
        return self._frames

    def then(self, query: QueryObject, number: int = 0) -> BodiesThen:
        """Return the bodies where a query sees them; those of the number ``number`` untold."""
        R_WFs, p_WFs, _ = query.X_WFs(self._bodies.frames)
        bodies = None if self._number == number else self._bodies
        return BodiesThen(self._number, bodies, np.array(R_WFs), np.array(p_WFs))

    def know(
        self,
        query: QueryObject,
        geometries: Sequence[GeometryId],
        paddings: Sequence[float | None] = (),
    ) -> None:
        """Take these for the bodies; their number is another where anything of them changed.

        ``paddings`` [m] are of each; None, or none at all: as of most.
        """
        inspector = query.inspector()
        paddings = paddings or [None] * len(geometries)
        shapes = [inspector.GetShape(geometry) for geometry in geometries]
        poses = [inspector.GetPoseInFrame(geometry) for geometry in geometries]
        frames = [inspector.GetFrameId(geometry) for geometry in geometries]
        arrays = (X.GetAsMatrix34().tobytes() for X in poses)
        key = (*geometries, *map(id, shapes), *frames, *arrays, *paddings)
        if key == self._key:
            return
        rows: dict[FrameId, int] = {}
        bodies = []
        columns = shapes, poses, frames, geometries, paddings
        for shape, X_FG, frame, geometry, padding in zip(*columns, strict=True):
            properties = inspector.GetProximityProperties(geometry)
            assert properties is not None, 'only bodies that queries see are asked for'
            row = rows.setdefault(frame, len(rows))
            ball = _ball(query, geometry)
            bodies.append(Body(shape, _without_padding(properties), X_FG, row, *ball, padding))
        values = np.array([frame.get_value() for frame in rows], dtype=np.int64)
        self._bodies, self._key, self._number = Bodies(bodies, values), key, self._number + 1
        self._frames = list(rows)
        self._shapes = shapes  # lest another one gets the address of one that is gone


class SelfFilter:
    """A scene of its own of the bodies that are to be left out, posed as they were then.

    The live scene's would measure each point against the map that it made before, too.
    """

    def __init__(self) -> None:
        self.number = 0  # of the bodies that it has: none
        self._frames: list[FrameId] = []  # its own
        self._graph = SceneGraph()
        self._bodies: list[Body] = []
        self._ids = np.zeros(0, dtype=np.int64)  # of its geometries, ascending as bodies are

    def zones(self, there: BodiesThen, p_WQs: Floats, noise: float, padding: float) -> Zones:
        """Return which points (n, 3) [m] are on bodies, and which beside them.

        On bodies is what is certainly no farther than ``noise`` [m], or the padding where that is
        less, and the shell reaches from there to the padding. That is ``padding`` [m] but of
        bodies with one of their own. Bodies are where they were when the points were measured.
        """
        if there.number != self.number:
            self._take_in(there)
        paddings = self._paddings(padding)
        return self._zones(there, p_WQs, np.minimum(noise, paddings), paddings)

    def within(
        self, there: BodiesThen, p_WQs: Floats, padding: float, reach: float = 0.0
    ) -> Flags:
        """Return which points (n, 3) [m] are no farther than padding and ``reach`` from bodies.

        The padding is ``padding`` [m] but of bodies that have one of their own.
        """
        if there.number != self.number:
            self._take_in(there)
        limits = self._paddings(padding) + reach
        zones = self._zones(there, p_WQs, limits, limits)
        zones.on_bodies[zones.in_shell] = True
        return zones.on_bodies

    def _zones(self, there: BodiesThen, p_WQs: Floats, noises: Floats, paddings: Floats) -> Zones:
        """Return zones by the noises (b,) and paddings (b,) [m] of bodies."""
        on_bodies = np.zeros(len(p_WQs), dtype=np.bool_)
        nothing = Zones(on_bodies, np.zeros(0, dtype=np.int64), np.zeros(0))
        if not self._bodies or not len(p_WQs):
            return nothing
        numbers = self._may_be_near(there, p_WQs, paddings)
        if not len(numbers):
            return nothing
        bodies = self._query(there)
        certain, open_ones = self._decided_by_cubes(bodies, p_WQs[numbers], noises, paddings)
        on_bodies[numbers[certain]] = True
        rest = numbers[open_ones]
        lower, is_on = np.full(len(rest), np.inf), np.zeros(len(rest), dtype=np.bool_)
        farthest = float(paddings.max())
        for rows, k, distances, bounds in self._distances(bodies, p_WQs[rest], farthest):
            is_near = distances - bounds <= paddings[k]
            np.minimum.at(lower, rows[is_near], (distances - bounds)[is_near])
            is_on[rows[distances + bounds <= noises[k]]] = True
        on_bodies[rest[is_on]] = True
        is_beside = ~is_on & (lower < np.inf)
        return Zones(on_bodies, rest[is_beside], lower[is_beside])

    def in_shadow(
        self, there: BodiesThen, origin: Floats, places: Floats, reach: float, noise: float
    ) -> Flags:
        """Return which places (n, 3) [m] bodies hide from a sensor; see ``are_in_shadow``."""
        if there.number != self.number:
            self._take_in(there)
        if not self._bodies or not len(places):
            return np.zeros(len(places), dtype=np.bool_)
        query = self._query(there)

        def distances(
            points: Floats, threshold: float
        ) -> Iterator[tuple[Indices, Indices, Floats]]:
            for rows, k, each, bounds in self._distances(query, points, threshold):
                yield rows, k, each - bounds

        return are_in_shadow(distances, self._balls(there), origin, places, reach, noise)

    def _paddings(self, usual: float) -> Floats:
        """Return the padding [m] of each body."""
        own = (body.padding for body in self._bodies)
        return np.array([usual if padding is None else padding for padding in own])

    def _decided_by_cubes(
        self, bodies: QueryObject, points: Floats, noises: Floats, paddings: Floats
    ) -> tuple[Flags, Flags]:
        """Return which points (n, 3) [m] are on bodies for sure, and of which more is open.

        A distance changes by no more than the way does: that of the centre of a small cube decides
        about all points in it, but for those about as far away as the noise, and in the shell.
        """
        edge = _SMALL * float(noises.min()) + _SMALLEST
        steps = np.floor(points / edge)
        first = steps.min(axis=0)
        counts = steps.max(axis=0) - first + 1.0
        nobody, all_of_them = np.zeros((2, len(points)), dtype=np.bool_) | [[False], [True]]
        if counts.prod() > _MOST_SMALL:
            return nobody, all_of_them
        _, a, b = counts.astype(np.int64)
        keys = (steps - first).astype(np.int64) @ [a * b, b, 1]
        _, firsts, cube_of = np.unique(keys, return_index=True, return_inverse=True)
        cubes = steps[firsts]
        if 2 * len(cubes) > len(points):
            return nobody, all_of_them
        reach = _ROOM * 0.5 * math.sqrt(3.0) * edge
        certain, is_open = np.zeros((2, len(cubes)), dtype=np.bool_)
        centres = (cubes + 0.5) * edge
        farthest = float(paddings.max()) + reach
        for rows, k, distances, bounds in self._distances(bodies, centres, farthest):
            is_open[rows] = True
            certain[rows[distances + bounds + reach <= noises[k]]] = True
        return certain[cube_of], (is_open & ~certain)[cube_of]

    def _distances(
        self, bodies: QueryObject, points: Floats, threshold: float
    ) -> Iterator[tuple[Indices, Indices, Floats, Floats]]:
        """Yield numbers of points and of bodies, distances [m], and how far off these are."""
        step = max(1, _ROWS // len(self._bodies))
        for k in range(0, len(points), step):
            results = bodies.ComputeSignedDistanceToPoint(points[k : k + step], threshold)
            rows = k + results.point_index.astype(np.int64)
            bodies_of_rows = np.searchsorted(self._ids, np.asarray(results.id_G))
            yield rows, bodies_of_rows, results.distance, results.error_bound

    def _query(self, there: BodiesThen) -> QueryObject:
        context = self._graph.CreateDefaultContext()
        rows = zip(self._frames, there.R_WFs, there.p_WFs, strict=True)
        poses = {frame: RigidTransform(RotationMatrix(R), p) for frame, R, p in rows}
        context.UpdateFramePoses(FramePoseVector(poses))
        return self._graph.get_query_output_port().Eval(context)

    def _take_in(self, there: BodiesThen) -> None:
        """Have other bodies from now on; the number is theirs once all of it is done."""
        if there.bodies is None:
            raise ArgumentError('the bodies on which points are left out were not told')
        self._stand(there.bodies.bodies, len(there.bodies.frames))
        if self._bodies:
            # Kernels are compiled with the message that brings bodies, which may take long.
            self._query(there).ComputeSignedDistanceToPoint(np.zeros((1, 3)), math.inf)
        self.number = there.number

    def _stand(self, bodies: list[Body], frames: int) -> None:
        """Make the scene anew."""
        graph = SceneGraph()
        source = graph.RegisterSource('bodies')
        own = [graph.RegisterFrame(source, GeometryFrame(f'{k}')) for k in range(frames)]
        ids = []
        for k, body in enumerate(bodies):
            instance = GeometryInstance(body.X_FG, body.shape, f'{k}')
            instance.set_proximity_properties(body.properties)
            ids.append(graph.RegisterGeometry(source, own[body.frame], instance).get_value())
        self._graph, self._frames, self._bodies = graph, own, bodies
        self._ids = np.array(ids, dtype=np.int64)

    def _balls(self, there: BodiesThen) -> Balls:
        """Return a ball around each body, where it was."""
        rows = [body.frame for body in self._bodies]
        p_FCs = np.array([body.centre for body in self._bodies])
        centres = (there.R_WFs[rows] @ p_FCs[..., np.newaxis])[..., 0] + there.p_WFs[rows]
        return Balls(centres, np.array([body.radius for body in self._bodies]))

    def _may_be_near(self, there: BodiesThen, p_WQs: Floats, paddings: Floats) -> Indices:
        """Return which points may be near: those in cubes that balls of bodies reach into."""
        centres, radii = self._balls(there)
        reach = (radii + paddings)[:, np.newaxis]
        low, high = (centres - reach).min(axis=0), (centres + reach).max(axis=0)
        if not np.isfinite(high - low).all():
            return np.arange(len(p_WQs))
        edge = max(_CUBE, float((high - low).max()) / _MOST_CUBES)
        cubes = np.zeros(_cubes(high, low, edge) + 1, dtype=np.bool_)
        firsts, lasts = _cubes(centres - reach, low, edge), _cubes(centres + reach, low, edge)
        for first, last in zip(firsts, lasts + 1, strict=True):
            cubes[tuple(map(slice, first, last))] = True
        near_rows = np.empty(len(p_WQs), dtype=np.int64)
        return near_rows[: find_in_cubes(p_WQs, Cubes(low, edge, cubes), near_rows)]


def _cubes(p_WPs: Floats, low: Floats, edge: float) -> NDArray[np.int64]:
    """Return in which cubes points (..., 3) are, from the lowest corner on: later for larger."""
    return np.asarray(np.floor((p_WPs - low) / edge), dtype=np.int64)


def _ball(query: QueryObject, geometry: GeometryId) -> tuple[Floats, float]:
    """Return a ball around a geometry, in its frame: centre and radius [m]."""
    inspector = query.inspector()
    obb = None
    if not isinstance(inspector.GetShape(geometry), HalfSpace):
        obb = inspector.GetObbInGeometryFrame(geometry)
    if obb is None:
        return np.zeros(3), np.inf
    X_FB = inspector.GetPoseInFrame(geometry) @ obb.pose()
    return np.array(X_FB.translation()), _ROOM * float(np.linalg.norm(obb.half_width()))


def _without_padding(properties: ProximityProperties) -> ProximityProperties:
    plain = ProximityProperties(properties)
    plain.RemoveProperty('proximity', 'padding')
    return plain


def bodies_of(
    query: QueryObject, sources: set[str] | None, leave_out: SourceId | None
) -> list[GeometryId]:
    """Return the geometries with the proximity role of some sources; None: of all but one.

    What hangs on a frame of a source, at any depth and of any source itself, counts as its own: a
    part that a robot carries looks to a camera as the robot does. ``part_of_robot: false`` turns
    that off.
    """
    inspector = query.inspector()

    def counts(geometry: GeometryId) -> bool:
        if inspector.GetOwningSourceId(geometry) == leave_out:
            return False
        if sources is None or inspector.GetOwningSourceName(geometry) in sources:
            return True
        return any(
            inspector.GetOwningSourceName(frame) in sources
            for frame in _carriers(inspector, inspector.GetFrameId(geometry))
        )

    return [g for g in inspector.GetAllGeometryIds(Role.kProximity) if counts(g)]


def _carriers(inspector: SceneGraphInspector, frame: FrameId) -> Iterator[FrameId]:
    """Yield a frame and all that it hangs on, without the world.

    An attached frame that is declared no part of its carrier (``part_of_robot: false``) ends it.
    """
    while frame != inspector.world_frame_id():
        yield frame
        if inspector.IsAttached(frame) and not inspector.IsPartOfParent(frame):
            return
        frame = inspector.GetParentFrame(frame)
