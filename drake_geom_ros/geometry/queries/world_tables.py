"""Tables of frames and geometries of a model, from which a world is built."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.world.pose_rounding import TURN, shift_of, taken_roundings
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import (
    FrameTable,
    GeometryTable,
    PointShapes,
    World,
)
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import GeometryRecord
from drake_geom_ros.geometry.shapes.primitives import PackedShape
from drake_geom_ros.math.array_types import Floats, Indices

_LARGE = 1 << 16  # numbers: half a megabyte
MUCH = 4  # times the changed geometries: from a scene that is no larger all is made again


class ModelMark(NamedTuple):
    """The versions of the model that a world was built from."""

    frames: int
    frame_order: int
    proximity: int

    @classmethod
    def of(cls, model: Model) -> ModelMark:
        """Return the mark of a model's current versions."""
        versions = model.versions
        return cls(versions.frames, versions.frame_order, versions.proximity)


def tables_of(model: Model) -> tuple[FrameTable, GeometryTable]:
    """Pack a model: frames with parents first, proximity geometry by ascending id."""
    # A parent must exist when its child is registered, so registration order is parents first.
    rows = {frame: row for row, frame in enumerate(model.frames)}
    records = list(model.frames.values())
    frames = FrameTable(
        ids=np.array([f.id.get_value() for f in records], dtype=np.int64),
        parents=np.array([rows[f.parent_id] for f in records], dtype=np.int64),
    )
    geometries = sorted(
        (g for g in model.geometries.values() if g.proximity is not None), key=lambda g: g.id
    )
    table = _table_of(model, geometries, [rows[g.frame_id] for g in geometries])
    _share(model, table)
    return frames, table


def changed_world(world: World, model: Model, before: ModelMark) -> tuple[World, RowChange | None]:
    """Return the world of a model that has changed since another one of it was built.

    What did not change keeps its rows, poses and bounds. The change of rows is None where all of
    them had to be made again.
    """
    ids = model.geometries_changed_since(before.proximity)
    few = ids is not None and MUCH * len(ids) <= world.geometry_count
    is_ordered = before.frame_order == model.versions.frame_order
    if ids is None or not few or not is_ordered or world.is_spent:
        return world.rebuilt(*tables_of(model)), None
    frames = _with_more_frames(world.frames, model)
    ordered = sorted(ids)
    with_role = [id for id in ordered if _has_role(model, id)]
    changed = np.array([id.get_value() for id in ordered], dtype=np.int64)
    has_row = np.array([_has_role(model, id) for id in ordered], dtype=np.bool_)
    change = RowChange.of(world.geometries.ids, changed, has_row)
    geometries = [model.geometries[id] for id in with_role]
    rows = _rows_of_frames(frames, [g.frame_id.get_value() for g in geometries])
    points = PointShapes.of(*pooled([g.queried_shape.to_points for g in geometries]))
    other = world.changed(frames, _table_of(model, geometries, rows), change, points)
    _share(model, other.geometries)
    return other, change


def _share(model: Model, table: GeometryTable) -> None:
    """Have a large shape that fills most of a pool keep its parameters there, not once more.

    One that fills little would keep all of the pool once its scene is gone.
    """
    starts, pool = table.starts, table.pool
    if len(pool) < _LARGE:
        return
    for row in np.flatnonzero(2 * np.diff(starts) > len(pool)).tolist():
        record = model.geometries[GeometryId(int(table.ids[row]))]
        parameters = pool[starts[row] : starts[row + 1]]
        parameters.flags.writeable = False
        record.queried_shape.in_pairs.parameters = parameters


def _has_role(model: Model, id: GeometryId) -> bool:
    """Return whether a geometry exists and has the proximity role."""
    record = model.geometries.get(id)
    return record is not None and record.proximity is not None


def _with_more_frames(frames: FrameTable, model: Model) -> FrameTable:
    """Return the frames of a model that begin with those of a table."""
    more = len(model.frames) - len(frames.ids)
    if not more:
        return frames
    records = list(islice(reversed(model.frames.values()), more))[::-1]
    ids = np.concatenate((frames.ids, [record.id.get_value() for record in records]))
    parents = _rows_of_frames(
        FrameTable(ids, frames.parents), [record.parent_id.get_value() for record in records]
    )
    return FrameTable(ids, np.concatenate((frames.parents, parents)))


