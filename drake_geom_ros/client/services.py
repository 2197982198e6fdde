"""Services of a scene_graph node by name, for nodes that spin themselves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from drake_geom_msgs import msg, srv
from numpy.typing import ArrayLike
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from drake_geom_ros.math import RigidTransform

Poses = Mapping[str, RigidTransform | ArrayLike]


class RefusedError(RuntimeError):
    """What the node was asked it does not do; the text is its own, and says why."""


class Services:
    """The services of a node; each has a client from when it is first named."""

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        """Call with ``node``, which the caller spins, the services of the node ``server``."""
        self._node = node
        self._server = server
        self._clients: dict[str, Any] = {}

    def missing(self, *names: str) -> list[str]:
        """Return those of some services that nobody serves now."""
        return [name for name in names if not self._client(name).service_is_ready()]

    def send(self, name: str, /, **fields: Any) -> Future:
        """Call a service with the fields of its request; the future brings the response."""
        return self._client(name).call_async(service_type(name).Request(**fields))

    async def ask(self, name: str, /, **fields: Any) -> Any:
        """Call a service and return its response; raises RefusedError where it is refused."""
        return accepted(name, await self.send(name, **fields))

    def _client(self, name: str) -> Any:
        if name not in self._clients:
            kind = service_type(name)
            self._clients[name] = self._node.create_client(kind, f'{self._server}/{name}')
        return self._clients[name]


def service_type(name: str) -> Any:
    """Return the type of a service: its name in CamelCase."""
    if name == 'flatten_filters':
        return Trigger
    return getattr(srv, ''.join(map(str.capitalize, name.split('_'))))


def accepted(name: str, response: Any) -> Any:
    """Return a response; raises RefusedError where it says that nothing was done."""
    if not response.success:
        raise RefusedError(f'{name}: {response.message}')
    return response


def frame_poses(poses: Poses, source: str = '') -> msg.FramePoses:
    """Return a FramePoses of X_PF by frame: RigidTransform, or x y z [m] qx qy qz qw."""
    rows = [
        X.ToArray() if isinstance(X, RigidTransform) else np.asarray(X, dtype=np.float64)
        for X in poses.values()
    ]
    message = msg.FramePoses(source=source, frame_names=list(poses))
    message.poses = np.concatenate(rows).tolist() if rows else []
    return message


def exclude_between(
    set_a: msg.GeometrySet, set_b: msg.GeometrySet
) -> msg.CollisionFilterStatement:
    """Return the statement that excludes the pairs of two sets."""
    return msg.CollisionFilterStatement(
        operation=msg.CollisionFilterStatement.EXCLUDE_BETWEEN, set_a=set_a, set_b=set_b
    )
