"""Pairs that a query measured, as rules take them, and how far bodies reach."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    FrameId,
    GeometryId,
    QueryObject,
    SceneGraphInspector,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import Measured


def measured_pairs(
    results: SignedDistanceResults, closing_speed: NDArray[np.float64] | None
) -> Measured:
    """Return the pairs of a query's results, with their closing speeds (k,) [m/s] if known."""
    return Measured(
        results.id_A,
        results.id_B,
        results.distance,
        results.error_bound,
        results.p_WCa,
        results.p_WCb,
        closing_speed,
    )


def with_half_spaces(measured: Measured, query: QueryObject) -> Measured:
    """Return what was measured, and the pairs of half spaces, which no list has."""
    gaps = query.half_space_gaps()
    count = len(gaps.ids)
    if not count:  # as in most scenes
        return measured
    nowhere, speeds = np.full((count, 3), np.nan), measured.closing_speed
    return Measured(
        np.concatenate((measured.id_A, gaps.ids[:, 0])),
        np.concatenate((measured.id_B, gaps.ids[:, 1])),
        np.concatenate((measured.distance, gaps.distance)),
        np.concatenate((measured.error_bound, gaps.error_bound)),
        np.concatenate((measured.p_WCa, nowhere)),
        np.concatenate((measured.p_WCb, nowhere)),
        None if speeds is None else np.concatenate((speeds, np.full(count, np.nan))),
    )


def extents(
    inspector: SceneGraphInspector, geometries: Sequence[GeometryId]
) -> dict[FrameId, float]:
    """Return by frame how far [m] its geometries reach from its origin."""
    extents: dict[FrameId, float] = defaultdict(float)
    for geometry in geometries:
        obb = inspector.GetObbInGeometryFrame(geometry)
        extent = math.inf
        if obb is not None:
            X_FB: RigidTransform = inspector.GetPoseInFrame(geometry) @ obb.pose()
            extent = float(np.linalg.norm(X_FB.translation()) + np.linalg.norm(obb.half_width()))
        frame = inspector.GetFrameId(geometry)
        extents[frame] = max(extents[frame], extent)
    return dict(extents)
