"""A subscriber of images that only notes when they came; on SIGTERM it prints one line of JSON.

The times are those of the steady clock [s], which processes of a machine share.

    python -m bench.ros.image_listener TOPIC ...
"""

from __future__ import annotations

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Image

from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped


class ImageListener(Node):
    """Counts what comes, as bytes: a reader of images costs more, and another process's time."""

    def __init__(self, topics: list[str]) -> None:
        super().__init__('image_listener')
        self.times: list[float] = []
        for topic in topics:
            self.create_subscription(Image, topic, self._take, QoSProfile(depth=10), raw=True)

    def _take(self, image: bytes) -> None:
        self.times.append(time.monotonic())


def main() -> None:
    """Listen until told to stop, then print."""
    with StopSignals() as signals:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = ImageListener(sys.argv[1:])
        spin_until_stopped(node, signals)
        rclpy.try_shutdown()
    print(json.dumps(node.times), flush=True)


if __name__ == '__main__':
    main()
