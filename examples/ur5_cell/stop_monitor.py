"""Says stop as long as a proximity rule does, or nobody can know.

The rules are in cell.yaml, and the scene_graph node decides about them; silence and a rule that is
not there are reasons to stop, too. Services handle the part: see gripper.py. This is an example
and no safety function: see docs/what_it_vouches_for.md.
"""

import rclpy
from gripper import Gripper
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Bool

from drake_geom_ros.client import ProximityMonitor
from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped

PERIOD = 0.02  # [s] between two words on ~/stop
PATIENCE = 5.0  # [s] for listeners to have the last one
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class StopMonitor(Node):
    """Publishes ``~/stop`` (Bool) all the time, and logs each event and each change."""

    def __init__(self):
        super().__init__('stop_monitor')
        rules = self.declare_parameter('rules', ['hands off']).value
        self._stop = self.create_publisher(Bool, '~/stop', LATCHED)
        # A name without a slash is in the monitor's own namespace, as the node is.
        self._monitor = ProximityMonitor(
            self, 'scene_graph', rules=rules, on_event=self._log, on_change=self._say
        )
        self._gripper = Gripper(self)
        # Real time: simulated time may rest while poses are lost.
        self.create_timer(PERIOD, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _log(self, event):
        verb = 'entered' if event.entered else 'left'
        pair = f': {event.geometry_a} to {event.geometry_b}' if event.geometry_b else ''
        self.get_logger().info(f'{event.rule} {verb}, {event.why}{pair}: {event.distance:.4f} m')

    def _say(self, reason):
        self._tell()
        self.get_logger().info(f'stop: {reason}' if reason else 'go')

    def _tell(self):
        self._stop.publish(Bool(data=bool(self._monitor.why_stop())))

    def stop_for_good(self):
        """Leave stop as the last word: a writer that ends does not send it again."""
        self._stop.publish(Bool(data=True))
        self._stop.wait_for_all_acked(Duration(seconds=PATIENCE))


def main():
    """Watch until interrupted, or until a callback fails."""
    with StopSignals() as signals:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        monitor = StopMonitor()
        try:
            spin_until_stopped(monitor, signals)
        finally:
            monitor.stop_for_good()
            monitor.destroy_node()
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
