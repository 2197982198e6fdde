"""A subscriber of images that only notes which came when; on SIGTERM it prints one line of JSON.

That is a list of time, topic and stamp of each image: the time is that of the steady clock [s],
which processes of a machine share, the topic its number among the arguments, and the stamp is in
nanoseconds.

    python -m bench.ros.image_listener TOPIC ...
"""

from __future__ import annotations

import json
import sys
import time
from functools import partial

import numpy as np
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
        self.came: list[tuple[float, int, int]] = []
        for number, topic in enumerate(topics):
            take = partial(self._take, number)
            self.create_subscription(Image, topic, take, QoSProfile(depth=10), raw=True)

    def _take(self, topic: int, image: bytes) -> None:
        # An Image begins with its stamp; four bytes before it tell how numbers are written.
        seconds, nanoseconds = np.frombuffer(image, '<i4', 2, 4).tolist()
        self.came.append((time.monotonic(), topic, 10**9 * seconds + nanoseconds))


def main() -> None:
    """Listen until told to stop, then print."""
    with StopSignals() as signals:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = ImageListener(sys.argv[1:])
        spin_until_stopped(node, signals)
        rclpy.try_shutdown()
    print(json.dumps(node.came), flush=True)


if __name__ == '__main__':
    main()
