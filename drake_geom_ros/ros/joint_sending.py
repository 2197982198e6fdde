"""Sends the joint values of a motion, as the drivers of its robots would."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from drake_geom_ros.trajectories.motion import Motion

TOPIC = 'joint_states'


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
