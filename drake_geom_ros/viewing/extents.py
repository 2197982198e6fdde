"""The box around what a page shows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    CalcObb,
    Convex,
    GeometryError,
    HalfSpace,
    Mesh,
    Obb,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.shown_scene import ShownMoment


class Extent(NamedTuple):
    """The lowest and the highest corner (3,) [m] of a box along the world's axes."""

    low: Floats
    high: Floats


def extent_of(moment: ShownMoment) -> Extent | None:
    """Return the extent of the shown geometries in the world, None without any.

    Half spaces do not count, and shapes whose file cannot be read count as points.
    """
    boxes: dict[int, Obb] = {}  # by shape, since many geometries may share one
    rows, shown = [], []
    for look in moment.geometries.looks:
        if not isinstance(look.shape, HalfSpace):
            key = id(look.shape)
            if key not in boxes:
                boxes[key] = _box(look.shape)
            shown.append(boxes[key])
            rows.append(moment.geometries.row_of(look.geometry.get_value()))
    if not shown:
        return None
    R_WGs, p_WGs = moment.R_WGs[rows], moment.p_WGs[rows]
    p_GBs = np.array([box.center() for box in shown])
    R_GBs = np.array([box.pose().rotation().matrix() for box in shown])
    halves = np.array([box.half_width() for box in shown])
    p_WBs = p_WGs + np.einsum('kij,kj->ki', R_WGs, p_GBs)
    reaches = np.einsum('kij,kj->ki', np.abs(R_WGs @ R_GBs), halves)
    return Extent((p_WBs - reaches).min(axis=0), (p_WBs + reaches).max(axis=0))


def _box(shape: Shape) -> Obb:
    try:
        if isinstance(shape, (Mesh, Convex)):  # the smallest one would take long to find
            vertices = (shape.surface() if isinstance(shape, Mesh) else shape.hull_surface())[0]
            low, high = vertices.min(axis=0), vertices.max(axis=0)
            return Obb(RigidTransform(0.5 * (low + high)), 0.5 * (high - low))
        box = CalcObb(shape)
        assert box is not None
        return box
    except GeometryError:
        return Obb(RigidTransform(), np.zeros(3))
