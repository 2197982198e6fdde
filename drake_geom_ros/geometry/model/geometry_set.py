"""``GeometrySet``: geometries by their own ids or by the frames they are on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from drake_geom_ros.geometry.errors import ArgumentTypeError
from drake_geom_ros.geometry.ids import FrameId, GeometryId


class GeometrySet:
    """Geometry ids, and frame ids that stand for all geometries on the frame.

    Made from one id, from a sequence of ids (both kinds may be mixed), or from both kinds by
    keyword. A frame is resolved to geometries when the set is used; ids are not checked before.

        >>> finger, thumb, palm = GeometryId(1), GeometryId(2), FrameId(3)
        >>> hand = GeometrySet(geometry_ids=[finger, thumb], frame_ids=[palm])
    """

    __slots__ = ('_frame_ids', '_geometry_ids')

    def __init__(
        self,
        ids: FrameId | GeometryId | Iterable[FrameId | GeometryId] = (),
        frame_ids: Iterable[FrameId] = (),
        *,
        geometry_ids: Iterable[GeometryId] = (),
        geometry_id: GeometryId | None = None,
        frame_id: FrameId | None = None,
    ) -> None:
        self._geometry_ids: set[GeometryId] = set()
        self._frame_ids: set[FrameId] = set()
        self.Add(
            ids, frame_ids, geometry_ids=geometry_ids, geometry_id=geometry_id, frame_id=frame_id
        )

    def Add(
        self,
        ids: FrameId | GeometryId | Iterable[FrameId | GeometryId] = (),
        frame_ids: Iterable[FrameId] = (),
        *,
        geometry_ids: Iterable[GeometryId] = (),
        geometry_id: GeometryId | None = None,
        frame_id: FrameId | None = None,
    ) -> None:
        """Add ids; raises RuntimeError and adds none if one is of another kind."""
        mixed = [ids] if isinstance(ids, (FrameId, GeometryId)) else _listed(ids)
        geometries = _listed(geometry_ids) + ([] if geometry_id is None else [geometry_id])
        frames = _listed(frame_ids) + ([] if frame_id is None else [frame_id])
        for values, kinds in (
            (mixed, (FrameId, GeometryId)),
            (geometries, (GeometryId,)),
            (frames, (FrameId,)),
        ):
            for value in values:
                if not isinstance(value, kinds):
                    allowed = ' or '.join(kind.__name__ for kind in kinds)
                    raise ArgumentTypeError(f'GeometrySet: {value!r} must be a {allowed}')
        self._geometry_ids.update(geometries)
        self._frame_ids.update(frames)
        if mixed:
            self._geometry_ids.update(i for i in mixed if isinstance(i, GeometryId))
            self._frame_ids.update(i for i in mixed if isinstance(i, FrameId))

    def __repr__(self) -> str:
        geometries, frames = sorted(self._geometry_ids), sorted(self._frame_ids)
        return f'GeometrySet(geometry_ids={geometries}, frame_ids={frames})'


def members_of(geometry_set: GeometrySet) -> tuple[set[GeometryId], set[FrameId]]:
    """Return the ids of a set, by reference."""
    return geometry_set._geometry_ids, geometry_set._frame_ids


def _listed(ids: Any) -> list[Any]:
    """Return the ids as a list; raises RuntimeError if they are not iterable."""
    try:
        return list(ids)
    except TypeError:
        raise ArgumentTypeError(f'GeometrySet: {ids!r} must be an id or ids') from None
