"""Makes cells of the points that sensors measured: of clouds, and of depth images.

It knows no scene: whoever has one tells where the sensor and the bodies were, and takes the cells.
So it may work in a process of its own. No ROS import.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.ros.conversions.depth_image import points_from_depth
from drake_geom_ros.ros.conversions.point_cloud import Columns, columns_of_cloud
from drake_geom_ros.ros.inputs.obstacle_records import Found, Held, MapCounts, Place
from drake_geom_ros.ros.scene.self_filter import SelfFilter
from drake_geom_ros.sensed_maps.cells import Cells, Keys
from drake_geom_ros.sensed_maps.keeping import KeptCells, seen_through
from drake_geom_ros.sensed_maps.passes import as_columns, keep_in_box, put_within_reach

MOST_POINTS = 5_000_000  # of a message


class Map(Protocol):
    """Who has the scene that a map is in; both raise RuntimeError to refuse a message."""

    def begin(self, header: Any, waited: float, known: int) -> Place:
        """Return where the frame of a header was, of a message that came ``waited`` [s] ago.

        Bodies of the number ``known`` are not told again.
        """

    def finish(self, found: Found) -> None:
        """Put what was found into the scene, for the message that was begun last."""


class PointTaker:
    """Takes the messages of one topic; what is refused by RuntimeError changes nothing."""

    def __init__(self, its_map: Map) -> None:
        self._map = its_map
        self.filter = SelfFilter()
        self._held: Held | None = None
        self._camera: Any = None
        # For points in the world: as large as the largest message was, for to map memory anew for
        # each takes as long as what is done with it.
        self._room = np.empty((0, 3))

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

    def _take_points(self, columns: Columns, header: Any, waited: float) -> None:
        place = self._map.begin(header, waited, self.filter.number)
        count, settings = columns[0].size, place.settings
        if len(self._room) < count:
            self._room = np.empty((count, 3))
        reached = put_within_reach(
            as_columns(columns), place.R_WF, place.p_WF, settings.reach, self._room
        )
        p_WQs = self._room[: reached.kept]
        # Before any refusal: bodies are taken in by this, and not told anew with each message.
        on_bodies = self.filter.near(place.bodies, p_WQs, settings.padding)
        if not reached.finite:
            raise ArgumentError(f'none of its {count} points is finite: it shows nothing')
        away = keep_in_box(p_WQs, on_bodies, *settings.corners())
        if not away.finite:
            raise ArgumentError('all of its points lie on bodies that the scene knows')
        shown, points_in = Cells.counted(p_WQs[: away.kept], settings.resolution)
        enough = points_in >= settings.least_points
        if not enough.any():  # a thin cloud is no empty room
            enough[:] = True
        cells = Cells(shown.resolution, shown.packed[enough])
        kept = self._with_kept(place, cells, shown.packed[~enough])
        in_none = ~np.isin(shown.packed, kept.cells.packed, assume_unique=True)
        counts = MapCounts(
            points=count,
            not_finite=count - reached.finite,
            out_of_reach=reached.finite - reached.kept,
            on_bodies=reached.kept - away.finite,
            out_of_box=away.finite - away.kept,
            in_sparse_cells=int(points_in[in_none].sum()),
            cells=len(kept.cells),
            held_cells=len(kept.cells) - len(cells),
        )
        self._map.finish(Found(kept, counts))
        self._held = Held(kept, place.epoch, place.generation)

    def _with_kept(self, place: Place, cells: Cells, sparse: Keys) -> KeptCells:
        """Return cells, and those of before that are held; ``sparse`` ones only hold."""
        held, settings = place.before or self._held, place.settings
        if held is None or held.generation != place.generation:
            before = KeptCells.none(cells.resolution)
        elif held.epoch != place.epoch:
            # The node's time jumped: nobody knows how long ago cells were seen, so they stay
            # for as long as if that was now.
            before = held.kept.as_seen_at(place.held)
        else:
            before = held.kept
        free = None
        if settings.rays and len(before.cells):
            free = seen_through(place.p_WF, cells)
        return before.and_then(cells, place.held, settings.keep, free, sparse)
