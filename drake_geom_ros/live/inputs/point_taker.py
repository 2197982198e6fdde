"""Makes cells of the points that sensors measured: clouds, depth images, scans and ranges.

It has no scene: its owner gives the poses of the sensor and the bodies, and takes the cells.
Therefore it may work in a process of its own.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.depth_image import points_from_depth
from drake_geom_ros.live.conversions.laser_scan import (
    duration_of_scan,
    points_of_scan,
    unturned,
)
from drake_geom_ros.live.conversions.message_types import (
    CloudMessage,
    HeaderMessage,
    RangeMessage,
    ScanMessage,
)
from drake_geom_ros.live.conversions.point_cloud import Columns, columns_of_cloud
from drake_geom_ros.live.conversions.range_cone import points_of_range
from drake_geom_ros.live.inputs.obstacle_records import (
    Found,
    Held,
    MapCounts,
    ObstacleSettings,
    Place,
)
from drake_geom_ros.live.scene.feeds import MOST_FEEDS
from drake_geom_ros.live.scene.self_filter import SelfFilter, Zones
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.sensed_maps.cells import Cells, Keys, keys_of
from drake_geom_ros.sensed_maps.keeping import KeptCells, seen_through
from drake_geom_ros.sensed_maps.looking_past import rays_past
from drake_geom_ros.sensed_maps.passes import Reached, as_columns, keep_in_box, put_within_reach
from drake_geom_ros.sensed_maps.shell import Shell

MOST_POINTS = 5_000_000  # of a message
_MOST_CAMERAS = MOST_FEEDS  # whose camera_info is kept


class Map(Protocol):
    """The owner of the scene of a map; both methods raise RuntimeError to refuse a message."""

    def begin(
        self,
        header: HeaderMessage,
        waited: float,
        bodies_number: int,
        publisher: str,
        duration: float = 0.0,
    ) -> Place:
        """Return where the frame of a header was, of a message that came ``waited`` [s] ago.

        Raises UnknownYetError where that may be known later. Bodies of the number
        ``bodies_number`` are not sent again. Each ``publisher`` has its own map. ``duration`` [s]
        is for how long it was measured, from its stamp on.
        """

    def finish(self, taken: Found) -> None:
        """Put cells and shell into the scene, for the message that was begun last."""


class PointTaker:
    """Takes the messages of one topic; what is refused by RuntimeError changes nothing."""

    def __init__(self, its_map: Map) -> None:
        self._map = its_map
        self.filter = SelfFilter()
        self._held: dict[tuple[str, str], Held] = {}  # by sensor
        self._cameras: dict[str, Any] = {}  # by frame
        # For points in the world: as large as the largest message was, for to map memory anew for
        # each takes as long as what is done with it.
        self._room = np.empty((0, 3))

    def take_cloud(self, cloud: CloudMessage, waited: float = 0.0, publisher: str = '') -> None:
        """Take a PointCloud2 that came ``waited`` [s] ago; raises RuntimeError to refuse it."""
        if cloud.width * cloud.height > MOST_POINTS:
            raise ArgumentError(
                f'the cloud has {cloud.height} rows of {cloud.width} points; at most '
                f'{MOST_POINTS} are taken'
            )
        self._take_points(columns_of_cloud(cloud), cloud.header, waited, publisher)

    def take_camera(self, info: Any, waited: float = 0.0, publisher: str = '') -> None:
        """Keep a CameraInfo for the images of its frame that follow."""
        self._cameras.pop(info.header.frame_id, None)
        self._cameras[info.header.frame_id] = info
        if len(self._cameras) > _MOST_CAMERAS:
            del self._cameras[next(iter(self._cameras))]

    def take_depth(self, image: Any, waited: float = 0.0, publisher: str = '') -> None:
        """Take an Image of depths, as ``take_cloud`` does."""
        if image.width * image.height > MOST_POINTS:
            raise ArgumentError(
                f'the image has {image.height} rows of {image.width} pixels; at most '
                f'{MOST_POINTS} are taken'
            )
        if not self._cameras:
            raise ArgumentError('no camera_info came before the image, so its rays are unknown')
        camera = self._cameras.get(image.header.frame_id)
        if camera is None:
            raise ArgumentError(
                f'the image is in frame {image.header.frame_id[:80]!r}, and camera_info in '
                f'{next(reversed(self._cameras))[:80]!r}'
            )
        x, y, z = points_from_depth(image, camera).T[:, np.newaxis]
        self._take_points((x, y, z), image.header, waited, publisher)

    def take_scan(self, scan: ScanMessage, waited: float = 0.0, publisher: str = '') -> None:
        """Take a LaserScan, as ``take_cloud`` does; each ray where the sensor was at its time."""
        if len(scan.ranges) > MOST_POINTS:
            raise ArgumentError(
                f'the scan has {len(scan.ranges)} rays; at most {MOST_POINTS} are taken'
            )
        points, duration = points_of_scan(scan), duration_of_scan(scan)
        place = self._map.begin(scan.header, waited, self.filter.number, publisher, duration)
        ends = points
        if has_passed := bool(np.isposinf(np.asarray(scan.ranges)).any()):
            ends = points_of_scan(scan, min(scan.range_max, place.settings.reach))
        if place.turn is not None:
            points, ends = unturned(points, *place.turn), unturned(ends, *place.turn)
        is_end = np.isnan(points[:, 0]) & np.isfinite(ends[:, 0])
        passed = ends[is_end] if has_passed else None
        self._take_placed(_columns(points), place, scan.range_max, passed)

    def take_range(self, message: RangeMessage, waited: float = 0.0, publisher: str = '') -> None:
        """Take a Range, as ``take_cloud`` does; one without an echo empties the map."""
        place = self._map.begin(message.header, waited, self.filter.number, publisher)
        spacing = 0.5 * place.settings.resolution
        points, passed = points_of_range(message, spacing), None
        if not len(points):
            far = min(message.max_range, place.settings.reach)
            passed = points_of_range(message, spacing, far)
        self._take_placed(_columns(points), place, message.max_range, passed)

    def _take_points(
        self, columns: Columns, header: HeaderMessage, waited: float, publisher: str
    ) -> None:
        place = self._map.begin(header, waited, self.filter.number, publisher)
        passed = np.zeros((0, 3)) if place.settings.may_be_empty else None
        if place.in_sensor is not None:
            columns = _moved(columns, *place.in_sensor)
        self._take_placed(columns, place, passed=passed)

    def _take_placed(
        self,
        columns: Columns,
        place: Place,
        sensor_range: float = np.inf,
        passed: Floats | None = None,
    ) -> None:
        """Take points in the frame of a place.

        ``passed`` (n, 3) [m] are the ends of rays that met nothing. None: all rays that met
        nothing may have been covered, and a message without points is refused.
        """
        count, settings = columns[0].size, place.settings
        if len(self._room) < count:
            self._room = np.empty((count, 3))
        columns = as_columns(columns)
        reached = put_within_reach(columns, place.R_WF, place.p_WF, settings.reach, self._room)
        p_WQs = self._room[: reached.kept]
        # Before any refusal: bodies are taken in by this, and not told anew with each message.
        zones = self.filter.zones(place.bodies, p_WQs, settings.noise, settings.padding)
        if not reached.finite and passed is None:
            raise ArgumentError(f'none of its {count} points is finite: it shows nothing')
        if zones.on_bodies.all() and passed is None:
            raise ArgumentError('all of its points lie on bodies that the scene knows')
        beside = _Beside.of(p_WQs, zones, settings)
        away = _away_from_bodies(p_WQs, zones, settings)
        shown, points_in = Cells.counted(p_WQs[: away.kept], settings.resolution)
        enough, is_shell = beside.enough(shown, points_in, settings)
        cells = Cells(shown.resolution, shown.packed[enough])
        before = self._before(place, cells.resolution)
        free = None
        if settings.rays and before is not None and len(before.kept.cells):
            free = self._free(place, cells, passed)
        hidden = None if before is None else self._hidden(place, before.kept, cells)
        held_cells = _kept(place, before, cells, free, shown.packed[~enough], hidden)
        new = beside.shell(is_shell, shown.resolution, place.held)
        shell = (
            new
            if before is None
            else self._with_shell(
                place, before, held_cells, new, free, _with_ends(columns, passed)
            )
        )
        of_shadow = _shadow(held_cells, before, hidden)
        in_none = ~np.isin(shown.packed, held_cells.cells.packed, assume_unique=True)
        counts = MapCounts(
            points=count,
            not_finite=count - reached.finite,
            out_of_reach=reached.finite - reached.kept,
            on_bodies=int(np.count_nonzero(zones.on_bodies)),
            in_shell=len(beside.points),
            out_of_box=away.finite - away.kept + beside.out_of_box,
            in_sparse_cells=int(points_in[in_none].sum()),
            cells=len(held_cells.cells),
            held_cells=len(held_cells.cells) - len(cells),
            shell_cells=len(shell.cells),
            held_shell_cells=len(shell.cells) - len(new.cells),
            shadow_cells=len(of_shadow),
        )
        nearest = float(beside.distances.min(initial=np.inf))
        self._map.finish(Found(held_cells, counts, shell, nearest, sensor_range, of_shadow))
        self._held.pop(place.feed, None)  # the last one heard of is the last to be forgotten
        self._held[place.feed] = Held(held_cells, place.epoch, place.generation, shell)
        if len(self._held) > 2 * MOST_FEEDS:
            del self._held[next(iter(self._held))]

    def _free(self, place: Place, cells: Cells, passed: Floats | None) -> Keys:
        """Return the keys of cells that rays to cells, and those that met nothing, traverse."""
        free = seen_through(place.p_WF, cells)
        if passed is None or not len(passed):
            return free
        # The last two cells of a ray stay, so the ends may be any.
        ends = Cells.of_points(passed @ place.R_WF.T + place.p_WF, cells.resolution)
        return np.union1d(free, seen_through(place.p_WF, ends))

    def _before(self, place: Place, resolution: float) -> Held | None:
        """Return the cells of the previous message that still hold."""
        held = place.before or self._held.get(place.feed)
        if held is None or held.generation != place.generation:
            return None
        if held.kept.cells.resolution != resolution:
            return None
        if held.epoch == place.epoch:
            return held
        # The node's time jumped: nobody knows how long ago cells were seen, so they stay
        # for as long as if that was now.
        cells, shell = held.kept.as_seen_at(place.held), held.shell.as_seen_at(place.held)
        return held._replace(kept=cells, shell=shell)

    def _with_shell(
        self,
        place: Place,
        before: Held,
        held_cells: KeptCells,
        new: Shell,
        free: Keys | None,
        columns: Columns,
    ) -> Shell:
        """Return the new shell, and the cells of before that vanished beside bodies.

        Such a cell stays until the sensor looks past it, ``keep`` ends, where it is not 0, or no
        body is near it: then the map alone says what is there. In the shadow of a body it stays
        for ``keep_hidden``.
        """
        settings = place.settings
        old = before.shell.and_others(Shell.of_map(before.kept.without(held_cells.cells)))
        old = old.without(held_cells.cells.packed).without(new.cells.packed)
        if free is not None:
            old = old.without(free)
        stays = self.filter.within(place.bodies, old.places, settings.padding, old.reach)
        if 0.0 < settings.keep < np.inf:
            stays &= place.held - old.seen <= settings.keep
        may_hide = ~stays & (place.held - old.seen <= settings.keep_hidden)
        stays[may_hide] = self._in_shadow(place, old.places[may_hide], old.reach)
        old = old.among(stays)
        if len(old.cells) and not _is_world(place):
            p_FPs = (old.places - place.p_WF) @ place.R_WF
            rays = rays_past(columns, p_FPs, 0.5 * settings.resolution, settings.noise)
            old = old.among(rays < settings.least_points)
        return new.and_others(old)

    def _hidden(self, place: Place, before: KeptCells, new: Cells) -> Flags:
        """Return which cells of before that are not among the new ones bodies hide.

        Those beside bodies are left out: they are the shell's.
        """
        hidden = ~np.isin(before.cells.packed, new.packed, assume_unique=True)
        old = Shell.of_map(before.among(hidden))
        is_hidden = self._in_shadow(place, old.places, old.reach)
        places = old.places[is_hidden]
        is_beside = self.filter.within(place.bodies, places, place.settings.padding, old.reach)
        is_hidden[is_hidden] = ~is_beside
        hidden[hidden] = is_hidden
        return hidden

    def _in_shadow(self, place: Place, places: Floats, reach: float) -> Flags:
        """Return which places (n, 3) [m] within the range of the sensor bodies hide from it."""
        flags = np.zeros(len(places), dtype=np.bool_)
        if _is_world(place):
            return flags
        ways = places - place.p_WF
        near = np.linalg.norm(ways, axis=1) <= place.settings.reach
        flags[near] = self.filter.in_shadow(
            place.bodies, place.p_WF, places[near], reach, place.settings.noise
        )
        return flags


def _columns(points: Floats) -> Columns:
    """Return points (n, 3) [m] as x, y and z (1, n)."""
    x, y, z = points.T[:, np.newaxis]
    return x, y, z


def _moved(columns: Columns, R: Floats, p: Floats) -> Columns:
    """Return points, given as x, y and z (a, b) [m], after a rotation and a shift (3,) [m]."""
    points = np.stack([np.asarray(column, dtype=np.float64).ravel() for column in columns], axis=1)
    with np.errstate(invalid='ignore'):  # points that are not finite stay so
        return _columns(points @ R.T + p)


def _with_ends(columns: Columns, passed: Floats | None) -> Columns:
    """Return the ends of all rays: the points that some met, and where others ended."""
    if passed is None or not len(passed):
        return columns
    flat = (np.concatenate([c.ravel(), p]) for c, p in zip(columns, passed.T, strict=True))
    x, y, z = (each[np.newaxis] for each in flat)
    return as_columns((x, y, z))


def _shadow(held: KeptCells, before: Held | None, hidden: Flags | None) -> Keys:
    """Return the keys of held cells that bodies hide."""
    if before is None or hidden is None:
        return held.cells.packed[:0]
    return np.intersect1d(before.kept.cells.packed[hidden], held.cells.packed, assume_unique=True)


def _is_world(place: Place) -> bool:
    """Return whether the sensor is unknown: points came in the world's frame."""
    return (
        place.in_sensor is None and not place.p_WF.any() and np.array_equal(place.R_WF, np.eye(3))
    )


