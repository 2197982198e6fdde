"""python-fcl's side: two trees, of the bodies and of what is anchored, with FCL's own callback.

The callback cannot tell which body it is given, so filtered pairs are reported too, and a scene
that has some is not asked whether it collides. Signed
distances are not asked for: ``fcl.distance`` may end the process.
"""

from __future__ import annotations

import fcl  # noqa: TID251  (the ban is for the package; this is a measurement of fcl itself)
import numpy as np

from bench.peers.scenes import Floats, Scene
from drake_geom_ros.cross_check.fcl_peer import fcl_shape

NAME = 'python-fcl'
MOST_CONTACTS = 10**6


class Side:
    """Collision objects in broad-phase managers."""

    def __init__(self, scene: Scene) -> None:
        self.answers = {'penetration': self._penetration}
        if not scene.filtered:
            self.answers['has_collisions'] = self._has_collisions
        self._bodies = [
            fcl.CollisionObject(fcl_shape(b.shape), fcl.Transform()) for b in scene.bodies
        ]
        self._moving = _manager(self._bodies)
        self._anchored = _manager(
            [
                fcl.CollisionObject(fcl_shape(b.shape), fcl.Transform(b.R, b.p))
                for b in scene.anchored
            ]
        )

    def layout(self, poses: Floats) -> tuple[Floats, Floats]:
        """Return poses (n, 7) as quaternions (n, 4), real part first, and positions (n, 3)."""
        return poses[:, [6, 3, 4, 5]].copy(), poses[:, :3].copy()

    def set_poses(self, poses: tuple[Floats, Floats]) -> None:
        """Pose all bodies."""
        for body, q, p in zip(self._bodies, *poses, strict=True):
            body.setTransform(fcl.Transform(q, p))
        self._moving.update()

    def _penetration(self) -> int:
        result = self._collide(MOST_CONTACTS, True)
        return len(np.array([contact.penetration_depth for contact in result.contacts]))

    def _has_collisions(self) -> int:
        return int(self._collide(1, False).is_collision)

    def _collide(self, most: int, contacts: bool) -> fcl.CollisionResult:
        request = fcl.CollisionRequest(num_max_contacts=most, enable_contact=contacts)
        data = fcl.CollisionData(request=request)
        self._moving.collide(data, fcl.defaultCollisionCallback)
        if not data.done:
            self._moving.collide(self._anchored, data, fcl.defaultCollisionCallback)
        return data.result


def _manager(objects: list[fcl.CollisionObject]) -> fcl.DynamicAABBTreeCollisionManager:
    manager = fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(objects)
    manager.setup()
    return manager
