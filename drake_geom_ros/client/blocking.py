"""A scene_graph node's services as plain functions, for scripts."""

from __future__ import annotations

import contextlib
import math
import os
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal, TypeVar

import numpy as np
import rclpy
from drake_geom_msgs import msg
from geometry_msgs.msg import Point, Pose, Quaternion
from numpy.typing import ArrayLike
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.time import Time
from trajectory_msgs.msg import JointTrajectory, MultiDOFJointTrajectory

from drake_geom_ros.client.contact_surfaces import ContactSurfaces
from drake_geom_ros.client.left_out import LeftOut, refuse_stale
from drake_geom_ros.client.listening import SceneListener
from drake_geom_ros.client.motions import Motion, joint_trajectory, paths_of
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
from drake_geom_ros.client.states import Progress, States, StatesRequest
from drake_geom_ros.client.trajectories import TrajectoryState, TrajectoryStates
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

# A level, a length [m], or empty for that of the node.
AccuracyLike = Literal['', 'bound', 'fast', 'balanced', 'exact'] | str | float
_Results = TypeVar('_Results', bound=Results[Any])
_POLL = 0.01  # [s] between two checks of a condition
# A server may take a request before it has discovered the client, and then its response is lost.
# Requests that change nothing are sent again after this time [s].
_RETRY_AFTER = 5.0


class NoAnswerError(RuntimeError):
    """An answer, a service or a version of the scene did not arrive in time."""


