"""A subscriber that never reads: its queues fill, and nobody may wait for it."""

import time

import rclpy
from drake_geom_msgs.msg import PenetrationPairs, Scene, SignedDistancePairs
from rclpy.signals import SignalHandlerOptions


def main() -> None:
    """Subscribe to what the node publishes, and sleep until ended."""
    # rclpy's own handler would let it sleep on after SIGTERM.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('deaf')
    topics = {'signed_distances': SignedDistancePairs, 'penetrations': PenetrationPairs}
    topics['scene'] = Scene
    for name, kind in topics.items():
        node.create_subscription(kind, f'/scene_graph/{name}', print, 10)
    print('deaf', flush=True)
    while True:
        time.sleep(60.0)


if __name__ == '__main__':
    main()
