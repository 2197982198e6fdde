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
from drake_geom_ros.proximity_rules import Measured, ScenePairs


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


def with_unseen(
    measured: Measured,
    query: QueryObject,
    balls: Balls,
    maps: Sequence[MapSights],
    pairs: ScenePairs,
) -> Measured:
    """Return what was measured, and that nothing is known of unseen bodies and the maps.

    ``balls`` are of the geometries of ``pairs``, in their order.
    """
    flags = unseen(query, balls, [sight for _, sights in maps for sight in sights])
    if not flags.any():  # as in most cycles
        return measured
    ids = []
    for its_map, _ in maps:
        own = np.flatnonzero(pairs.ids == its_map.get_value())
        for row in np.flatnonzero(flags & pairs.reported.rows(own).any(axis=0)):
            ids.append(sorted((int(pairs.ids[row]), its_map.get_value())))
    if not ids:
        return measured
    more, count = np.array(ids, dtype=np.int64), len(ids)
    unknown, nowhere = np.full(count, np.nan), np.full((count, 3), np.nan)
    speeds = measured.closing_speed
    return measured._replace(
        id_A=np.concatenate([measured.id_A, more[:, 0]]),
        id_B=np.concatenate([measured.id_B, more[:, 1]]),
        distance=np.concatenate([measured.distance, unknown]),
        error_bound=np.concatenate([measured.error_bound, np.zeros(count)]),
        p_WCa=np.concatenate([measured.p_WCa, nowhere]),
        p_WCb=np.concatenate([measured.p_WCb, nowhere]),
        closing_speed=None if speeds is None else np.concatenate([speeds, unknown]),
    )
