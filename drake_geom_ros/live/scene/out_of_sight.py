"""Bodies that no sensor of a map can see: the space near them is unknown, not free.

A map shows what is within a sensor's reach, and within a box. A body that is wholly beyond has no
distance from what is there: rules about it and the map are entered, as where nothing is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryId, QueryObject, SceneGraphInspector
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.proximity_rules import ScenePairs, UnseenBodies


class Sight(NamedTuple):
    """The region in which a sensor sees what goes into a map."""

    origin: Floats  # (3,) [m] of the sensor, in the world
    reach: float  # [m] from there
    low: Floats  # (3,) [m] corners of a box in the world
    high: Floats


# A map, and where each of its sensors can see.
MapSights = tuple[GeometryId, Sequence[Sight]]


class Balls(NamedTuple):
    """A ball around each of some geometries (n,), in its frame; without end: of none."""

    frames: NDArray[np.int64]
    centres: Floats  # (n, 3) [m]
    radii: Floats  # (n,) [m]

    @classmethod
    def around(
        cls,
        inspector: SceneGraphInspector,
        pairs: ScenePairs,
        frames: NDArray[np.int64],
        maps: Sequence[GeometryId],
    ) -> Balls:
        """Return balls around those of the geometries of pairs that a map is reported with.

        ``frames`` (n,) are those of the geometries, by the values of their ids; balls around
        others are without end.
        """
        centres, radii = np.zeros((len(frames), 3)), np.full(len(frames), np.inf)
        of_maps = np.isin(pairs.ids, [its_map.get_value() for its_map in maps])
        partners = pairs.reported.rows(np.flatnonzero(of_maps)).any(axis=0)
        for k in np.flatnonzero(partners & ~of_maps):
            geometry = GeometryId(int(pairs.ids[k]))
            obb = inspector.GetObbInGeometryFrame(geometry)
            if obb is not None:
                X_FB = inspector.GetPoseInFrame(geometry) @ obb.pose()
                centres[k] = X_FB.translation()
                radii[k] = np.linalg.norm(obb.half_width())
        return cls(frames, centres, radii)


def unseen(query: QueryObject, balls: Balls, sights: Sequence[Sight]) -> Flags:
    """Return which bodies (n,) none of the sensors can see, as far as bodies are placed."""
    flags = np.zeros(len(balls.radii), dtype=np.bool_)
    finite = np.flatnonzero(np.isfinite(balls.radii))
    if not sights or not len(finite):
        return flags
    R_WFs, p_WFs, placed = query.X_WFs(balls.frames[finite])
    centres = (R_WFs @ balls.centres[finite, :, np.newaxis])[..., 0] + p_WFs
    radii, is_seen = balls.radii[finite], ~np.asarray(placed, dtype=np.bool_)
    for origin, reach, low, high in sights:
        near = np.linalg.norm(centres - origin, axis=1) - radii <= reach
        room = radii[:, np.newaxis]
        is_seen |= near & ((centres >= low - room) & (centres <= high + room)).all(axis=1)
    flags[finite] = ~is_seen
    return flags


def unseen_bodies(
    query: QueryObject, balls: Balls, maps: Sequence[MapSights], pairs: ScenePairs
) -> UnseenBodies:
    """Return which geometries of ``pairs`` the sensors of each map can see.

    ``balls`` are of the geometries, in their order.
    """
    ids = [its_map.get_value() for its_map, _ in maps]
    rows = np.searchsorted(pairs.ids, ids)
    there = np.flatnonzero((rows < len(pairs.ids)) & np.isin(ids, pairs.ids))
    rows = rows[there]
    flags = [unseen(query, balls, maps[k][1]) for k in there.tolist()]
    is_unseen = np.array(flags, dtype=np.bool_).reshape(len(rows), len(balls.radii))
    return UnseenBodies(rows, is_unseen, pairs.reported.rows(rows))
