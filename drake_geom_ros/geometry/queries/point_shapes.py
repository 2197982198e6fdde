"""Shapes that points measure to: the surface of a mesh, say, which is its hull in pairs."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.world.world import PointShapes, World
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.shapes.primitives import PackedShape
from drake_geom_ros.math.array_types import Floats, Indices


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
