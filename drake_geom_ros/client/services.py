"""Services of a scene_graph node by name, for nodes that spin themselves."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from drake_geom_msgs import msg, srv
from numpy.typing import ArrayLike
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_srvs.srv import Trigger

from drake_geom_ros.client.requests import RequestError, request_of
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import SMALLEST_SENT

Poses = Mapping[str, RigidTransform | ArrayLike]
JointValues = Mapping[str, float]
# DDS delivers every response of a service to all of its clients, and each queues the last ones
# until its node spins. A burst of other callers would overflow rclpy's default depth of ten.
_DEPTH = 200


class RefusedError(RuntimeError):
    """The node refused a request; the text is the node's reason."""


class Services:
    """Asynchronous clients of a node's services, by name."""

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        """Call with ``node``, which the caller spins, the services of the node ``server``."""
        self._node = node
        self._server = server
        self._clients: dict[str, Any] = {}

    def missing(self, *names: str) -> list[str]:
        """Return which of these services are not available now."""
        return [name for name in names if not self._client(name).service_is_ready()]

    def send(self, name: str, /, **fields: Any) -> Future:
        """Call a service with the fields of its request; return the future of its response.

        Numbers are converted to the types of their fields; raises RequestError for others.
        """
        request = request_of(service_type(name).Request, fields, name)
        return self._client(name).call_async(request)

    async def ask(self, name: str, /, **fields: Any) -> Any:
        """Call a service and return its response; raise RefusedError if the node refuses."""
        return accepted(name, await self.send(name, **fields))

    def _client(self, name: str) -> Any:
        if name not in self._clients:
            kind = service_type(name)
            self._clients[name] = self._node.create_client(
                kind, f'{self._server}/{name}', qos_profile=QoSProfile(depth=_DEPTH)
            )
        return self._clients[name]


def service_type(name: str) -> Any:
    """Return the type of a service: its name in CamelCase; RequestError for an unknown one."""
    if name == 'flatten_filters':
        return Trigger
    kind = getattr(srv, ''.join(map(str.capitalize, name.split('_'))), None)
    if kind is None:
        names = [_snake(each) for each in dir(srv) if each[0].isupper() and '_' not in each]
        raise RequestError(f'the node has no service {name!r}{nearest(name, names)}')
    return kind


def _snake(name: str) -> str:
    """Return the name of a service by its type's: ``SaveScene`` is ``save_scene``."""
    return re.sub('(?<!^)(?=[A-Z])', '_', name).lower()


def accepted(name: str, response: Any) -> Any:
    """Return a response; raise RefusedError if it says ``success: false``."""
    if not response.success:
        raise RefusedError(f'{name}: {response.message}')
    return response


def frame_poses(poses: Poses, source: str = '') -> msg.FramePoses:
    """Return a FramePoses message of X_PF by frame: RigidTransform, or x y z [m] qx qy qz qw."""
    rows = [
        X.ToArray() if isinstance(X, RigidTransform) else np.asarray(X, dtype=np.float64)
        for X in poses.values()
    ]
    message = msg.FramePoses(source=source, frame_names=list(poses))
    message.poses = np.concatenate(rows).tolist() if rows else []
    return message


def joint_positions(joints: Mapping[str, float]) -> msg.JointPositions:
    """Return a JointPositions message of values [rad] or [m] by joint or ``robot::joint``."""
    return msg.JointPositions(names=list(joints), positions=list(map(float, joints.values())))


def limit(metres: float) -> float:
    """Return a limit [m] as requests encode it: 0 stands for infinity."""
    if math.isinf(metres):
        return 0.0
    return metres or SMALLEST_SENT


def exclude_between(
    set_a: msg.GeometrySet, set_b: msg.GeometrySet
) -> msg.CollisionFilterStatement:
    """Return the statement that excludes the pairs between two sets."""
    return msg.CollisionFilterStatement(
        operation=msg.CollisionFilterStatement.EXCLUDE_BETWEEN, set_a=set_a, set_b=set_b
    )
