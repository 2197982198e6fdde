"""Says stop as long as the robot may be nearer than 5 cm to anything, or nobody can know.

It stops by the lower end of each certified distance, on poses that are old or of unknown age,
where the robot is not in the scene or not posed, and on results that do not come: these stop when
poses stop, so that silence must never look like safety. Services let the gripper touch an object
(``~/expect_contact``), take it (``~/attach``) and put it down (``~/release``). This is an example
and no safety function: see docs/what_it_vouches_for.md.
"""

import time

import numpy as np
import rclpy
from drake_geom_msgs import msg
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from drake_geom_ros.client import (
    HeldFilter,
    RefusedError,
    SceneListener,
    Services,
    UnknownNameError,
    exclude_between,
)

PERIOD = 0.02  # [s] between two words on ~/stop
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class StopMonitor(Node):
    """Publishes ``~/stop`` (Bool) all the time, and logs each change with its reason."""

    def __init__(self):
        super().__init__('stop_monitor')
        self._robot = self.declare_parameter('robot', 'ur5').value
        self._object = self.declare_parameter('object', 'cell::part').value
        self._gripper = self.declare_parameter('gripper', 'ur5::tool0').value
        self._stop_distance = self.declare_parameter('stop_distance', 0.05).value
        self._oldest_pose = self.declare_parameter('oldest_pose', 0.3).value
        self._longest_silence = self.declare_parameter('longest_silence', 0.3).value
        # Names without a slash are in the monitor's own namespace, as the node's are.
        self._asked = Services(self, 'scene_graph')
        self._listener = SceneListener(self, 'scene_graph')
        self._listener.on_signed_distances(self._take)
        self._heard, self._danger, self._told = -np.inf, ('', ''), None
        self._holding, self._attached = None, False
        self._stop = self.create_publisher(Bool, '~/stop', LATCHED)
        waiting = ReentrantCallbackGroup()  # an answer waits for other answers
        for name in ('expect_contact', 'attach', 'release'):
            act = self._answering(getattr(self, f'_{name}'))
            self.create_service(Trigger, f'~/{name}', act, callback_group=waiting)
        # Real time: simulated time may rest while poses are lost.
        self.create_timer(PERIOD, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # When to stop.

    def _take(self, distances):
        self._heard = time.monotonic()
        try:
            self._danger = self._danger_in(distances)
        except UnknownNameError as error:  # misspelt, not there yet, or gone
            self._danger = 'nobody to watch', str(error)

    def _danger_in(self, distances):
        """Return what in a result is a reason to stop, and its figure; empty where nothing is."""
        if not distances.max_distance >= self._stop_distance:
            return 'results do not reach far enough', f'max_distance {distances.max_distance:g} m'
        if not distances.between(self._robot).is_complete:
            return 'not all is posed', ', '.join(distances.waiting_frames[:5])
        if not distances.oldest_pose_age <= self._oldest_pose:
            return 'poses are old', f'{distances.oldest_pose_age:.3g} s'
        moving = distances.table.ids(self._robot)
        if self._attached:
            moving = np.append(moving, distances.table.ids(self._object))
        # Pairs of what moves with what does not; the arm's distances from itself are its own.
        outward = np.isin(distances.id_a, moving) != np.isin(distances.id_b, moving)
        rows = np.flatnonzero(outward & (distances.lower_bound < self._stop_distance))
        if not len(rows):
            return '', ''
        pair = distances[int(rows[np.argmin(distances.lower_bound[rows])])]
        names = f'{pair.source_a}::{pair.name_a} to {pair.source_b}::{pair.name_b}'
        return names, f'{pair.lower_bound:.4f} m'

    def _tell(self):
        silence = time.monotonic() - self._heard
        reason, figure = self._danger
        if silence > self._longest_silence:
            reason, figure = 'no result', f'for more than {self._longest_silence:g} s'
        self._stop.publish(Bool(data=bool(reason)))
        if reason != self._told:
            self._told = reason
            self.get_logger().info(f'stop: {reason}: {figure}' if reason else 'go')

    # The object that the gripper takes.

    def _answering(self, act):
        async def answer(_, response):
            try:
                response.message = await act()
                response.success = True
            except (RefusedError, UnknownNameError) as error:
                response.message = str(error)
            return response

        return answer

    async def _expect_contact(self):
        """Let the gripper's frame touch the object, on a lease that is renewed."""
        if self._holding is None:
            sets = (msg.GeometrySet(frames=[name]) for name in (self._gripper, self._object))
            declaration = msg.CollisionFilterDeclaration(statements=[exclude_between(*sets)])
            holding = HeldFilter(self, self._asked, declaration, self._lost)
            await holding.hold()
            self._holding = holding
        return f'{self._gripper} may touch {self._object}'

    async def _attach(self):
        """Have the object follow the gripper from where it is; to be called while both rest."""
        await self._expect_contact()
        await self._asked.ask('attach', frame=self._object, parent=self._gripper)
        self._attached = True
        return f'{self._object} follows {self._gripper}'

    async def _release(self):
        """Leave the object where it is; the gripper has the length of a lease to withdraw."""
        if self._attached:
            await self._asked.ask('detach', frame=self._object)
        self._attached = False
        if self._holding is not None:
            self._holding.let_run_out()
            self._holding = None
        return f'{self._object} stays where it is'

    def _lost(self):
        self._holding = None
        self.get_logger().warning('the filter is gone: the gripper must not touch the object')

    def stop_for_good(self):
        """Leave stop as the last word."""
        self._stop.publish(Bool(data=True))


def main():
    """Watch until interrupted."""
    rclpy.init()
    monitor = StopMonitor()
    try:
        rclpy.spin(monitor)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:  # what rclpy raises where a signal ends its context while it waits
        if rclpy.ok():
            monitor.stop_for_good()
            raise
    except BaseException:
        monitor.stop_for_good()
        raise
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
