"""What tracked bodies add to a node with two arms: processor time, by turns with and without them.

    ./run exec python -m bench.ros.tracked [--bodies 50] [--body-rate 30] [--seconds 20]

Poses of the arms are sent at 100 Hz all the time, the bodies of a tracker in every other turn. No
body is near an arm, so distances cost the same. A turn is measured when the bodies are there, or
have left. The first row counts within this process: reading and taking a message of bodies, over
reading and taking a message of poses with its cycle's distances, medians. The second is the ratio
of the node's processor time, with bodies over without.
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from drake_geom_msgs.msg import FramePoses, Shape, TrackedObjects
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message

from bench.ros.processes import Processes, processor
from bench.ros.routes import Route, stream
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.live.conversions.tracked_objects import TrackedObjectsReader
from drake_geom_ros.live.inputs.tracked_input import TrackedInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.message_reading import pose_reader, tracked_objects_reader
from drake_geom_ros.scene_files import read_scene

NODE = 'drake_geom_ros.ros.scene_graph_node'
RATE, TURNS, REACH = 100.0, 4, 0.1
LIFETIME, SETTLED = 1.0, 2.0  # [s]
_REPEATS = 300


def crowd(count: int, seconds: float) -> TrackedObjects:
    """Return people who walk far away, at a time [s]."""
    person = Shape(type=Shape.CAPSULE, dimensions=[0.3, 1.2])
    message = TrackedObjects(
        names=[f'person {k}' for k in range(count)],
        shapes=[person] * count,
        lifetimes=[LIFETIME] * count,
    )
    for k in range(count):
        message.poses.extend([50.0 + k + np.sin(seconds + k), 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    now = time.time_ns()
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    return message


class Tracker:
    """Sends bodies from a thread of its own while it is on."""

    def __init__(self, node: Node, count: int, rate: float) -> None:
        self._publisher = node.create_publisher(TrackedObjects, '/scene_graph/tracked_objects', 5)
        self._count, self._rate = count, rate
        self._off = threading.Event()

    @contextmanager
    def sending(self) -> Iterator[None]:
        """Send bodies meanwhile."""
        self._off.clear()
        thread = threading.Thread(target=self._send)
        thread.start()
        yield
        self._off.set()
        thread.join()

    def _send(self) -> None:
        while not self._off.wait(1.0 / self._rate):
            self._publisher.publish(crowd(self._count, time.monotonic()))


def of_node(played: Played, options: argparse.Namespace) -> float:
    """Return the ratio of processor times of a node with and without bodies."""
    rclpy.init()
    driver, executor = rclpy.create_node('driver'), SingleThreadedExecutor()
    executor.add_node(driver)
    with Processes() as processes:
        node = processes.start(NODE, scene_file=played.scene_file, max_distance=REACH)
        route = Route(driver, 'scene_graph')
        tracker = Tracker(driver, options.bodies, options.rate)
        while not route.publisher.get_subscription_count():
            executor.spin_once(timeout_sec=0.1)
        used = {False: 0.0, True: 0.0}

        def play(seconds: float) -> None:
            stream(executor, route, played, RATE, seconds)

        for turn in range(2 * TURNS):
            with tracker.sending() if turn % 2 else nullcontext():
                play(SETTLED)
                before = processor(node.pid)
                play(options.seconds / TURNS / 2)
                used[bool(turn % 2)] += processor(node.pid) - before
    rclpy.shutdown()
    return used[True] / used[False]


def of_messages(played: Played, count: int) -> float:
    """Return what a message of bodies takes, over one of poses with its distances."""
    live = LiveScene('exact', Clocks(time.time))
    with live.editing() as scene:
        scene.make(addition(read_scene(Path(played.scene_file))))
    bodies, reader = TrackedInput(live, lambda *_: ''), TrackedObjectsReader()
    of_bodies, of_poses = tracked_objects_reader(TrackedObjects), pose_reader(FramePoses)
    poses = FramePoses(frame_names=played.frame_names)

    def take_bodies(k: int) -> float:
        raw = serialize_message(crowd(count, k / 30.0))
        start = time.perf_counter()
        bodies.take(reader.read(of_bodies.read(raw, 'a'), live.files), 0.0, 'a')
        return time.perf_counter() - start

    def cycle(k: int) -> float:
        poses.poses = np.asarray(played.poses(k / RATE), dtype=np.float64).ravel().tolist()
        raw = serialize_message(poses)
        start = time.perf_counter()
        with live.editing() as scene:
            scene.poses.take(of_poses.read(raw, 'b'), 0.0, 'b')
            scene.query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        return time.perf_counter() - start

    times = np.array([[take_bodies(k), cycle(k)] for k in range(_REPEATS)])[_REPEATS // 3 :]
    first, second = np.median(times, axis=0)
    return float(first / second)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--bodies', type=int, default=50)
    parser.add_argument('--body-rate', dest='rate', type=float, default=30.0, help='[Hz]')
    parser.add_argument('--seconds', type=float, default=20.0, help='of streaming, each way')
    options = parser.parse_args()
    played = two_arms()
    ratio = of_messages(played, options.bodies)
    print(f'a message of {options.bodies} bodies / a message of poses with distances: {ratio:.2f}')
    print(f'processor time of the node, with bodies / without: {of_node(played, options):.2f}')


if __name__ == '__main__':
    main()
