"""A scene_graph node's services as plain functions, for scripts."""

from __future__ import annotations

import contextlib
import math
import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
import rclpy
from drake_geom_msgs import msg
from geometry_msgs.msg import Point, Pose, Quaternion
from numpy.typing import ArrayLike
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.time import Time

from drake_geom_ros.client.contact_surfaces import ContactSurfaces
from drake_geom_ros.client.left_out import LeftOut
from drake_geom_ros.client.listening import SceneListener
from drake_geom_ros.client.planners import PlannersQuestions
from drake_geom_ros.client.results import (
    Penetrations,
    PointDistances,
    Results,
    SignedDistance,
    SignedDistances,
)
from drake_geom_ros.client.scene_table import JointState, SceneTable
from drake_geom_ros.client.services import (
    JointValues,
    Poses,
    Services,
    accepted,
    frame_poses,
    joint_positions,
    limit,
)
from drake_geom_ros.math import RigidTransform

_Results = TypeVar('_Results', bound=Results[Any])
_POLL = 0.01  # [s] between two looks whether something has come
# A server may take a request before it has found who asks, and then its answer is lost: what
# changes nothing is asked again after so long [s].
_ASK_AGAIN = 5.0


class NoAnswerError(RuntimeError):
    """An answer, a service or a version of the scene did not arrive in time."""


