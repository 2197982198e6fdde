"""From the pose that makes a rule true to its event at a subscriber, beside a bare round trip.

    ./run exec python -m bench.ros.event_delays [--rates 100 500] [--seconds 30]

Two arms move, their motion five times as fast as in the demo; 20 rules of one arm against the
other, from 1 cm to 50 cm, are entered and left by poses that this process sends at a rate. An
event tells by its stamp which pose made it; the bare route answers each pose with an empty
message. Both take turns within one run. Milliseconds; the ratio says more than either.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import rclpy
from drake_geom_msgs import msg, srv
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bench.ros.processes import Processes
from bench.ros.routes import Route, stream
from bench.ros.scenes import Played, two_arms

NODE = 'drake_geom_ros.ros.scene_graph_node'
TURNS, RULES, FASTER = 4, 20, 5.0
NEAREST, FARTHEST, ROOM = 0.01, 0.5, 0.001  # [m] of the rules' enter, and leave beyond


class EventRoute(Route):
    """A route whose answers are events; nobody listens to distances."""

    events = 0

    def listen(self, node: Node) -> None:
        """Listen to events."""
        kind, topic = msg.ProximityEvents, f'/{self.server}/proximity_events'
        node.create_subscription(kind, topic, self._hear, QoSProfile(depth=1000))

    def _hear(self, message: msg.ProximityEvents) -> None:
        self.events += len(message.sequence)
        number = self.number_of(message.header.stamp)
        if number in self.sent and number not in self.delays:
            self.delays[number] = time.perf_counter() - self.sent[number]


def add_rules(node: Node, executor: SingleThreadedExecutor) -> None:
    """Add the rules, each with limits of its own."""
    client = node.create_client(srv.AddProximityRule, '/scene_graph/add_proximity_rule')
    while not client.service_is_ready():
        executor.spin_once(timeout_sec=0.1)
    for k, enter in enumerate(np.linspace(NEAREST, FARTHEST, RULES)):
        rule = msg.ProximityRule(name=f'{k}', set_a=['left'], set_b=['right'], level=1)
        rule.enter, rule.leave = float(enter), float(enter) + ROOM
        future = client.call_async(srv.AddProximityRule.Request(rule=rule))
        executor.spin_until_future_complete(future)
        if not future.result().success:
            raise RuntimeError(future.result().message)


def measure(node: Node, played: Played, rate: float, seconds: float) -> str:
    """Stream to both in turns; return a row of the table."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    ours, bare = EventRoute(node, 'scene_graph'), Route(node, 'echo')
    while not all(route.publisher.get_subscription_count() for route in (ours, bare)):
        executor.spin_once(timeout_sec=0.1)
    for _ in range(TURNS):
        stream(executor, ours, played, rate, seconds / TURNS)
        stream(executor, bare, played, rate, seconds / TURNS)
    executor.remove_node(node)
    told = [np.array(route.result()[0]) * 1e3 for route in (ours, bare)]
    figures = [(d.mean(), *np.percentile(d, (50, 99))) for d in told]
    cells = ''.join(f'{value:9.2f}' for row in figures for value in row)
    return f'{rate:6g}{ours.events:8}{cells}{figures[0][2] / figures[1][2]:9.2f}'


def main() -> None:
    """Measure at all rates, and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--rates', nargs='+', type=float, default=[100.0, 500.0])
    parser.add_argument('--seconds', type=float, default=30.0, help='of streaming to each')
    options = parser.parse_args()
    arms = two_arms()
    fast = Played(arms.scene_file, arms.frame_names, lambda time: arms.poses(FASTER * time))
    print(f'{"rate":>6}{"events":>8}{"mean":>9}{"p50":>9}{"p99":>9}{"bare mean":>10}{"p50":>8}'
          f'{"p99":>9}{"p99 ratio":>10}   [Hz], [ms]')  # fmt: skip
    with Processes() as processes:
        processes.start(NODE, scene_file=arms.scene_file, max_distance=0.1)
        processes.start('bench.ros.echo')
        for number, rate in enumerate(options.rates):
            rclpy.init()
            node = rclpy.create_node('driver')
            if not number:
                executor = SingleThreadedExecutor()
                executor.add_node(node)
                add_rules(node, executor)
                executor.remove_node(node)
            print(measure(node, fast, rate, options.seconds), flush=True)
            rclpy.shutdown()


if __name__ == '__main__':
    main()
