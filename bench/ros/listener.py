"""A subscriber that measures: delay from the stamp of the poses to the arrival of the result.

On SIGTERM it prints one line of JSON: how many results came, and quantiles of the delay [ms].
"""

from __future__ import annotations

import json
import time

import numpy as np
import rclpy
from drake_geom_msgs.msg import SignedDistancePairs
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped

QUANTILES = (50.0, 99.0, 99.9, 100.0)


class Listener(Node):
    """Keeps the delay of every result."""

    def __init__(self) -> None:
        super().__init__('listener')
        self._delays: list[float] = []
        topic = '/scene_graph/signed_distances'
        self.create_subscription(SignedDistancePairs, topic, self._take, QoSProfile(depth=100))

    def _take(self, message: SignedDistancePairs) -> None:
        stamp = message.header.stamp
        self._delays.append(time.time() - stamp.sec - 1e-9 * stamp.nanosec)

    def report(self) -> dict[str, object]:
        """Return the count and the quantiles, None where nothing came."""
        delays = np.array(self._delays) * 1e3
        quantiles = np.percentile(delays, QUANTILES).tolist() if len(delays) else None
        return {'results': len(delays), 'delay_ms': quantiles}


def main() -> None:
    """Listen until told to stop, then print."""
    with StopSignals() as signals:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = Listener()
        spin_until_stopped(node, signals)
        rclpy.try_shutdown()
    print(json.dumps(node.report()), flush=True)


if __name__ == '__main__':
    main()