class SceneGraphClient(PlannersQuestions):
    """Calls the services of a node and waits for each answer; it spins a node of its own.

    ``poses`` are "what if" poses: X_PF by frame, as RigidTransform or as seven numbers x y z [m]
    qx qy qz qw. ``joints`` are "what if" values [rad] or [m] by joint, ``name`` or
    ``robot::name``, and the links that these move stand accordingly. Frames that are not named
    keep their poses, joints their values, and the live scene does not change.
    Each call raises RefusedError with the node's reason where the node refuses it, and
    NoAnswerError where no answer arrives within ``patience`` [s]. An answer that leaves something
    out, for a frame never had a pose, raises IncompleteError, unless ``allow_incomplete``.

        with SceneGraphClient() as client:
            print(client.signed_distances(poses={'ball': X_WB}).closest())
    """

    def __init__(self, server: str = '/scene_graph', patience: float = 30.0) -> None:
        self._patience = patience
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        name = f'scene_graph_client_{os.getpid()}_{time.monotonic_ns()}'
        self.node = rclpy.create_node(name, context=self._context)
        self.listener = SceneListener(self.node, server)
        self.services = Services(self.node, server)
        self._poses = self.node.create_publisher(msg.FramePoses, f'{server}/frame_poses', 10)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def __enter__(self) -> SceneGraphClient:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the ROS graph."""
        self._context.try_shutdown()
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def wait_for(self, fact: Callable[[], Any], what: str, end: float | None = None) -> Any:
        """Wait until ``fact()`` is true and return it; raise NoAnswerError that names ``what``.

        ``end`` [s] of ``time.monotonic()`` is when whoever waits for several things gives up.
        """
        end = self._end() if end is None else end
        while not (found := fact()):
            if time.monotonic() > end:
                raise NoAnswerError(f'waited {self._patience:g} s for {what}')
            time.sleep(_POLL)
        return found

    def _end(self) -> float:
        """Return when [s] a call that begins now has to be over."""
        return time.monotonic() + self._patience

    def scene(self, version: int = 0) -> SceneTable:
        """Return the present scene; wait until it has at least that version.

        Its ``joints`` tell their limits and where they are now, as far as the node knows.
        """
        table = self._table(version)
        return table.with_joint_states(self.joint_states()) if table.joints else table

    def joint_states(self, names: Sequence[str] = ()) -> dict[str, JointState]:
        """Return where joints are by ``robot::joint``, all or some, as far as the node knows."""
        answer = self.ask('get_joint_positions', names=list(names))
        rows = zip(answer.positions, answer.velocities, answer.ages, strict=True)
        return dict(zip(answer.names, map(JointState._make, rows), strict=True))

    def _table(self, version: int) -> SceneTable:
        """Return the newest table of ~/scene; wait until it has at least that version."""

        def known() -> SceneTable | None:
            table = self.listener.table
            return table if table is not None and table.version >= version else None

        found: SceneTable = self.wait_for(known, f'the scene of version {version} or later')
        return found

    def call(self, name: str, /, **fields: Any) -> Any:
        """Call any service by its name with the fields of its request; return its response."""
        end = self._end()
        self.wait_for(lambda: not self.services.missing(name), f'the service {name}', end)
        future = self.services.send(name, **fields)
        self.wait_for(future.done, f'an answer of {name}', end)
        return accepted(name, future.result())

    def ask(self, name: str, /, **fields: Any) -> Any:
        """Call a service that changes nothing; call again where no answer arrives."""
        return self._ask(name, self._end(), **fields)

    def _ask(self, name: str, end: float, /, **fields: Any) -> Any:
        """Call a service that changes nothing, until ``end`` [s] of ``time.monotonic()``."""
        self.wait_for(lambda: not self.services.missing(name), f'the service {name}', end)
        asked: list[tuple[float, Any]] = []

        def answered() -> Any:
            if not asked or time.monotonic() - asked[-1][0] > _ASK_AGAIN:
                asked.append((time.monotonic(), self.services.send(name, **fields)))
            return next((future for _, future in asked if future.done()), None)

        return accepted(name, self.wait_for(answered, f'an answer of {name}', end).result())

    def signed_distances(
        self,
        max_distance: float = math.inf,
        poses: Poses | None = None,
        accuracy: str = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> SignedDistances:
        """Return the signed distances of the unfiltered pairs up to ``max_distance`` [m]."""
        found = self._named(
            SignedDistances,
            'compute_signed_distance_pairwise',
            max_distance=limit(max_distance),
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=accuracy,
        )
        return found if allow_incomplete else found.whole('signed_distances')

    def signed_distance(
        self,
        geometry_a: str,
        geometry_b: str,
        poses: Poses | None = None,
        accuracy: str = '',
        joints: JointValues | None = None,
    ) -> SignedDistance:
        """Return the signed distance of one pair, which must not be filtered."""
        found = self._named(
            SignedDistances,
            'compute_signed_distance_pair',
            geometry_a=geometry_a,
            geometry_b=geometry_b,
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=accuracy,
        )
        return next(iter(found))

    def penetrations(
        self,
        poses: Poses | None = None,
        accuracy: str = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> Penetrations:
        """Return the unfiltered pairs that overlap."""
        found = self._named(
            Penetrations,
            'compute_point_pair_penetration',
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=accuracy,
        )
        return found if allow_incomplete else found.whole('penetrations')

    def point_distances(
        self,
        points: ArrayLike,
        threshold: float = math.inf,
        poses: Poses | None = None,
        accuracy: str = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> PointDistances:
        """Return the distances of ``points`` (n, 3) [m] to geometries within ``threshold`` [m]."""
        found = self._named(
            PointDistances,
            'compute_signed_distance_to_point',
            points=np.asarray(points, dtype=np.float64).ravel().tolist(),
            threshold=limit(threshold),
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=accuracy,
        )
        return found if allow_incomplete else found.whole('point_distances')

    def contact_surfaces(
        self,
        poses: Poses | None = None,
        polygons: bool = False,
        with_fallback: bool = False,
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> ContactSurfaces:
        """Return where geometries with hydroelastic properties press each other.

        Pairs that overlap without a surface are refused, or ``with_fallback`` told by
        ``without_surface``. The ``polygons`` of the surfaces are there where they are asked for.
        """
        found = self._named(
            ContactSurfaces,
            'compute_contact_surfaces',
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            polygons=polygons,
            with_fallback=with_fallback,
        )
        return found if allow_incomplete else found.whole('contact_surfaces')

    def has_collisions(
        self,
        poses: Poses | None = None,
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> bool:
        """Return whether any unfiltered pair overlaps.

        One that does is an answer whatever is left out.
        """
        answer = self.ask(
            'has_collisions',
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
        )
        left_out = LeftOut.of_pairs(answer)
        if not (left_out.is_nothing or answer.has_collisions or allow_incomplete):
            left_out.refuse('has_collisions')
        return bool(answer.has_collisions)

    def explain_filter(self, geometry_a: str, geometry_b: str) -> list[str]:
        """Return the reasons why a pair is filtered; empty where it is not."""
        answer = self.ask('explain_filter', geometry_a=geometry_a, geometry_b=geometry_b)
        return list(answer.reasons)

    def attach(
        self,
        frame: str,
        parent: str,
        X_PF: RigidTransform | ArrayLike | None = None,
        part_of_robot: bool = True,
    ) -> RigidTransform:
        """Let a frame follow one of any source, where it is now or at X_PF; return X_PF.

        ``part_of_robot``: sets by name that stand for the robot include it, in rules and results.
        """
        fields: dict[str, Any] = {'part_of_robot': part_of_robot}
        if X_PF is not None:
            fields |= {'pose_given': True, 'pose': _pose_message(X_PF)}
        return _pose_of(self.call('attach', frame=frame, parent=parent, **fields).pose)

    def detach(self, frame: str, X_PF: RigidTransform | ArrayLike | None = None) -> RigidTransform:
        """Put a frame back on the one it was registered on, where it is now or at X_PF."""
        fields = {} if X_PF is None else {'pose_given': True, 'pose': _pose_message(X_PF)}
        return _pose_of(self.call('detach', frame=frame, **fields).pose)

    def remove_source(self, source: str) -> tuple[int, int]:
        """Remove a source and all that is its; return how many frames and geometries."""
        answer = self.call('remove_source', source=source)
        return int(answer.frames), int(answer.geometries)

    def pose_ages(self, frames: Sequence[str] = ()) -> dict[str, float]:
        """Return the age [s] of the pose of frames by full name, all or some, the oldest first.

        0: it does not grow old; inf: it never came, or not since the clock jumped.
        """
        answer = self.ask('get_pose_ages', frames=list(frames))
        return dict(zip(answer.names, answer.ages, strict=True))

    def publish_poses(self, poses: Poses, source: str = '', stamp: float | None = None) -> None:
        """Pose frames of the live scene; ``stamp`` [s] is the present time if None."""
        self.wait_for(self._poses.get_subscription_count, 'a listener to frame_poses')
        message = frame_poses(poses, source)
        now = self.node.get_clock().now()
        time_of = now if stamp is None else Time(nanoseconds=round(stamp * 1_000_000_000))
        message.header.stamp = time_of.to_msg()
        self._poses.publish(message)

    def _named(
        self, results: Callable[[Any, SceneTable], _Results], name: str, /, **fields: Any
    ) -> _Results:
        """Return results with the names that they refer to; all of it within the patience.

        Asked again where these did not come although later ones did.
        """
        end, listener = self._end(), self.listener
        what = f'the names of the scene that an answer of {name} refers to'
        while True:
            result = self._ask(name, end, **fields).result
            names = result.names_version

            def came(names: int = names) -> bool:
                newest = listener.table
                return newest is not None and newest.names_version >= names

            self.wait_for(came, what, end)
            table = listener.table_of(names)
            if table is not None:
                return results(result, table)
            if time.monotonic() > end:
                raise NoAnswerError(f'waited {self._patience:g} s for {what}')


def _pose_message(X: RigidTransform | ArrayLike) -> Pose:
    """Return a pose, a RigidTransform or x y z [m] qx qy qz qw, as a message."""
    values = X.ToArray() if isinstance(X, RigidTransform) else np.asarray(X, dtype=np.float64)
    x, y, z, qx, qy, qz, qw = values.tolist()
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))


def _pose_of(message: Pose) -> RigidTransform:
    p, q = message.position, message.orientation
    return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
