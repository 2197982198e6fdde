"""The node `pose_player`: plays a motion of a scene as FramePoses messages, TF or joint states.

Every message holds all frames of one moment, so that no cycle sees half of it moved. It also
publishes ``~/intended_contacts`` (latched, CollisionFilterDeclaration): one statement for each
grasp that holds now, the held frame against its gripper, as a gripper's driver would know it;
and it answers ``~/restart`` (std_srvs/Trigger): the motion begins anew, from its time 0.
"""

from __future__ import annotations

import array
import importlib.util
import sys
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from drake_geom_msgs.msg import (
    CollisionFilterDeclaration,
    CollisionFilterStatement,
    FramePoses,
    GeometrySet,
)
from geometry_msgs.msg import TransformStamped
from numpy.typing import NDArray
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.exceptions import NameValidationException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.frame_names import Frame, full_name
from drake_geom_ros.ros.parameters import ParameterRefusedError, declared, unknown_parameters
from drake_geom_ros.ros.spinning import run_node
from drake_geom_ros.ros.surface import transforms
from drake_geom_ros.ros.usage import is_help, usage
from drake_geom_ros.scene_files import SceneFileError, read_scene
from drake_geom_ros.trajectories.motion import Grasp, Motion
from drake_geom_ros.trajectories.motion_file import load_motion

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# A file, a parameter or the name of a topic that cannot be.
_REFUSALS = (SceneFileError, ParameterRefusedError, NameValidationException)
_TEXTS = {
    'scene_file': 'Scene (YAML or URDF) whose robots and frames are played.',
    'package_roots': 'Folders that package:// searches first, as for the node.',
    'trajectory_file': 'Motion (YAML) or timed poses (CSV); empty: everything stands still.',
    'world_frame': 'Name of the world frame in headers.',
    'topic': 'Topic of the poses.',
    'rate': 'Messages per second [Hz].',
    'tf': 'Send transforms on /tf instead of messages of poses; needs tf2_msgs.',
    'joint_states': 'Send the joints of robots on joint_states instead of poses of their links.',
    'loop': 'Start again at the end; otherwise hold the last poses and go on publishing.',
}
TOPIC = 'joint_states'


class PosePlayer(Node):
    """Publishes where every frame of a scene is, ``rate`` times a second."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('pose_player', **kwargs)
        scene_file = self._declare('scene_file', '')
        if not scene_file:
            raise ParameterRefusedError(
                'scene_file is empty; it must name a scene (YAML or URDF), as in '
                '--ros-args -p scene_file:=FILE'
            )
        trajectory_file = self._declare('trajectory_file', '')
        rate = self._declare('rate', 100.0, FloatingPointRange(from_value=0.1, to_value=1000.0))
        self._loop = self._declare('loop', True)
        package_roots = filter(None, self._declare('package_roots', ()))
        scene = read_scene(scene_file, package_roots=package_roots)
        for warning in scene.warnings:
            self.get_logger().warning(warning)
        self._motion = load_motion(trajectory_file or None, scene)
        for robot, reason in self._motion.left_out.items():
            self.get_logger().warning(f'{reason}. The links of {robot!r} are not posed')
        by_joints = self._declare('joint_states', False)
        self._joints = JointSender(self, self._motion) if by_joints else None
        self._sources = _sources(self._motion, by_joints=by_joints)
        self._message = FramePoses(frame_names=_full_names(self._motion, self._sources))
        self._message.header.frame_id = self._declare('world_frame', 'world')
        topic = self._declare('topic', '/scene_graph/frame_poses')
        self._poses = self.create_publisher(FramePoses, topic, QoSProfile(depth=5))
        by_tf = self._declare('tf', False)
        if by_tf and by_joints:
            raise ParameterRefusedError('tf and joint_states are both true; give one')
        if by_tf and importlib.util.find_spec('tf2_msgs') is None:
            raise ParameterRefusedError('tf is true, and the package tf2_msgs cannot be imported')
        self._transforms = TransformSender(self, self._motion) if by_tf else None
        self._contacts = self.create_publisher(
            CollisionFilterDeclaration, '~/intended_contacts', _LATCHED
        )
        self._service = self.create_service(Trigger, '~/restart', self._restart)
        self._start = self.get_clock().now()
        self._held: tuple[Grasp, ...] | None = None
        self._timer = self.create_timer(1.0 / rate, self._play)
        for warning in unknown_parameters(self):
            self.get_logger().warning(warning)
        by_poses = self._poses.topic_name if self._transforms is None else '/tf'
        played = [f'{counted(len(self._message.frame_names), "frame")} on {by_poses}']
        if self._joints is not None:
            robots = counted(len(self._motion.robots), 'robot')
            played = [f'{robots} on {self._joints.topic_name}', *played]
        self.get_logger().info(
            f'playing {" and ".join(played)} at '
            f'{rate:g} Hz, {self._motion.duration:g} s long{", repeating" * self._loop}'
        )

    def _declare(
        self, name: str, default: object, limits: FloatingPointRange | None = None
    ) -> Any:
        descriptor = ParameterDescriptor(
            description=_TEXTS[name],
            read_only=True,
            floating_point_range=[] if limits is None else [limits],
        )
        return declared(self, name, default, descriptor)

    def _restart(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Begin anew; the answer comes before the first pose of the new beginning."""
        self._start = self.get_clock().now()
        response.success = True
        response.message = f'{self._motion.duration:g} s long'
        return response

    def _play(self) -> None:
        """Publish the poses of now, and the intended contacts where they changed."""
        now = self.get_clock().now()
        time = (now - self._start).nanoseconds * 1e-9
        if self._loop and self._motion.duration > 0.0:
            time %= self._motion.duration
        if self._joints is not None:
            self._joints.send(time, now.to_msg())
        poses = self._motion.poses(time) if self._sources else {}
        if self._transforms is not None:
            self._transforms.send(poses, self._message.header.frame_id, now.to_msg())
        elif self._sources:
            self._send(poses, now.to_msg())
        held = self._motion.held(time)
        if held != self._held:
            self._held = held
            self._contacts.publish(
                CollisionFilterDeclaration(statements=[_statement(grasp) for grasp in held])
            )

    def _send(self, poses: dict[str, NDArray[np.float64]], stamp: Any) -> None:
        flat = np.concatenate([poses[source].ravel() for source in self._sources])
        self._message.header.stamp = stamp
        self._message.poses = array.array('d', flat.tobytes())
        self._poses.publish(self._message)


