"""MuJoCo: ``mj_geomDistance`` of two geoms, and the contacts of ``mj_collision``."""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.cross_check.answers import (
    HALVES,
    SIGNED_DISTANCE,
    Ask,
    PairAnswer,
    checked,
    kind_of,
    measures,
)
from drake_geom_ros.geometry import Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

FARTHEST = 1e10  # [m] beyond which mj_geomDistance need not look; infinity is not understood


def add_geom(spec: Any, body: Any, shape: Shape, name: str) -> Any:
    """Add a shape of ours to a body of a model's specification; return the geom."""
    import mujoco

    kind = kind_of(shape)
    geom = body.add_geom(name=name)
    if kind == 'Convex':
        spec.add_mesh(name=name, uservert=shape.hull_surface()[0].ravel())  # type: ignore[attr-defined]
        geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
    elif kind == 'HalfSpace':
        geom.type = mujoco.mjtGeom.mjGEOM_PLANE
        geom.size = [1.0, 1.0, 1.0]  # of what is drawn: a plane has no end
    else:
        geom.type = getattr(mujoco.mjtGeom, f'mjGEOM_{kind.upper()}')
        sizes = np.array(measures(shape)) * HALVES.get(kind, 1.0)
        geom.size[: len(sizes)] = sizes
    return geom


class MuJoCoPeer:
    """MuJoCo with its own settings, or with another tolerance for convex pairs."""

    name = 'MuJoCo'

    def __init__(self, tolerance: float | None) -> None:
        self._tolerance = tolerance

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return what asks the query; see Peer."""
        model = _Model(shape_a, shape_b, self._tolerance)
        return model.distance if checked(query) == SIGNED_DISTANCE else model.penetration


class _Model:
    """Two geoms: on free bodies, but a plane is static, as MuJoCo wants it."""

    def __init__(self, shape_a: Shape, shape_b: Shape, tolerance: float | None) -> None:
        import mujoco

        self._mujoco = mujoco
        # Its warnings would go to a file in whatever folder this runs in.
        mujoco.set_mju_user_warning(lambda warning: None)
        spec = mujoco.MjSpec()
        for name, shape in (('a', shape_a), ('b', shape_b)):
            if kind_of(shape) == 'HalfSpace':
                add_geom(spec, spec.worldbody, shape, name)
                continue
            # The mass plays no part, but that of a tiny body would be refused.
            body = spec.worldbody.add_body(
                name=name, mass=1.0, inertia=[1.0, 1.0, 1.0], explicitinertial=True
            )
            body.add_freejoint()
            add_geom(spec, body, shape, name)
        if tolerance is not None:
            spec.option.ccd_tolerance = tolerance
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._geoms = [self._model.geom(name).id for name in ('a', 'b')]
        self._moved = [_mesh_offset(mujoco, self._model, g) for g in self._geoms]

    def _pose_both(self, X_WA: RigidTransform, X_WB: RigidTransform) -> None:
        """Pose geoms and bodies: a mesh has its own origin, at its centre of mass."""
        for g, X, (R_GM, p_GM) in zip(self._geoms, (X_WA, X_WB), self._moved, strict=True):
            R_WG, p_WG = X.rotation().matrix(), X.translation()
            p_WM, R_WM = p_WG + R_WG @ p_GM, R_WG @ R_GM
            body = self._model.geom_bodyid[g]
            self._data.geom_xpos[g], self._data.geom_xmat[g] = p_WM, R_WM.ravel()
            if body:
                self._data.xipos[body] = self._data.xpos[body] = p_WG
                self._data.ximat[body] = self._data.xmat[body] = R_WG.ravel()

    def distance(self, X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer:
        """Return mj_geomDistance, which gives witness points and no normal."""
        self._pose_both(X_WA, X_WB)
        points = np.zeros(6)
        distance = self._mujoco.mj_geomDistance(
            self._model, self._data, *self._geoms, FARTHEST, points
        )
        return PairAnswer(distance, None, points[:3], points[3:])

    def penetration(self, X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer | None:
        """Return the deepest contact."""
        self._pose_both(X_WA, X_WB)
        self._mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        if not len(contact.dist):
            return None
        deepest = int(np.argmin(contact.dist))
        distance, middle = float(contact.dist[deepest]), contact.pos[deepest].copy()
        # Its normal points from the first geom to the second, its position lies midway.
        nhat_BA_W = -contact.frame[deepest][:3]
        if contact.geom[deepest][0] != self._geoms[0]:
            nhat_BA_W = -nhat_BA_W
        half = 0.5 * distance * nhat_BA_W
        return PairAnswer(distance, nhat_BA_W, middle + half, middle - half)


def _mesh_offset(mujoco: Any, model: Any, geom: int) -> tuple[Floats, Floats]:
    """Return the pose of what MuJoCo keeps of a geom in the geometry that was given to it."""
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, model.geom_quat[geom])
    return R.reshape(3, 3), model.geom_pos[geom].copy()
