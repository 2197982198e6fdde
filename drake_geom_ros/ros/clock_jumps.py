"""Notices when the node's time jumps: ages of poses are unknown then, until they come anew.

Simulated time begins anew with a simulation or a bag; the time of day is set by hand, by a time
server, or after a machine has slept.
"""

from __future__ import annotations

from rclpy.clock import ClockChange, JumpThreshold, ROSClock, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.scene.clocks import JUMP_BACKWARD, JUMP_FORWARD, Clocks

THRESHOLD = JumpThreshold(
    min_forward=Duration(seconds=JUMP_FORWARD), min_backward=Duration(seconds=-JUMP_BACKWARD)
)
_CHANGES = {
    ClockChange.ROS_TIME_ACTIVATED: 'is simulated time from now on',
    ClockChange.ROS_TIME_DEACTIVATED: 'is the time of day from now on',
}


class ClockJumps:
    """Lets ages begin anew where the node's time jumps, and says so."""

    def __init__(self, clocks: Clocks, node: Node, guard: Guard) -> None:
        self.count = 0
        self._clocks = clocks
        self._node = node
        self._guard = guard

    def simulated(self, jump: TimeJump) -> None:
        """Take note of a jump of simulated time; must not block, nor raise."""
        self._guard.attempt(lambda: self._simulated(jump))

    def _simulated(self, jump: TimeJump) -> None:
        now = self._node.get_clock().now().nanoseconds
        self._clocks.forget_steps()
        if change := _CHANGES.get(jump.clock_change):
            self._told(change)
        elif now == jump.delta.nanoseconds:
            self._clocks.begin_anew()  # the first time that is told: before, there was none
        else:
            self._told(f'jumped by {jump.delta.nanoseconds * 1e-9:.3f} s')

    def look(self) -> None:
        """Look whether the time of day jumped."""
        clock = self._node.get_clock()
        if isinstance(clock, ROSClock) and clock.ros_time_is_active:
            return
        if step := self._clocks.step():
            self._told(f'jumped by {step:.3f} s')

    def _told(self, what: str) -> None:
        self._clocks.begin_anew()
        self.count += 1
        self._guard.tell(
            'the clock',
            f"the node's time {what}: ages of poses are unknown until new poses arrive",
        )
