"""Ten thousand changes of proximity rules a second, and whether each number of an event is heard.

    ./run exec python -m bench.ros.many_changes [--seconds 20]

A ball leaps to and fro between near and far at a fixed rate, and each pose changes all rules. The
listener has the queue of ``ProximityMonitor`` and is busy now and then for as long as is told, so
that messages wait. Sequence numbers that are missing were lost on their way.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
from drake_geom_msgs import msg
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bench.ros.processes import Processes
from bench.ros.routes import POSES

NODE = 'drake_geom_ros.ros.scene_graph_node'
SERVER = '/scene_graph'
ARMS = (20, 500.0), (100, 100.0)  # rules, and poses [Hz]: 10 000 changes a second each
BUSY = 0.0, 0.1, 0.5  # [s] of each second in which the listener takes nothing
LAST = 2.0  # [s] to hear the last events
SCENE = """
name: cell
sources: [arm]
frames:
- {name: hand, source: arm, static: false}
geometries:
- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: post, shape: {type: box, size: [0.2, 0.2, 2]}}
proximity_rules:
"""
RULE = '- {{name: rule {}, set_a: arm, level: warn, enter: 0.1, leave: 0.2}}'
NEAR, FAR = 0.25, 1.0  # [m] of the ball's centre


class Listener:
    """Keeps numbers of events, and how long these were on their way."""

    def __init__(self, node: Node, depth: int) -> None:
        topic = f'{SERVER}/proximity_events'
        node.create_subscription(msg.ProximityEvents, topic, self._hear, QoSProfile(depth=depth))
        self.numbers: list[int] = []
        self.sent: dict[int, float] = {}
        self.delays: list[float] = []

    def _hear(self, message: msg.ProximityEvents) -> None:
        self.numbers += message.sequence
        self.delays.append(time.perf_counter() - self.sent[message.header.stamp.sec])

    def missing(self) -> int:
        """Return how many numbers are missing, between the first and the last one heard."""
        heard = np.diff(self.numbers)
        if (heard < 1).any():
            raise RuntimeError('a number was heard twice, or out of order')
        return int((heard - 1).sum())


def measure(rules: int, rate: float, busy: float, seconds: float, depth: int) -> str:
    """Return a row of the table."""
    rclpy.init()
    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        scene = Path(folder) / 'scene.yaml'
        scene.write_text(SCENE + '\n'.join(RULE.format(k) for k in range(rules)) + '\n')
        processes.start(NODE, scene_file=scene, stale_after=1e6)
        node, executor = rclpy.create_node('leaping'), SingleThreadedExecutor()
        executor.add_node(node)
        listener = Listener(node, depth)
        poses = node.create_publisher(msg.FramePoses, f'{SERVER}/frame_poses', POSES)
        message = msg.FramePoses(frame_names=['arm::hand'])
        count = 0

        def leap() -> None:
            nonlocal count
            count += 1
            message.header.stamp.sec = count
            message.poses = [NEAR if count % 2 else FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
            listener.sent[count] = time.perf_counter()
            poses.publish(message)

        while not listener.numbers:  # until both know each other
            leap()
            executor.spin_once(timeout_sec=0.2)
        start, first = time.perf_counter(), len(listener.numbers)
        for k in range(round(rate * seconds)):
            due = start + k / rate
            takes = (k / rate) % 1.0 >= busy
            while (left := due - time.perf_counter()) > 0.0:
                if takes:
                    executor.spin_once(timeout_sec=left)
                else:
                    time.sleep(left)
            leap()
        took = time.perf_counter() - start
        end = time.perf_counter() + LAST
        while (left := end - time.perf_counter()) > 0.0:
            executor.spin_once(timeout_sec=left)
        executor.shutdown()
    rclpy.shutdown()
    told = np.array(listener.delays) * 1e3
    row = (told.mean(), *np.percentile(told, (50, 99)))
    changes = (listener.numbers[-1] - listener.numbers[first - 1]) / took
    return (
        f'{rules:6}{rate:6g}{busy:7g}{len(listener.numbers) - first:10}{changes:11.0f}'
        f'{listener.missing():9}' + ''.join(f'{value:9.2f}' for value in row)
    )


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--seconds', type=float, default=20.0, help='of each row')
    parser.add_argument('--depth', type=int, default=1000, help='of the queue of the listener')
    options = parser.parse_args()
    print(f'{"rules":>6}{"rate":>6}{"busy":>7}{"heard":>10}{"changes/s":>11}{"missing":>9}'
          f'{"mean":>9}{"p50":>9}{"p99":>9}   [Hz], [s] of a second, delays [ms]')  # fmt: skip
    for rules, rate in ARMS:
        for busy in BUSY:
            row = measure(rules, rate, busy, options.seconds, options.depth)
            print(row, flush=True)


if __name__ == '__main__':
    main()