def _away_from_bodies(p_WQs: Floats, zones: Zones, settings: ObstacleSettings) -> Reached:
    """Move the points (n, 3) [m] to the front that make the map; those beside bodies if alone."""
    left_out = zones.on_bodies.copy()
    left_out[zones.in_shell] = True
    away = keep_in_box(p_WQs, left_out, *settings.corners())
    return away if away.finite else keep_in_box(p_WQs, zones.on_bodies, *settings.corners())


def _kept(
    place: Place,
    before: Held | None,
    cells: Cells,
    free: Keys | None,
    sparse: Keys,
    hidden: Flags | None,
) -> KeptCells:
    """Return cells, and those of before that are held; ``sparse`` ones only hold."""
    held = KeptCells.none(cells.resolution) if before is None else before.kept
    settings = place.settings
    return held.and_then(
        cells, place.held, settings.keep, free, sparse, hidden, settings.keep_hidden
    )


class _Beside(NamedTuple):
    """The points (m, 3) [m] beside bodies, their distances (m,) [m], and how many the box cut."""

    points: Floats
    distances: Floats
    out_of_box: int

    @classmethod
    def of(cls, p_WQs: Floats, zones: Zones, settings: ObstacleSettings) -> _Beside:
        points, (low, high) = p_WQs[zones.in_shell], settings.corners()
        inside = np.asarray(((points >= low) & (points <= high)).all(axis=1))
        out = int(np.count_nonzero(~inside))
        return cls(points[inside], zones.distances[inside], out)

    def enough(
        self, shown: Cells, points_in: Keys, settings: ObstacleSettings
    ) -> tuple[Flags, Flags]:
        """Return which cells of the map have enough points, and which points are in such cells.

        Points of a cell count together, wherever the shell ends in it.
        """
        least = settings.least_points
        if not len(self.points):  # as of most clouds
            enough = points_in >= settings.least_points
            return enough | (not enough.any()), np.zeros(0, dtype=np.bool_)
        cells, count = Cells.counted(self.points, shown.resolution)
        both = np.intersect1d(shown.packed, cells.packed, assume_unique=True, return_indices=True)
        together, together_beside = points_in.copy(), count.copy()
        together[both[1]] += count[both[2]]
        together_beside[both[2]] += points_in[both[1]]
        enough, beside = together >= least, together_beside >= least
        if not enough.any():  # a thin cloud is no empty room
            enough[:] = True
            beside[:] |= not beside.any()
        is_in = np.searchsorted(cells.packed, keys_of(self.points, shown.resolution))
        return enough, beside[is_in]

    def shell(self, is_shell: Flags, resolution: float, now: float) -> Shell:
        """Return the cells of the points that are flagged."""
        return Shell.of_points(self.points[is_shell], self.distances[is_shell], resolution, now)
