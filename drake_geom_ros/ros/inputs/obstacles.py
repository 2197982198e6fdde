"""What sensors saw, taken into the scene: clouds, depth images and OctoMaps.

A message is taken whole or refused whole, and then the map of before stays, and grows old. One
that shows nothing is refused: a covered lens sees no more than an empty room. No ROS import.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, QueryObject
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.conversions.depth_image import points_from_depth
from drake_geom_ros.ros.conversions.octomap import cells_from_octomap, refuse_too_many_nodes
from drake_geom_ros.ros.conversions.point_cloud import Columns, columns_of_cloud
from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.ros.scene.moments import Hanging, Moment, moment_of
from drake_geom_ros.ros.scene.seen_maps import Sighting, put, shape_of
from drake_geom_ros.ros.scene.self_filter import SelfFilter, bodies_of
from drake_geom_ros.sensed_maps.cells import Cells
from drake_geom_ros.sensed_maps.keeping import KeptCells, seen_through
from drake_geom_ros.sensed_maps.passes import as_columns, keep_in_box, put_within_reach

POINTS, DEPTH, OCTOMAP = 'points', 'depth', 'octomap'
INPUTS = (POINTS, DEPTH, OCTOMAP)
SELF_FILTERS = ('none', 'robots', 'scene')
MOST_POINTS = 5_000_000  # of a message
MOST_NODES = 3_000_000  # of a tree in a message: reading it costs a microsecond a node
Floats = NDArray[np.float64]


class ObstacleSettings(NamedTuple):
    """How maps are made; see the parameters obstacle_..."""

    resolution: float  # [m]
    reach: float  # [m] from the sensor
    padding: float  # [m]
    self_filter: str
    least_points: int
    keep: float  # [s]
    rays: bool
    margin: float  # [m]
    box: tuple[float, ...] = ()  # its corners (6,) [m] in the world; none: no limit

    def corners(self) -> tuple[Floats, Floats]:
        """Return the corners (3,), (3,) [m] of what is taken, in the world."""
        limits = self.box or (*3 * [-np.inf], *3 * [np.inf])
        return np.array(limits[:3]), np.array(limits[3:])


@dataclass(frozen=True)
class MapCounts:
    """What became of the messages of a map, and of the points of the last one."""

    taken: int = 0
    seconds: float = 0.0  # that the last one took, from its callback until it was in the scene
    points: int = 0
    not_finite: int = 0
    out_of_reach: int = 0
    on_bodies: int = 0
    out_of_box: int = 0
    in_sparse_cells: int = 0  # in cells with fewer points than make one occupied
    cells: int = 0
    held_cells: int = 0  # of these, that the last one did not show


class _Seen(NamedTuple):
    """What a message showed, which may be refused yet."""

    cells: Cells
    X_WM: RigidTransform
    counts: MapCounts
    start: float  # [s] when its taking began
    generation: int  # of the map, then
    kept: KeptCells | None = None  # with the next ones


class ObstacleInput:
    """Makes one map of the messages of a topic."""

    def __init__(
        self,
        name: str,
        live: LiveScene,
        settings: Callable[[], ObstacleSettings],
        hanging: Hanging,
        changed: Callable[[], None],
    ) -> None:
        """``hanging`` tells where a frame is; ``changed()`` is called when the scene has a map."""
        self.name = name
        self.counts = MapCounts()
        self._live = live
        self._settings = settings
        self._hanging = hanging
        self._changed = changed
        self._filter = SelfFilter()
        self._kept: KeptCells | None = None
        self._kept_epoch = -1.0  # of the node's time
        self._generation = 0  # how often it was cleared
        self._camera: Any = None
        # For points in the world: as large as the largest message was, for to map memory anew for
        # each takes as long as what is done with it.
        self._room = np.empty((0, 3))

    def forget(self) -> None:
        """Hold nothing of before, nor what is being made; the scene is held."""
        self._kept, self._generation = None, self._generation + 1
        self.counts = MapCounts()

    def take_cloud(self, cloud: Any, waited: float = 0.0) -> None:
        """Take a PointCloud2 that came ``waited`` [s] ago; raises RuntimeError to refuse it."""
        if cloud.width * cloud.height > MOST_POINTS:
            raise ArgumentError(
                f'the cloud has {cloud.height} rows of {cloud.width} points; at most '
                f'{MOST_POINTS} are taken'
            )
        self._take_points(columns_of_cloud(cloud), cloud.header, waited)

    def take_camera(self, info: Any, waited: float = 0.0) -> None:
        """Keep a CameraInfo for the images that follow."""
        self._camera = info

    def take_depth(self, image: Any, waited: float = 0.0) -> None:
        """Take an Image of depths, as ``take_cloud`` does."""
        if image.width * image.height > MOST_POINTS:
            raise ArgumentError(
                f'the image has {image.height} rows of {image.width} pixels; at most '
                f'{MOST_POINTS} are taken'
            )
        if self._camera is None:
            raise ArgumentError('no camera_info came before the image, so its rays are unknown')
        if self._camera.header.frame_id != image.header.frame_id:
            raise ArgumentError(
                f'the image is in frame {image.header.frame_id[:80]!r}, and camera_info in '
                f'{self._camera.header.frame_id[:80]!r}'
            )
        x, y, z = points_from_depth(image, self._camera).T[:, np.newaxis]
        self._take_points((x, y, z), image.header, waited)

    def take_octomap(self, octomap: Any, waited: float = 0.0) -> None:
        """Take an Octomap in place of the map of before, as it is; raises RuntimeError."""
        start = time.perf_counter()
        refuse_too_many_nodes(octomap, MOST_NODES)
        generation, cells = self._generation, cells_from_octomap(octomap)
        if not len(cells):
            raise ArgumentError('the tree has no occupied cell: it shows nothing')
        moment = moment_of(self._live, octomap.header, waited, self._hanging, lambda query: ())
        taken = _cells_in_box(cells, moment.X_WF, self._settings())
        beyond = len(cells) - len(taken)
        counts = MapCounts(points=len(cells), out_of_box=beyond, cells=len(taken))
        cells = taken
        self._put(moment, _Seen(cells, moment.X_WF, counts, start, generation))

    def _take_points(self, columns: Columns, header: Any, waited: float) -> None:
        start = time.perf_counter()
        generation, settings = self._generation, self._settings()
        bodies: list[GeometryId] = []

        def frames_of_bodies(query: QueryObject) -> set[FrameId]:
            bodies[:] = self._bodies(query, settings.self_filter)
            return {query.inspector().GetFrameId(geometry) for geometry in bodies}

        moment = moment_of(self._live, header, waited, self._hanging, frames_of_bodies)
        count = columns[0].size
        if len(self._room) < count:
            self._room = np.empty((count, 3))
        R_WF, origin = moment.X_WF.rotation().matrix(), np.array(moment.X_WF.translation())
        reached = put_within_reach(
            as_columns(columns), np.array(R_WF), origin, settings.reach, self._room
        )
        if not reached.finite:
            raise ArgumentError(f'none of its {count} points is finite: it shows nothing')
        p_WQs = self._room[: reached.kept]
        on_bodies = self._filter.near(moment.query, bodies, p_WQs, settings.padding)
        away = keep_in_box(p_WQs, on_bodies, *settings.corners())
        if not away.finite:
            raise ArgumentError('all of its points lie on bodies that the scene knows')
        seen = p_WQs[: away.kept]
        cells, held = Cells.counted(seen, settings.resolution)
        enough = held >= settings.least_points
        if not enough.any():  # a thin cloud is no empty room
            enough[:] = True
        cells = Cells(cells.resolution, cells.packed[enough])
        kept = self._with_kept(moment, cells, origin, settings)
        counts = MapCounts(
            points=count,
            not_finite=count - reached.finite,
            out_of_reach=reached.finite - reached.kept,
            on_bodies=reached.kept - away.finite,
            out_of_box=away.finite - away.kept,
            in_sparse_cells=int(held[~enough].sum()),
            cells=len(kept.cells),
            held_cells=len(kept.cells) - len(cells),
        )
        self._put(moment, _Seen(kept.cells, RigidTransform(), counts, start, generation, kept))

    def _with_kept(
        self, moment: Moment, cells: Cells, origin: Floats, settings: ObstacleSettings
    ) -> KeptCells:
        before, epoch = self._kept or KeptCells.none(cells.resolution), moment.since.epoch
        if self._kept_epoch != epoch:
            # The node's time jumped: nobody knows how long ago cells were seen, so they stay
            # for as long as if that was now.
            before, self._kept_epoch = before.as_seen_at(moment.since.held), epoch
        free = None
        if settings.rays and len(before.cells):
            free = seen_through(origin, cells)
        return before.and_then(cells, moment.since.held, settings.keep, free)

    def _bodies(self, query: QueryObject, which: str) -> list[GeometryId]:
        """Return the geometries on which points are left out."""
        if which == 'none':
            return []
        with self._live.reading() as scene:
            sources = scene.robot_names() if which == 'robots' else None
            return bodies_of(query, sources, scene.maps_source)

    def _put(self, moment: Moment, seen: _Seen) -> None:
        """Have the scene hold what was seen; what is kept and counted changes with it."""
        margin = self._settings().margin
        shape = shape_of(seen.cells, margin)
        sighting = Sighting(seen.cells, shape, seen.X_WM, moment.since, moment.stamp)
        with self._live.editing() as scene:
            if seen.generation != self._generation:
                raise ArgumentError('the map was cleared while the message was taken')
            if moment.replaced != scene.replaced:
                raise ArgumentError('the scene was replaced while the message was taken')
            known = scene.maps.get(self.name)
            since = None if known is None else scene.posed_since(known.frame)
            if since is not None and since.epoch == moment.since.epoch:
                behind = since.held - moment.since.held
                if behind > 0.0:
                    raise ArgumentError(
                        f'its stamp is {behind:.3f} s before that of the map that is there'
                    )
            put(scene, self.name, sighting, margin)
            self._kept = seen.kept
            taken, seconds = self.counts.taken + 1, time.perf_counter() - seen.start
            self.counts = replace(seen.counts, taken=taken, seconds=seconds)
        self._changed()


def _cells_in_box(cells: Cells, X_WM: RigidTransform, settings: ObstacleSettings) -> Cells:
    """Return the cells that reach into the box of settings, or the nearest to it."""
    low, high = settings.corners()
    p_WCs = X_WM.multiply(cells.centres().T).T
    reach = 0.5 * cells.resolution * np.abs(X_WM.rotation().matrix()).sum(axis=1)
    beyond = np.maximum(low - reach - p_WCs, p_WCs - reach - high).max(axis=1)
    return Cells(cells.resolution, cells.packed[beyond <= max(0.0, float(beyond.min()))])
