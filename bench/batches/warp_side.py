"""MuJoCo Warp in ``bench.batches.race``: all states at once, on this machine's processor."""

from __future__ import annotations

from typing import Any

import mujoco_warp
import numpy as np
import warp

from bench.batches.other_sides import MujocoSide

_BLOCK = 500  # states (worlds) of one launch
_CONTACTS = 64  # of a state, at most in the mean


class WarpSide(MujocoSide):
    """MJWarp's kinematics and collision phase; links are free bodies, as in MuJoCo's side."""

    name = f'MuJoCo Warp {mujoco_warp.__version__} (CPU)'

    def __init__(self, ours: Any) -> None:
        super().__init__(ours)
        warp.config.quiet = True
        self._device = mujoco_warp.put_model(self._model)
        self._worlds = mujoco_warp.make_data(
            self._model, nworld=_BLOCK, nconmax=_CONTACTS, njmax=8
        )

    def collisions(self, states: np.ndarray) -> np.ndarray:
        """Return which states collide: all contacts are found."""
        found = np.zeros(len(states), dtype=bool)
        poses = self._ours.joints.poses(states)
        qpos = poses[:, :, [0, 1, 2, 6, 3, 4, 5]].reshape(len(states), -1)
        for first in range(0, len(states), _BLOCK):
            block = qpos[first : first + _BLOCK]
            values = np.resize(block, (_BLOCK, qpos.shape[1])).astype(np.float32)
            self._worlds.qpos.assign(values)
            mujoco_warp.kinematics(self._device, self._worlds)
            mujoco_warp.collision(self._device, self._worlds)
            count = int(self._worlds.nacon.numpy()[0])
            worlds = self._worlds.contact.worldid.numpy()[:count]
            touching = np.bincount(worlds, minlength=_BLOCK)[: len(block)] > 0
            found[first : first + _BLOCK] = touching
        return found
