"""MuJoCo's side: contacts of free bodies with margin 0, by mj_kinematics and mj_collision.

It reports up to several contacts a pair; all of them are read as arrays.
"""

from __future__ import annotations

import mujoco
import numpy as np

from bench.peers.scenes import Floats, Scene, Shape

NAME = 'MuJoCo'
MEMORY = 2**29  # [bytes] for contacts


class Side:
    """A model of free bodies in World."""

    def __init__(self, scene: Scene) -> None:
        self.answers = {'penetration': self._penetration}
        spec = mujoco.MjSpec()
        spec.memory = MEMORY
        for number, shape in enumerate(scene.bodies):
            body = spec.worldbody.add_body(name=f'body {number}')
            body.add_freejoint()
            _add(spec, body, shape, f'body {number}')
        for number, (shape, X) in enumerate(scene.anchored):
            geom = _add(spec, spec.worldbody, shape, f'anchored {number}')
            geom.pos, geom.quat = X[:3], X[[6, 3, 4, 5]]
        for a, b in scene.filtered:
            spec.add_exclude(bodyname1=f'body {a}', bodyname2=f'body {b}')
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)

    def layout(self, poses: Floats) -> Floats:
        """Return poses (n, 7) as qpos: x y z qw qx qy qz of each body."""
        return poses[:, [0, 1, 2, 6, 3, 4, 5]].ravel()

    def set_poses(self, qpos: Floats) -> None:
        """Pose all bodies."""
        self._data.qpos[:] = qpos

    def _penetration(self) -> int:
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        arrays = contact.geom, contact.dist, contact.pos, contact.frame
        return len(arrays[0])


def _add(spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Shape, name: str) -> mujoco.MjsGeom:
    """Add a shape to a body; half sizes are what MuJoCo wants."""
    geom = body.add_geom(name=name)
    geom.type = getattr(mujoco.mjtGeom, f'mjGEOM_{shape.kind.upper()}', mujoco.mjtGeom.mjGEOM_MESH)
    if shape.vertices is not None:
        spec.add_mesh(name=name, uservert=shape.vertices.ravel())
        geom.meshname = name
        return geom
    sizes = np.array(shape.sizes)
    if shape.kind == 'Box':
        sizes *= 0.5
    elif shape.kind in ('Capsule', 'Cylinder'):
        sizes[1] *= 0.5
    geom.size[: len(sizes)] = sizes
    return geom
