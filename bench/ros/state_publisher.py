"""Joint states in, TF out: what ``robot_state_publisher`` does, for robots of a scene file."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from bench.ros.routes import POSES
from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped
from drake_geom_ros.ros.surface import transforms
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories import Kinematics
from drake_geom_ros.trajectories.pose_matrices import inverse, poses_of_matrices


class StatePublisher(Node):
    """Sends, for each message of joint values, the transform of each link in its parent link."""

    def __init__(self, scene_file: str) -> None:
        super().__init__('state_publisher')
        scene = read_scene(scene_file)
        self._robots = [(r, Kinematics(r.tree)) for r in scene.robots if r.tree is not None]
        self._tf = self.create_publisher(TFMessage, '/tf', transforms(static=False))
        self._static = self.create_publisher(TFMessage, '/tf_static', transforms(static=True))
        self.create_subscription(JointState, '/to_state_publisher', self._take, POSES)
        bases = [
            _transform('world', f'{robot.name}/{arm.link_names[0]}', robot.X_WB.ToArray(), None)
            for robot, arm in self._robots
        ]
        self._static.publish(TFMessage(transforms=bases))

    def _take(self, message: JointState) -> None:
        values = dict(zip(message.name, message.position, strict=True))
        sent = []
        for robot, arm in self._robots:
            q = np.array([values[f'{robot.name}::{joint}'] for joint in arm.joint_names])
            X_BLs = arm.link_transforms(q)
            rows = {link: row for row, link in enumerate(arm.link_names)}
            ends = [(rows[parent], rows[child]) for parent, child in arm.joined_links]
            parents, children = np.array(ends).T
            poses = poses_of_matrices(inverse(X_BLs[parents]) @ X_BLs[children])
            for (parent, child), X in zip(arm.joined_links, poses, strict=True):
                names = f'{robot.name}/{parent}', f'{robot.name}/{child}'
                sent.append(_transform(*names, X, message.header.stamp))
        self._tf.publish(TFMessage(transforms=sent))


def _transform(parent: str, child: str, X_PC: Any, stamp: Any) -> TransformStamped:
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    if stamp is not None:
        entry.header.stamp = stamp
    p, q = entry.transform.translation, entry.transform.rotation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = X_PC.tolist()
    return entry


def main() -> None:
    """Publish until told to stop."""
    with StopSignals() as signals:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        spin_until_stopped(StatePublisher(sys.argv[1]), signals)
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
