"""MuJoCo's side: contacts of free bodies with margin 0, by mj_kinematics and mj_collision.

It reports up to several contacts a pair; all of them are read as arrays.
"""

from __future__ import annotations

import mujoco

from bench.peers.scenes import Floats, Scene
from truth.peers.mujoco_peer import add_geom

NAME = 'MuJoCo'
MEMORY = 2**29  # [bytes] for contacts


class Side:
    """A model of free bodies in World."""

    def __init__(self, scene: Scene) -> None:
        self.answers = {'penetration': self._penetration}
        spec = mujoco.MjSpec()
        spec.memory = MEMORY
        for number, one in enumerate(scene.bodies):
            body = spec.worldbody.add_body(name=f'body {number}')
            body.add_freejoint()
            add_geom(spec, body, one.shape, f'body {number}')
        for number, one in enumerate(scene.anchored):
            geom = add_geom(spec, spec.worldbody, one.shape, f'anchored {number}')
            geom.pos, geom.quat = one.p, one.pose.rotation().ToQuaternionAsVector()
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
