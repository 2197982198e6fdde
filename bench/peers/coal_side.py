"""Coal's side: two trees, of the bodies and of what is anchored, with Coal's own callback.

Filtered pairs are reported too, and a scene that has some is not asked whether it collides.
The callback that collects candidates stays in C++; the pairs
that it finds are counted, for Python cannot have them.
"""

from __future__ import annotations

import coal
import numpy as np

from bench.peers.scenes import Floats, Scene
from truth.peers.coal_peer import coal_shape

NAME = 'Coal'
MOST_CONTACTS = 10**6
MOST_CANDIDATES = 20_000


class Side:
    """Collision objects in broad-phase managers."""

    def __init__(self, scene: Scene) -> None:
        self.answers = {'penetration': self._penetration, 'candidates': self._candidates}
        if not scene.filtered:
            self.answers['has_collisions'] = self._has_collisions
        self._bodies = [coal.CollisionObject(coal_shape(b.shape)) for b in scene.bodies]
        self._moving = _manager(self._bodies)
        self._standing = [
            coal.CollisionObject(coal_shape(b.shape), coal.Transform3s(b.R, b.p))
            for b in scene.anchored
        ]
        self._anchored = _manager(self._standing)

    def layout(self, poses: Floats) -> tuple[list[coal.Quaternion], Floats]:
        """Return poses (n, 7) as unit quaternions and positions (n, 3)."""
        return poses[:, 3:].copy(), poses[:, :3].copy()

    def set_poses(self, poses: tuple[Floats, Floats]) -> None:
        """Pose all bodies."""
        for body, q, p in zip(self._bodies, *poses, strict=True):
            body.setTransform(coal.Transform3s(coal.Quaternion(q), p))
            body.computeAABB()
        self._moving.update()

    def _penetration(self) -> int:
        callback = _callback(MOST_CONTACTS, coal.CollisionRequestFlag.CONTACT)
        return self._contacts(callback) + self._contacts(callback, self._anchored)

    def _has_collisions(self) -> int:
        callback = _callback(1, coal.CollisionRequestFlag.NO_REQUEST)
        self._moving.collide(callback)
        if not callback.data.result.isCollision():
            self._moving.collide(self._anchored, callback)
        return int(callback.data.result.isCollision())

    def _candidates(self) -> int:
        callback = coal.CollisionCallBackCollect(MOST_CANDIDATES)
        self._moving.collide(callback)
        found = callback.numCollisionPairs()
        self._moving.collide(self._anchored, callback)
        return found + callback.numCollisionPairs()

    def _contacts(self, callback: coal.CollisionCallBackDefault, *others: object) -> int:
        """Collide the bodies with each other, or with another tree; a call forgets the last."""
        self._moving.collide(*others, callback)
        contacts = callback.data.result.getContacts()
        return len(np.array([contact.penetration_depth for contact in contacts]))


def _callback(most: int, flag: coal.CollisionRequestFlag) -> coal.CollisionCallBackDefault:
    callback = coal.CollisionCallBackDefault()
    callback.data.request = coal.CollisionRequest(flag, most)
    return callback


def _manager(objects: list[coal.CollisionObject]) -> coal.DynamicAABBTreeCollisionManager:
    manager = coal.DynamicAABBTreeCollisionManager()
    for each in objects:
        manager.registerObject(each)
    manager.setup()
    return manager
