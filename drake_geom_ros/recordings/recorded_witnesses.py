"""Check whether recorded witness points and normals can be those of their pairs.

They need not equal the ones computed now: a node may warm start its iterations, and parallel
faces have many nearest points. Therefore only the guarantees of the messages are checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryId, Mesh, QueryObject, SceneGraphInspector
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.recordings.tolerances import NEAR


class Witnesses(NamedTuple):
    """Witness points and normals of pairs, as in a message."""

    p_A: Floats  # (n, 3) [m]
    p_B: Floats  # (n, 3) [m]
    nhat_BA_W: Floats | None  # (n, 3); None if the message has none
    are_local: bool  # points are in the frames of their geometries, not in the world

    def same(self, k: int, other: Witnesses, n: int) -> bool:
        """Return whether the witnesses of pair k equal, to the bit, those of other's pair n."""
        return all(
            np.array_equal(own_column[k], other_column[n], equal_nan=True)
            for own_column, other_column in zip(self[:3], other[:3], strict=True)
            if own_column is not None and other_column is not None
        )


class JudgedWitnesses(NamedTuple):
    """Pairs (m) whose witnesses are to be judged."""

    places: Sequence[int]  # rows in the witnesses
    ids: NDArray[np.int64]  # (m, 2) of their geometries
    distance: Floats  # (m,) [m] in the message
    error_bound: Floats  # (m,) [m] sum of those in the message and of the recomputed distance


def fault_of(
    query: QueryObject, witnesses: Witnesses, judged: JudgedWitnesses
) -> tuple[int, str] | None:
    """Return the first judged pair with invalid witnesses, and the reason; None: all are valid.

    Valid points lie on the surfaces of their geometries, the normal has unit length, and the
    points are the distance apart along it. Points on a Mesh that stands for its hull are not
    checked, since point queries do not use the hull.
    """
    rows = np.array(judged.places, dtype=np.int64)
    if not rows.size:
        return None
    p_WA, p_WB = witnesses.p_A[rows], witnesses.p_B[rows]
    if witnesses.are_local:
        p_WA, p_WB = (
            _in_world(query, ids, points)
            for ids, points in zip(judged.ids.T, (p_WA, p_WB), strict=True)
        )
    near = NEAR + judged.error_bound
    nhat = None if witnesses.nhat_BA_W is None else witnesses.nhat_BA_W[rows]
    faults = {
        **_faults_between(p_WA - p_WB, judged.distance, nhat, near),
        'its point on the first one is not on its surface': ~_are_on(
            query, judged.ids[:, 0], p_WA, near
        ),
        'its point on the second one is not on its surface': ~_are_on(
            query, judged.ids[:, 1], p_WB, near
        ),
    }
    for why, flags in faults.items():
        if flags.any():
            return int(np.argmax(flags)), why
    return None


def _faults_between(
    between: Floats, distance: Floats, nhat: Floats | None, near: Floats
) -> dict[str, NDArray[np.bool_]]:
    """Return masks (m,) of faults by reason, for the vectors ``between`` points (m, 3) [m]."""
    with np.errstate(invalid='ignore'):
        if nhat is None:
            off = np.abs(np.linalg.norm(between, axis=1) - np.abs(distance))
            return {'its points are not the distance apart': ~(off <= near)}
        off = np.linalg.norm(between - distance[:, None] * nhat, axis=1)
        unit = np.abs(np.linalg.norm(nhat, axis=1) - 1.0)
    return {
        'the normal is not of unit length': ~(unit <= NEAR),
        'its points are not the distance apart along the normal': ~(off <= near),
    }


def _in_world(query: QueryObject, ids: NDArray[np.int64], points: Floats) -> Floats:
    R_WG, p_WG = query.X_WGs(ids)
    with np.errstate(invalid='ignore'):  # points that are not finite become faults later
        return np.asarray((R_WG @ points[:, :, None])[:, :, 0] + p_WG)


def _are_on(
    query: QueryObject, ids: NDArray[np.int64], points: Floats, near: Floats
) -> NDArray[np.bool_]:
    """Return a mask (m,) of the points (m, 3) [m] on the surfaces of their geometries."""
    are_on = np.zeros(len(points), dtype=np.bool_)
    finite = np.flatnonzero(np.isfinite(points).all(axis=1))
    if not finite.size:
        return are_on
    distances = query.ComputeSignedDistanceToPoint(points[finite], float(near[finite].max()))
    rows = finite[distances.point_index]
    is_near = np.abs(distances.distance) <= near[rows] + distances.error_bound
    are_on[rows[(distances.id_G == ids[rows]) & is_near]] = True
    inspector = query.inspector()
    hulls = [value for value in set(ids.tolist()) if _is_hull(inspector, GeometryId(value))]
    return are_on | (np.isin(ids, hulls) & np.isfinite(points).all(axis=1))


def _is_hull(inspector: SceneGraphInspector, geometry: GeometryId) -> bool:
    """Return whether a geometry is a Mesh that stands for its hull in pairs."""
    if not isinstance(inspector.GetShape(geometry), Mesh):
        return False
    properties = inspector.GetProximityProperties(geometry)
    return properties is None or not properties.GetPropertyOrDefault('mesh', 'solid', False)