def _sources(motion: Motion, *, by_joints: bool) -> list[str]:
    """Return the sources whose frames are posed by messages.

    Beside joint states those count that have a frame which moves: what rests stands where the
    scene file says, and whoever takes it is not fought with.
    """
    if not by_joints:
        return list(motion.frame_names)
    grasped = {grasp.frame[0] for grasp in motion.grasps}
    moving = {source for (source, _), poses in motion.free.items() if poses.moves}
    return [source for source in motion.frame_names if source in grasped | moving]


def _full_names(motion: Motion, sources: list[str]) -> list[str]:
    return [full_name((source, n)) for source in sources for n in motion.frame_names[source]]


def _statement(grasp: Grasp) -> CollisionFilterStatement:
    """Return the statement that excludes the contacts of a grasp."""
    return CollisionFilterStatement(
        operation=CollisionFilterStatement.EXCLUDE_BETWEEN,
        set_a=GeometrySet(frames=[full_name(grasp.frame)]),
        set_b=GeometrySet(frames=list(map(full_name, grasp.gripper))),
    )


def main(args: list[str] | None = None) -> int:
    """Run the player until it is interrupted; return 2 where it is given what it cannot play."""
    if is_help(args):
        print(
            usage(
                'pose_player',
                example='-p scene_file:=FILE [-p trajectory_file:=FILE]',
                description='Plays a motion of a scene as FramePoses messages, on /tf, or as '
                'joint states.',
                texts=_TEXTS,
                see='docs/motion_files.md has the formats; ~/restart (std_srvs/Trigger) begins '
                'anew.',
            )
        )
        return 0
    return run_node(PosePlayer, _REFUSALS, args)


if __name__ == '__main__':
    sys.exit(main())


class TransformSender:
    """Publishes on /tf what moves; what rests is where the scene file puts it."""

    def __init__(self, node: Node, motion: Motion) -> None:
        """Send with ``node``; raises ImportError without tf2_msgs, which not everybody has."""
        from tf2_msgs.msg import TFMessage

        self._message = TFMessage
        self._publisher = node.create_publisher(TFMessage, '/tf', transforms(static=False))
        grasped = {grasp.frame for grasp in motion.grasps}
        counts = Counter(name for names in motion.frame_names.values() for name in names)
        # Source, row in its poses, name in TF, and that of what carries it; empty: the world.
        self._sent: list[tuple[str, int, str, str]] = []
        for source, names in motion.frame_names.items():
            for row, name in enumerate(names):
                frame = source, name
                if source in motion.robots or motion.free[frame].moves or frame in grasped:
                    robot = motion.robots.get(source)
                    carrier = robot.carrier if robot else None
                    parent = '' if carrier is None else _name(carrier, counts)
                    self._sent.append((source, row, _name(frame, counts), parent))

    def send(self, poses: Mapping[str, NDArray[Any]], world_frame: str, stamp: Any) -> None:
        """Send ``poses`` X_PF (frames, 7) by source."""
        message = self._message()
        for source, row, name, parent in self._sent:
            entry = TransformStamped(child_frame_id=name)
            entry.header.frame_id, entry.header.stamp = parent or world_frame, stamp
            p, q = entry.transform.translation, entry.transform.rotation
            p.x, p.y, p.z, q.x, q.y, q.z, q.w = poses[source][row].tolist()
            message.transforms.append(entry)
        self._publisher.publish(message)


def _name(frame: Frame, counts: Mapping[str, int]) -> str:
    """Return what TF calls a frame: its own name where it is the only one of that name."""
    source, name = frame
    return name if counts.get(name, 1) == 1 else f'{source}/{name}'


class JointSender:
    """Publishes where the joints of all robots of a motion are."""

    def __init__(self, node: Node, motion: Motion) -> None:
        """Joints are called `joint`, or `robot::joint` where two robots have one of that name."""
        self._motion = motion
        self._publisher = node.create_publisher(JointState, TOPIC, QoSProfile(depth=5))
        names = [
            (r, j) for r, robot in motion.robots.items() for j in robot.kinematics.joint_names
        ]
        counts = Counter(joint for _, joint in names)
        self._names = [j if counts[j] == 1 else f'{robot}::{j}' for robot, j in names]

    @property
    def topic_name(self) -> str:
        """The topic, with its namespace."""
        return str(self._publisher.topic_name)

    def send(self, time: float, stamp: Any) -> None:
        """Send the joint values at a time [s] of the motion."""
        values = [robot.joint_values.value(time) for robot in self._motion.robots.values()]
        message = JointState(name=self._names, position=np.concatenate(values).tolist())
        message.header.stamp = stamp
        self._publisher.publish(message)
