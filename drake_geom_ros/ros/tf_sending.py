"""Sends the poses of a motion as transforms in the world, as robot_state_publisher would."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from geometry_msgs.msg import TransformStamped
from numpy.typing import NDArray
from rclpy.node import Node

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.ros.surface import transforms
from drake_geom_ros.trajectories.motion import Motion


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
