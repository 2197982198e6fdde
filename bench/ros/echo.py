"""The bare round trip: answers each FramePoses with a result message of the node's size.

Plain rclpy: one node, one executor, nothing computed.
"""

from __future__ import annotations

import contextlib

import rclpy
from drake_geom_msgs.msg import FramePoses, SignedDistancePairs
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile, ReliabilityPolicy


def main() -> None:
    """Answer each pose message with the template that came last."""
    rclpy.init()
    node = rclpy.create_node('echo')
    template = SignedDistancePairs()

    def keep(message: SignedDistancePairs) -> None:
        nonlocal template
        template = message

    def answer(message: FramePoses) -> None:
        template.header.stamp = message.header.stamp
        publisher.publish(template)

    poses = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(SignedDistancePairs, '~/signed_distances', 10)
    node.create_subscription(SignedDistancePairs, '~/template', keep, 10)
    node.create_subscription(FramePoses, '~/frame_poses', answer, poses)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == '__main__':
    main()