def _rows_of_frames(frames: FrameTable, values: list[int]) -> Indices:
    """Return the rows of a few frames by the values of their ids."""
    rows = [np.flatnonzero(frames.ids == value)[0] for value in values]
    return np.array(rows, dtype=np.int64)


def _table_of(
    model: Model, geometries: list[GeometryRecord], frame_rows: Sequence[int] | Indices
) -> GeometryTable:
    """Pack geometries on frames with these rows."""
    types, starts, pool = pooled([g.queried_shape.in_pairs for g in geometries])
    return GeometryTable(
        ids=np.array([g.id.get_value() for g in geometries], dtype=np.int64),
        frames=np.array(frame_rows, dtype=np.int64),
        R_FGs=np.array([g.X_FG.rotation().matrix() for g in geometries]).reshape(-1, 3, 3),
        p_FGs=np.array([g.X_FG.translation() for g in geometries]).reshape(-1, 3),
        roundings=_roundings(model, geometries),
        types=types,
        starts=starts,
        pool=pool,
    )


def _roundings(model: Model, geometries: list[GeometryRecord]) -> Floats:
    """Return rounding of X_FG (n, 2), turn [-] and shift [m]; for a child geometry, of a product.

    See ``_proximity/pose_rounding``.
    """
    rotations = np.array([g.X_PG.rotation().matrix() for g in geometries]).reshape(-1, 3, 3)
    roundings = taken_roundings(rotations)
    for row, geometry in zip(roundings, geometries, strict=True):
        # From the geometry on the frame to this one.
        line = [geometry]
        while line[0].parent_id is not None:
            line.insert(0, model.geometries[line[0].parent_id])
        if len(line) > 1:
            row[:] = _rounding_of_line(line)
    return roundings


def _rounding_of_line(line: list[GeometryRecord]) -> tuple[float, float]:
    """Return turn [-] and shift [m] of X_FG of the last geometry in a chain of parents."""
    turn = shift = reach = 0.0
    for geometry in line:
        p_PG, p_FG = geometry.X_PG.translation(), geometry.X_FG.translation()
        shift = shift_of(turn, shift, reach, float(np.abs(p_PG).sum()))
        turn += float(taken_roundings(geometry.X_PG.rotation().matrix()[None])[0, TURN])
        reach = float(np.abs(p_FG).sum())
    return turn, shift


def pooled(packed: list[PackedShape]) -> tuple[Indices, Indices, Floats]:
    """Return types (n,), starts (n + 1,) and the pool of packed shapes."""
    types = np.array([shape.kind for shape in packed], dtype=np.int64)
    starts = np.cumsum([0, *(len(shape.parameters) for shape in packed)], dtype=np.int64)
    pool = _pool_around_largest(packed, starts)
    if pool is None:
        pool = np.concatenate([np.zeros(0), *(shape.parameters for shape in packed)])
    return types, starts, pool


def _pool_around_largest(packed: list[PackedShape], starts: Indices) -> Floats | None:
    """Return the pool of packed shapes in the memory of one that fills most of it.

    A copy of a large shape would be the peak of memory. None where no shape is large, and where
    others hold that memory.
    """
    size = int(starts[-1])
    if size < _LARGE or 2 * (largest := np.diff(starts)).max() <= size:
        return None
    row = int(largest.argmax())
    pool = packed[row].grown(int(starts[row]), size - int(starts[row + 1]))
    if pool is not None:
        for k, shape in enumerate(packed):
            if k != row:
                pool[starts[k] : starts[k + 1]] = shape.parameters
    return pool


def know_point_shapes(world: World, model: Model) -> None:
    """Add the shapes that points measure to, if a world lacks them."""
    if world.has_point_shapes:
        return
    shapes = [
        model.geometries[GeometryId(id)].queried_shape for id in world.geometries.ids.tolist()
    ]
    packed = [shape.to_points for shape in shapes]
    if any(one is not shape.in_pairs for one, shape in zip(packed, shapes, strict=True)):
        world.point_shapes = PointShapes.of(*pooled(packed))
    world.has_point_shapes = True