class SceneGraphClient:
    """Blocking client of a scene_graph node; it creates and spins a node of its own.

    ``poses`` are "what if" poses: X_PF by frame, as RigidTransform or as seven numbers x y z [m]
    qx qy qz qw. ``joints`` are "what if" values [rad] or [m] by joint, ``name`` or
    ``robot::name``; the links that these joints move are posed accordingly. Frames that are not
    named keep their poses, joints their values, and the live scene does not change.

    Each call raises RefusedError with the node's reason if the node refuses it, and
    NoAnswerError if no response arrives within ``patience`` [s]. Results that omit geometries,
    because a frame has never received a pose, raise IncompleteError unless ``allow_incomplete``.

        with SceneGraphClient() as client:
            print(client.signed_distances(poses={'ball': X_WB}).closest())
    """

    def __init__(self, server: str = '/scene_graph', patience: float = 30.0) -> None:
        self._patience, self._server = patience, server
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        name = f'scene_graph_client_{os.getpid()}_{time.monotonic_ns()}'
        self.node = rclpy.create_node(name, context=self._context)
        self.listener = SceneListener(self.node, server)
        self.services = Services(self.node, server)
        self._trajectories: TrajectoryStates | None = None
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

        ``end`` [s] is a deadline on ``time.monotonic()``, for callers that wait for several
        facts; by default ``patience`` counts from now.
        """
        end = self._end() if end is None else end
        while not (value := fact()):
            if time.monotonic() > end:
                raise NoAnswerError(f'waited {self._patience:g} s for {what}')
            time.sleep(_POLL)
        return value

    def _end(self) -> float:
        """Return the deadline [s] of a call that begins now, on ``time.monotonic()``."""
        return time.monotonic() + self._patience

    def scene(self, version: int = 0) -> SceneTable:
        """Return the current scene; wait until it has at least that version.

        Its ``joints`` hold their limits and the states that the node knows.
        """
        table = self._table(version)
        return table.with_joint_states(self.joint_states()) if table.joints else table

    def joint_states(self, names: Sequence[str] = ()) -> dict[str, JointState]:
        """Return the joint states that the node knows, by ``robot::joint``; all if no names."""
        answer = self.ask('get_joint_positions', names=list(names))
        rows = zip(answer.positions, answer.velocities, answer.ages, strict=True)
        return dict(zip(answer.names, map(JointState._make, rows), strict=True))

    def _table(self, version: int) -> SceneTable:
        """Return the newest table of ~/scene; wait until it has at least that version."""

        def new_enough() -> SceneTable | None:
            table = self.listener.table
            return table if table is not None and table.version >= version else None

        table: SceneTable = self.wait_for(new_enough, f'the scene of version {version} or later')
        return table

    def call(self, name: str, /, **fields: Any) -> Any:
        """Call any service by its name with the fields of its request; return its response."""
        end = self._end()
        self.wait_for(lambda: not self.services.missing(name), f'the service {name}', end)
        future = self.services.send(name, **fields)
        self.wait_for(future.done, f'an answer of {name}', end)
        return accepted(name, future.result())

    def ask(self, name: str, /, **fields: Any) -> Any:
        """Call a service that changes nothing; call it again if no response arrives."""
        return self._ask(name, self._end(), **fields)

    def _ask(self, name: str, end: float, /, **fields: Any) -> Any:
        """Call a service that changes nothing, until the deadline ``end`` [s]."""
        self.wait_for(lambda: not self.services.missing(name), f'the service {name}', end)
        requests: list[tuple[float, Any]] = []  # when each was sent, and its future

        def answered() -> Any:
            if not requests or time.monotonic() - requests[-1][0] > _RETRY_AFTER:
                requests.append((time.monotonic(), self.services.send(name, **fields)))
            return next((future for _, future in requests if future.done()), None)

        awaited = (
            f'an answer of {name} (a node compiles what its first one needs; its log says so)'
        )
        return accepted(name, self.wait_for(answered, awaited, end).result())

    def signed_distances(
        self,
        max_distance: float = math.inf,
        poses: Poses | None = None,
        accuracy: AccuracyLike = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> SignedDistances:
        """Return the signed distances of the unfiltered pairs up to ``max_distance`` [m]."""
        distances = self._named(
            SignedDistances,
            'compute_signed_distance_pairwise',
            max_distance=limit(max_distance),
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=str(accuracy),
        )
        return distances if allow_incomplete else distances.whole('signed_distances')

    def signed_distance(
        self,
        geometry_a: str,
        geometry_b: str,
        poses: Poses | None = None,
        accuracy: AccuracyLike = '',
        joints: JointValues | None = None,
    ) -> SignedDistance:
        """Return the signed distance of one pair, which must not be filtered."""
        distances = self._named(
            SignedDistances,
            'compute_signed_distance_pair',
            geometry_a=geometry_a,
            geometry_b=geometry_b,
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=str(accuracy),
        )
        return next(iter(distances))

    def penetrations(
        self,
        poses: Poses | None = None,
        accuracy: AccuracyLike = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> Penetrations:
        """Return the unfiltered pairs that overlap."""
        overlaps = self._named(
            Penetrations,
            'compute_point_pair_penetration',
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=str(accuracy),
        )
        return overlaps if allow_incomplete else overlaps.whole('penetrations')

    def point_distances(
        self,
        points: ArrayLike,
        threshold: float = math.inf,
        poses: Poses | None = None,
        accuracy: AccuracyLike = '',
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> PointDistances:
        """Return the distances of ``points`` (n, 3) [m] to geometries within ``threshold`` [m]."""
        distances = self._named(
            PointDistances,
            'compute_signed_distance_to_point',
            points=np.asarray(points, dtype=np.float64).ravel().tolist(),
            threshold=limit(threshold),
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            accuracy=str(accuracy),
        )
        return distances if allow_incomplete else distances.whole('point_distances')

    def contact_surfaces(
        self,
        poses: Poses | None = None,
        polygons: bool = False,
        with_fallback: bool = False,
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> ContactSurfaces:
        """Return the contact surfaces of geometries with hydroelastic properties.

        Pairs that overlap without a surface are refused, or, ``with_fallback``, reported in
        ``without_surface``. The surfaces have polygons only if ``polygons`` is true.
        """
        surfaces = self._named(
            ContactSurfaces,
            'compute_contact_surfaces',
            poses=frame_poses(poses or {}),
            joints=joint_positions(joints or {}),
            polygons=polygons,
            with_fallback=with_fallback,
        )
        return surfaces if allow_incomplete else surfaces.whole('contact_surfaces')

    def has_collisions(
        self,
        poses: Poses | None = None,
        allow_incomplete: bool = False,
        joints: JointValues | None = None,
    ) -> bool:
        """Return whether any unfiltered pair overlaps.

        If one does, omitted pairs raise no IncompleteError: they cannot change the answer.
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

    def evaluate_states(
        self,
        joint_names: Sequence[str],
        positions: ArrayLike,
        want: Literal['collision', 'least', 'near'] | str = 'collision',
        *,
        clearance: float = 0.0,
        max_distance: float = math.inf,
        poses: Poses | None = None,
        stop_at_first: bool = False,
        ignore_limits: bool = False,
        accuracy: AccuracyLike = '',
        progress: Progress | None = None,
        allow_stale: bool = False,
    ) -> States:
        """Evaluate n joint states, ``positions`` (n, q) [rad] or [m].

        A state is free if every pair is certified to be farther apart than ``clearance`` [m].
        Joints that are not named keep their live values. ``want`` is ``collision``, ``least`` or
        ``near`` (all pairs up to ``max_distance`` [m]). States that exceed one response are sent
        in several requests; after each, ``progress`` is called with the numbers of states done
        and of all. Raises RuntimeError if the scene changes between requests, and StaleError if
        the result rests on stale live poses, unless ``allow_stale``.
        """
        request = StatesRequest(
            list(joint_names),
            np.atleast_2d(np.asarray(positions, dtype=np.float64)),
            {
                'want': want,
                'clearance': clearance,
                'max_distance': 0.0 if want != 'near' else limit(max_distance),
                'poses': frame_poses(poses or {}),
                'stop_at_first': stop_at_first,
                'ignore_limits': ignore_limits,
                'accuracy': str(accuracy),
            },
        )
        answers = request.ask(partial(self.ask, 'evaluate_states'), progress)
        states = States.of(answers, self._table(answers[0].scene_version))
        if not allow_stale:
            refuse_stale('evaluate_states', states.stale_frames)
        return states

    def check_motion(
        self,
        end: Poses | None = None,
        *,
        start: Poses | None = None,
        joint_names: Sequence[str] = (),
        path: ArrayLike = (),
        times: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        profile: str = '',
        start_tolerance: float = 0.0,
        ignore_foreign_joints: bool = False,
        start_joints: JointValues | None = None,
        min_distance: float = 0.0,
        time_tolerance: float = TIME_TOLERANCE,
        interpolation: Literal['', 'slerp', 'screw'] | str = '',
        max_evaluations: int = 0,
        accuracy: AccuracyLike = '',
        ignore_start_contacts: bool = False,
        ignore_limits: bool = False,
        multi_dof_path: MultiDOFJointTrajectory | None = None,
        trajectory: Any = None,
        approach_time: float = 0.0,
        clearance_intervals: int = 0,
        allow_stale: bool = False,
    ) -> Motion:
        """Return whether a whole motion is clear of ``min_distance`` [m], for all times.

        Either frames move to the poses ``end``, from time 0 to 1, by ``interpolation`` 'slerp' or
        'screw'; or joints move along ``path`` (k, q) [rad] or [m], one column for each of
        ``joint_names``, in straight lines between rows, at ``times`` (k,) [s]. Without ``times``
        the path lasts from 0 to 1 and starts at its first row; a single row is the end.

        With ``velocities`` (k, q), and perhaps ``accelerations``, joints follow the splines on
        which a controller takes them; ``profile`` 'points' or 'spline' says so explicitly. A
        spline is refused where the joints are farther than ``start_tolerance`` (0: 0.01) from its
        first row, and where it leaves their limits. With ``ignore_foreign_joints``, joints that no
        robot of the scene has are left out, and named in the result.

        ``multi_dof_path`` has transforms of planar and floating joints, and of frames, at the
        times of ``path``. Instead of both, ``trajectory`` may be a message, a
        ``moveit_msgs/RobotTrajectory`` or a ``trajectory_msgs/JointTrajectory``.
        An ``approach_time`` > 0 [s] puts the straight way from where the joints are now in front,
        before time 0. ``clearance_intervals`` asks for bounds of the clearance over time.

        ``start`` and ``start_joints`` set the initial poses and joint values; all others are the
        live ones. A path whose first time is later than 0 begins there too. ``time_tolerance``
        [s] is the width to which the time of contact is bracketed. Raises StaleError if the
        result rests on stale live poses, unless ``allow_stale``.
        """
        rows = np.asarray(path, dtype=np.float64)
        derivatives = velocities, accelerations
        way, beside = JointTrajectory(), multi_dof_path or MultiDOFJointTrajectory()
        if trajectory is not None:
            if rows.size or multi_dof_path is not None:
                raise ValueError('trajectory is given, and so is path or multi_dof_path')
            way, beside = paths_of(trajectory)
        elif rows.size:
            way = joint_trajectory(joint_names, rows, times, *derivatives)
        answer = self.ask(
            'check_motion',
            start=frame_poses(start or {}),
            end=frame_poses(end or {}),
            start_joints=joint_positions(start_joints or {}),
            path=way,
            multi_dof_path=beside,
            start_now=approach_time != 0.0,
            approach_time=float(approach_time),
            clearance_intervals=clearance_intervals,
            profile=profile,
            start_tolerance=float(start_tolerance),
            ignore_foreign_joints=ignore_foreign_joints,
            min_distance=float(min_distance),
            time_tolerance=float(time_tolerance),
            interpolation=interpolation,
            max_evaluations=max_evaluations,
            accuracy=str(accuracy),
            ignore_start_contacts=ignore_start_contacts,
            ignore_limits=ignore_limits,
        )
        motion = Motion.of(answer)
        if not allow_stale:
            refuse_stale('check_motion', motion.stale_frames)
        return motion

    def watch_trajectory(
        self,
        joint_names: Sequence[str],
        path: ArrayLike,
        times: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        *,
        name: str = '',
        start: float | None = None,
        min_distance: float = 0.0,
        profile: str = '',
        deviation_tolerance: float = 0.0,
        time_budget: float = 0.0,
        accuracy: AccuracyLike = '',
        ignore_start_contacts: bool = False,
        ignore_limits: bool = False,
        ignore_foreign_joints: bool = False,
    ) -> str:
        """Have the node judge the rest of a trajectory that runs at each change of the scene.

        The trajectory is that of ``check_motion``, and starts at ``start`` [s] of the node's time
        (None: now). A judgement ends after ``time_budget`` [s] (0: no limit). Joints farther than
        ``deviation_tolerance`` (0: 0.05) from the trajectory are reported, and nothing is clear
        then. Returns the name under which ``trajectory_states`` reports it; a running one of that
        ``name`` is replaced.
        """
        rows = np.asarray(path, dtype=np.float64)
        trajectory = joint_trajectory(joint_names, rows, times, velocities, accelerations)
        if start is not None:
            trajectory.header.stamp = Time(nanoseconds=round(start * 1_000_000_000)).to_msg()
        answer = self.call(
            'watch_trajectory',
            name=name,
            path=trajectory,
            min_distance=float(min_distance),
            profile=profile,
            deviation_tolerance=float(deviation_tolerance),
            time_budget=float(time_budget),
            accuracy=str(accuracy),
            ignore_start_contacts=ignore_start_contacts,
            ignore_limits=ignore_limits,
            ignore_foreign_joints=ignore_foreign_joints,
        )
        return str(answer.name)

    def unwatch_trajectory(self, name: str) -> None:
        """End the watch of a trajectory."""
        self.call('unwatch_trajectory', name=name)

    def trajectory_states(self) -> dict[str, TrajectoryState]:
        """Return the last states of the watched trajectories by name; wait for the first ones."""
        if self._trajectories is None:
            self._trajectories = TrajectoryStates(self.node, self._server)
        listener = self._trajectories
        self.wait_for(lambda: listener.last is not None, 'the topic ~/trajectory_states')
        return dict(listener.last or {})

    def explain_filter(self, geometry_a: str, geometry_b: str) -> list[str]:
        """Return the reasons why a pair is filtered; empty if it is not."""
        answer = self.ask('explain_filter', geometry_a=geometry_a, geometry_b=geometry_b)
        return list(answer.reasons)

    def attach(
        self,
        frame: str,
        parent: str,
        X_PF: RigidTransform | ArrayLike | None = None,
        part_of_robot: bool = True,
        touch_links: Sequence[str] = (),
    ) -> RigidTransform:
        """Attach a frame to a parent of any source, where it is now or at X_PF; return X_PF.

        With ``part_of_robot``, name patterns that match the robot match the frame too, in rules
        and results. ``touch_links`` are names or patterns of what it may touch until ``detach``,
        or groups of an SRDF, such as ``['gripper']``: a transient filter excludes these pairs.
        """
        fields: dict[str, Any] = {
            'part_of_robot': part_of_robot,
            'touch_links': list(touch_links),
        }
        if X_PF is not None:
            fields |= {'pose_given': True, 'pose': _pose_message(X_PF)}
        return _pose_of(self.call('attach', frame=frame, parent=parent, **fields).pose)

    def detach(self, frame: str, X_PF: RigidTransform | ArrayLike | None = None) -> RigidTransform:
        """Detach a frame to its registered parent, where it is now or at X_PF; return X_PF."""
        fields = {} if X_PF is None else {'pose_given': True, 'pose': _pose_message(X_PF)}
        return _pose_of(self.call('detach', frame=frame, **fields).pose)

    def remove_source(self, source: str) -> tuple[int, int]:
        """Remove a source with its frames and geometries; return the numbers of both."""
        answer = self.call('remove_source', source=source)
        return int(answer.frames), int(answer.geometries)

    def pose_ages(self, frames: Sequence[str] = ()) -> dict[str, float]:
        """Return the pose ages [s] of frames by full name, oldest first; all if no names.

        0: the pose never becomes stale; inf: none was received, or none since the clock jumped.
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
        """Return results with the names that they refer to, all within the patience.

        The service is called again if the table with these names was skipped on ~/scene.
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
    """Return the message of a pose, a RigidTransform or x y z [m] qx qy qz qw."""
    values = X.ToArray() if isinstance(X, RigidTransform) else np.asarray(X, dtype=np.float64)
    x, y, z, qx, qy, qz, qw = values.tolist()
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))


def _pose_of(message: Pose) -> RigidTransform:
    p, q = message.position, message.orientation
    return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
