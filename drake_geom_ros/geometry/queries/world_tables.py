"""Tables of frames and geometries of a model, from which a world is built."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.world.pose_rounding import TURN, shift_of, taken_roundings
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
    packed = [g.queried_shape.in_pairs for g in geometries]
    types, starts, pool = pooled(packed)
    table = GeometryTable(
        ids=np.array([g.id.get_value() for g in geometries], dtype=np.int64),
        frames=np.array([rows[g.frame_id] for g in geometries], dtype=np.int64),
        R_FGs=np.array([g.X_FG.rotation().matrix() for g in geometries]).reshape(-1, 3, 3),
        p_FGs=np.array([g.X_FG.translation() for g in geometries]).reshape(-1, 3),
        roundings=_roundings(model, geometries),
        types=types,
        starts=starts,
        pool=pool,
    )
    return frames, table


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
    parameters = [numbers for _, numbers in packed]
    return (
        np.array([kind for kind, _ in packed], dtype=np.int64),
        np.cumsum([0, *map(len, parameters)], dtype=np.int64),
        np.concatenate([np.zeros(0), *parameters]),
    )


def know_point_shapes(world: World, model: Model) -> None:
    """Add the shapes that points measure to, if a world lacks them."""
    if world.has_point_shapes:
        return
    shapes = [
        model.geometries[GeometryId(id)].queried_shape for id in world.geometries.ids.tolist()
    ]
    packed = [shape.to_points for shape in shapes]
    if any(one is not shape.in_pairs for one, shape in zip(packed, shapes, strict=True)):
        types, starts, pool = pooled(packed)
        world.point_shapes = PointShapes(types, starts, pool, frozenset(types.tolist()))
    world.has_point_shapes = True
