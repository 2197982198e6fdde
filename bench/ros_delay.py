"""End-to-end delay from a pose message to its result, as a ratio to a bare rclpy round trip.

Three processes: the node with a scene, an echo node that answers each FramePoses message with a
SignedDistancePairs message of the size that the node last sent, and this one, which plays the
scene's motion, sends every pose message to both in turn and measures until the answer with its
stamp is back. Both are measured in one run, interleaved, so their ratio means something on a noisy
machine; a bare time does not.

    ./run exec python bench/ros_delay.py [--rate 100] [--seconds 20]
"""

from __future__ import annotations

import argparse
import array
import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import rclpy
from drake_geom_msgs.msg import FramePoses, SignedDistancePairs
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion

ROOT = Path(__file__).resolve().parents[1]
POSES = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
RESULTS = QoSProfile(depth=10)
ANSWER_TIME = 0.5  # [s] an answer that has not come by then is lost


def echo() -> None:
    """Answer each pose message with the template that the driver sent last."""
    rclpy.init()
    node = rclpy.create_node('echo')
    template = SignedDistancePairs()

    def keep(message: SignedDistancePairs) -> None:
        nonlocal template
        template = message

    def answer(message: FramePoses) -> None:
        template.header.stamp = message.header.stamp
        publisher.publish(template)

    publisher = node.create_publisher(SignedDistancePairs, '/echo/signed_distances', RESULTS)
    node.create_subscription(SignedDistancePairs, '/echo/template', keep, RESULTS)
    node.create_subscription(FramePoses, '/echo/frame_poses', answer, POSES)
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


class Route:
    """One way there and back: its publisher, and when each answer came."""

    def __init__(self, node: rclpy.node.Node, name: str) -> None:
        self.name = name
        self.publisher = node.create_publisher(FramePoses, f'/{name}/frame_poses', POSES)
        node.create_subscription(
            SignedDistancePairs, f'/{name}/signed_distances', self._receive, RESULTS
        )
        self.delays: list[float] = []
        self.lost = 0
        self.latest = SignedDistancePairs()
        self._waiting = (-1, 0.0)

    def _receive(self, message: SignedDistancePairs) -> None:
        if message.header.stamp.sec == self._waiting[0]:
            self.delays.append(time.perf_counter() - self._waiting[1])
            self._waiting = (-1, 0.0)
            self.latest = message

    def ask(self, executor: SingleThreadedExecutor, message: FramePoses, number: int) -> None:
        """Send a message and wait for its answer."""
        message.header.stamp.sec = number
        self._waiting = (number, time.perf_counter())
        self.publisher.publish(message)
        end = time.perf_counter() + ANSWER_TIME
        while self._waiting[0] >= 0:
            if time.perf_counter() > end:
                self.lost += 1
                self._waiting = (-1, 0.0)
                return
            executor.spin_once(timeout_sec=ANSWER_TIME)


def measure(arguments: argparse.Namespace) -> tuple[Route, Route, int]:
    """Play the motion to both routes in turn; return the routes and the pairs of an answer."""
    motion = load_motion(arguments.motion, read_scene(arguments.scene))
    message = FramePoses()
    message.frame_names = [f'{s}::{n}' for s, names in motion.frame_names.items() for n in names]
    rclpy.init()
    node = rclpy.create_node('ros_delay')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    template = node.create_publisher(SignedDistancePairs, '/echo/template', RESULTS)
    ours, bare = Route(node, 'scene_graph'), Route(node, 'echo')
    while not all(p.get_subscription_count() for p in (ours.publisher, bare.publisher, template)):
        executor.spin_once(timeout_sec=0.1)
    pairs = 0
    start = time.perf_counter()
    ticks = int(arguments.seconds * arguments.rate)
    for number in range(1, ticks + 1):
        poses = motion.poses((number / arguments.rate) % motion.duration)
        flat = np.concatenate([poses[source].ravel() for source in motion.frame_names])
        message.poses = array.array('d', flat.tobytes())
        for route in (ours, bare) if number % 2 else (bare, ours):
            route.ask(executor, message, number)
        template.publish(ours.latest)
        pairs += len(ours.latest.id_a)
        while (left := start + number / arguments.rate - time.perf_counter()) > 0:
            executor.spin_once(timeout_sec=left)
    node.destroy_node()
    rclpy.shutdown()
    return ours, bare, pairs // ticks


def main() -> None:
    """Start the two others, measure, print, end them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--scene', default=str(ROOT / 'scenes/two_pandas.yaml'))
    parser.add_argument('--motion', default=str(ROOT / 'scenes/two_pandas_motion.yaml'))
    parser.add_argument('--rate', type=float, default=100.0, help='[Hz]')
    parser.add_argument('--seconds', type=float, default=20.0, help='[s]')
    parser.add_argument('--max-distance', type=float, default=0.1, help='[m]')
    parser.add_argument('--echo', action='store_true', help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.echo:
        echo()
        return
    node = [sys.executable, '-m', 'drake_geom_ros.ros.scene_graph_node', '--ros-args']
    node += ['-p', f'scene_file:={arguments.scene}']
    node += ['-p', f'max_distance:={arguments.max_distance}']
    environment = {**os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    others = [
        subprocess.Popen(command, env=environment)
        for command in (node, [sys.executable, __file__, '--echo'])
    ]
    try:
        ours, bare, pairs = measure(arguments)
    finally:
        for process in others:
            process.terminate()
            process.wait(10.0)
    print(f'{arguments.rate:g} Hz, {len(ours.delays)} pose messages, {pairs} pairs an answer')
    print(f'{"":12}{"p50 [ms]":>10}{"p99 [ms]":>10}{"lost":>6}')
    for route in (ours, bare):
        p50, p99 = np.percentile(route.delays, (50, 99)) * 1e3
        print(f'{route.name:12}{p50:10.3f}{p99:10.3f}{route.lost:6}')
    ratios = np.percentile(ours.delays, (50, 99)) / np.percentile(bare.delays, (50, 99))
    print(f'{"ratio":12}{ratios[0]:10.2f}{ratios[1]:10.2f}')


if __name__ == '__main__':
    main()
