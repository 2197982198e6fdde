"""Processor time that a message costs: with the executor of a group, and with those of rclpy.

    ./run exec python -m bench.ros.executors [--turns 3] [--seconds 2]

A server has as many services as the node and one callback group that answers poses of two arms
with the same message. It is started anew for each turn; this process sends at a rate, to one
executor after the other: that of a group with a wait set that it keeps, the same with what rclpy
makes anew, and rclpy's of events. The thread's time counts, from the first message to the last:
microseconds a message, of each turn.

The events executor (in Kilted; Jazzy has none) knows no guard conditions, which the node's group
of poses has, and serves all entities of a node unless it is given something that stands for one.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any

import rclpy
from drake_geom_msgs.msg import FramePoses
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from bench.ros.processes import Processes
from bench.ros.routes import POSES
from drake_geom_ros.ros.spinning import GroupExecutor

KINDS = 'group', 'rclpy', 'events'
SERVICES, FRAMES = 60, 18
ENTITIES = ('subscriptions', 'timers', 'clients', 'services', 'guards', 'waitables')
LAST = 'last'  # the source of the message that ends a turn


class NodeOfGroup:
    """A node with the entities of one group alone."""

    def __init__(self, node: Node, group: CallbackGroup) -> None:
        self._node, self._group = node, group

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._node, name)
        return [e for e in value if e.callback_group is self._group] if name in ENTITIES else value


def executor_of(kind: str, node: Node, group: CallbackGroup) -> Any:
    """Return what serves a group of a node."""
    if kind != 'events':
        executor = GroupExecutor(node, group)
        if kind == 'rclpy':
            executor._waits = None
        return executor
    from rclpy.experimental.events_executor import EventsExecutor

    executor = EventsExecutor()
    executor.add_node(NodeOfGroup(node, group))  # type: ignore[arg-type]
    return executor


def serve(kind: str) -> None:
    """Answer messages until the last one, and print what each cost [us]."""
    rclpy.init()
    node, group = rclpy.create_node('server'), MutuallyExclusiveCallbackGroup()
    for k in range(SERVICES):
        node.create_service(Trigger, f'~/service_{k}', lambda _, response: response)
    answers = node.create_publisher(FramePoses, '~/answers', 10)
    times: list[float] = []
    is_over = False

    def answer(message: FramePoses) -> None:
        nonlocal is_over
        is_over = message.source == LAST
        answers.publish(message)
        times.append(time.thread_time())

    node.create_subscription(FramePoses, '~/poses', answer, POSES, callback_group=group)
    executor = executor_of(kind, node, group)
    while not is_over:
        executor.spin_once(timeout_sec=0.1)
    print((times[-2] - times[0]) / (len(times) - 2) * 1e6, flush=True)


def cost(processes: Processes, kind: str, rate: float, seconds: float) -> float:
    """Return what a message costs [us] in a server of its own."""
    server = processes.start('bench.ros.executors', '--serve', kind)
    node = rclpy.create_node('driver')
    publisher = node.create_publisher(FramePoses, '/server/poses', POSES)
    while not publisher.get_subscription_count():
        time.sleep(0.1)
    names = [f'frame_{k}' for k in range(FRAMES)]
    message = FramePoses(frame_names=names, poses=[0.0] * 7 * FRAMES)
    start = time.perf_counter()
    for k in range(round(rate * seconds)):
        time.sleep(max(0.0, start + k / rate - time.perf_counter()))
        publisher.publish(message)
    while server.poll() is None:  # a message of best effort may be lost
        publisher.publish(FramePoses(source=LAST))
        time.sleep(0.1)
    printed = server.stdout.read()
    processes.forget(server)
    node.destroy_node()
    return float(printed.split()[-1])


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.ros.executors', description=__doc__.split('\n')[0]
    )
    parser.add_argument('--turns', type=int, default=3)
    parser.add_argument('--seconds', type=float, default=2.0)
    parser.add_argument('--serve', choices=KINDS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.serve)
        sys.exit()
    rclpy.init()
    with Processes() as processes:
        for rate in (100.0, 500.0):
            costs: dict[str, list[float]] = {kind: [] for kind in KINDS}
            for _ in range(options.turns):
                for kind, its in costs.items():
                    its.append(cost(processes, kind, rate, options.seconds))
            for kind, its in costs.items():
                cells = ''.join(f'{value:8.0f}' for value in its)
                print(f'{rate:6.0f} Hz  {kind:8}{cells}   [us]', flush=True)


if __name__ == '__main__':
    main()
