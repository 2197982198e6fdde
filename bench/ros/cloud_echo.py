"""The bare round trip of a cloud: answers each with its stamp. Plain rclpy, nothing computed."""

from __future__ import annotations

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header


def main() -> None:
    """Answer each cloud with its header."""
    rclpy.init()
    node = rclpy.create_node('echo')
    publisher = node.create_publisher(Header, '~/heard', 10)
    newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(
        PointCloud2, '~/clouds', lambda cloud: publisher.publish(cloud.header), newest
    )
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main()
