"""Whether recorded witness points and normals can be those of their pairs.

They need not be the ones that are computed now: a node's iterations may begin with an earlier
answer, and of flush sides many points are nearest. What the messages promise of them is judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import GeometryId, Mesh, QueryObject, SceneGraphInspector
from drake_geom_ros.recordings.tolerances import NEAR

Floats = NDArray[np.float64]


class Witnesses(NamedTuple):
    """Of pairs their points and normals, as a message has them."""

    p_A: Floats  # (n, 3) [m]
    p_B: Floats  # (n, 3) [m]
    nhat_BA_W: Floats | None  # (n, 3); None where a message tells none
    are_local: bool  # points in the frames of their geometries, not in the world

    def same(self, k: int, other: Witnesses, n: int) -> bool:
        """Return whether those of pair k are, to the bit, those of the other's pair n."""
        both = zip(self[:3], other[:3], strict=True)
        return all(
            np.array_equal(mine[k], theirs[n], equal_nan=True)
            for mine, theirs in both
            if mine is not None and theirs is not None
        )


class Judged(NamedTuple):
    """Pairs (m) whose witnesses are to be judged."""

    places: Sequence[int]  # among the witnesses
    ids: NDArray[np.int64]  # (m, 2) of their geometries
    distance: Floats  # (m,) [m] as the message has it
    error_bound: Floats  # (m,) [m] of the message and of what is computed now


def fault_of(query: QueryObject, said: Witnesses, judged: Judged) -> tuple[int, str] | None:
    """Return the first of the judged that cannot be, and why; None: all can be.

    The points lie on the surfaces of their geometries, the normal has unit length, and along it
    the points are the distance apart. Whether a point lies on a Mesh that counts as its hull is
    not judged: to points it is no hull.
    """
    rows = np.array(judged.places, dtype=np.int64)
    if not rows.size:
        return None
    p_WA, p_WB = said.p_A[rows], said.p_B[rows]
    if said.are_local:
        p_WA, p_WB = (
            _in_world(query, ids, points)
            for ids, points in zip(judged.ids.T, (p_WA, p_WB), strict=True)
        )
    near = NEAR + judged.error_bound
    nhat = None if said.nhat_BA_W is None else said.nhat_BA_W[rows]
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
    """Return of each pair (m,) whether its points cannot be so far apart (m, 3)."""
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
    with np.errstate(invalid='ignore'):  # what is not finite is no point, and will be told
        return np.asarray((R_WG @ points[:, :, None])[:, :, 0] + p_WG)


def _are_on(
    query: QueryObject, ids: NDArray[np.int64], points: Floats, near: Floats
) -> NDArray[np.bool_]:
    """Return of each point (m, 3) whether it is on the surface of its geometry."""
    found = np.zeros(len(points), dtype=np.bool_)
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    if not known.size:
        return found
    told = query.ComputeSignedDistanceToPoint(points[known], float(near[known].max()))
    rows = known[told.point_index]
    own = (told.id_G == ids[rows]) & (np.abs(told.distance) <= near[rows] + told.error_bound)
    found[rows[own]] = True
    inspector = query.inspector()
    hulls = [value for value in set(ids.tolist()) if _is_hull(inspector, GeometryId(value))]
    return found | (np.isin(ids, hulls) & np.isfinite(points).all(axis=1))


def _is_hull(inspector: SceneGraphInspector, geometry: GeometryId) -> bool:
    """Return whether a geometry is a Mesh that counts as its hull in pairs."""
    if not isinstance(inspector.GetShape(geometry), Mesh):
        return False
    properties = inspector.GetProximityProperties(geometry)
    return properties is None or not properties.GetPropertyOrDefault('mesh', 'solid', False)
