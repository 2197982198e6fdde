"""What tracked bodies add to a node with two arms, and how much of that is for pairs of theirs.

    ./run exec python -m bench.ros.tracked [--bodies 50] [--body-rate 30] [--seconds 20]
        [--crowds clear floor mingling]

The arms stand on a floor, and their poses are sent at 100 Hz. Bodies walk up to 1 m/s far away:

- ``clear``: above the floor, 3 m from each other, so no pair of theirs is in an answer;
- ``floor``: on the floor, so each answer has one pair for each of them;
- ``mingling``: on the floor, 1 m from each other, so they meet, and more pairs are answered.

First within this process, medians: a message of bodies, read and taken, and a cycle (a message of
poses, read and taken, with its distances) with bodies over one without, in turns. Then the node's
processor time with bodies over without, in turns, when the bodies are there or have left.
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from drake_geom_msgs.msg import FramePoses, Shape, TrackedObjects
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message

from bench.ros.processes import Processes, processor
from bench.ros.routes import Route, hear_last, rows_of, send_all
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.live.conversions.tracked_objects import TrackedObjectsReader
from drake_geom_ros.live.inputs.tracked_input import TrackedInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.message_reading import pose_reader, tracked_objects_reader
from drake_geom_ros.scene_files import read_scene

NODE = 'drake_geom_ros.ros.scene_graph_node'
RATE, TURNS, REACH = 100.0, 3, 0.1
LIFETIME, SETTLED = 1.0, 2.0  # [s]
CROWDS = {'clear': (3.0, 3.0), 'floor': (3.0, 0.9), 'mingling': (1.0, 0.9)}  # spacing, height [m]
_CYCLES, _WARM_UP = 900, 300


def crowd(kind: str, count: int, seconds: float) -> TrackedObjects:
    """Return people who walk far away, at a time [s]."""
    spacing, z = CROWDS[kind]
    person = Shape(type=Shape.CAPSULE, dimensions=[0.3, 1.2])
    message = TrackedObjects(
        names=[f'person {k}' for k in range(count)],
        shapes=[person] * count,
        lifetimes=[LIFETIME] * count,
    )
    for k in range(count):
        message.poses.extend(
            [50.0 + spacing * k + np.sin(seconds + k), 0.0, z, 0.0, 0.0, 0.0, 1.0]
        )
    now = time.time_ns()
    message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    return message


class Tracker:
    """Sends bodies from threads of its own."""

    def __init__(self, node: Node, count: int, rate: float) -> None:
        self._publisher = node.create_publisher(TrackedObjects, '/scene_graph/tracked_objects', 5)
        self._count, self._rate = count, rate
        self._off = threading.Event()

    @contextmanager
    def sending(self, kind: str) -> Iterator[None]:
        """Send a crowd meanwhile."""
        self._off.clear()
        thread = threading.Thread(target=self._send, args=(kind,))
        thread.start()
        yield
        self._off.set()
        thread.join()

    def _send(self, kind: str) -> None:
        while not self._off.wait(1.0 / self._rate):
            self._publisher.publish(crowd(kind, self._count, time.monotonic()))


def of_node(played: Played, options: argparse.Namespace) -> None:
    """Print the node's processor time with each crowd, over that without bodies."""
    rclpy.init()
    driver, executor = rclpy.create_node('driver'), SingleThreadedExecutor()
    executor.add_node(driver)
    with Processes() as processes:
        node = processes.start(NODE, scene_file=played.scene_file, max_distance=REACH)
        route = Route(driver, 'scene_graph')
        tracker = Tracker(driver, options.bodies, options.rate)
        while not route.publisher.get_subscription_count():
            executor.spin_once(timeout_sec=0.1)
        ways = {None: nullcontext} | {
            each: partial(tracker.sending, each) for each in options.crowds
        }
        used, pairs = dict.fromkeys(ways, 0.0), dict.fromkeys(ways, 0)
        played_for = 0.0  # [s] each way

        settling, rows = (
            rows_of(played, RATE, each) for each in (SETTLED, options.seconds / TURNS)
        )
        for kind in [*ways] * TURNS:
            with ways[kind]():
                send_all(executor, route, played, RATE, settling)
                before, start = processor(node.pid), time.perf_counter()
                send_all(executor, route, played, RATE, rows)
                used[kind] += processor(node.pid) - before
                played_for += (time.perf_counter() - start) / len(ways)
                hear_last(executor)
                pairs[kind] = len(route.latest.id_a)
    rclpy.shutdown()
    print(f'the node without bodies uses {used[None] / played_for:.1%} of a processor, and')
    for kind in options.crowds:
        print(
            f'  {kind:10} {used[kind] / used[None]:5.2f} times that, '
            f'{1e3 * (used[kind] - used[None]) / played_for / options.rate:.2f} ms more for each '
            f'message of bodies; {pairs[kind]} pairs in the last answer, {pairs[None]} without'
        )


class Scene:
    """The arms in this process, with a tracker or without."""

    def __init__(self, played: Played) -> None:
        self._live = LiveScene('exact', Clocks(time.time))
        with self._live.editing() as scene:
            scene.make(addition(read_scene(Path(played.scene_file))))
        self._bodies, self._reader = (
            TrackedInput(self._live, lambda *_: ''),
            TrackedObjectsReader(),
        )
        self._of_bodies, self._of_poses = (
            tracked_objects_reader(TrackedObjects),
            pose_reader(FramePoses),
        )

    def take(self, raw: bytes) -> float:
        """Return what it takes [s] to read and take a message of bodies."""
        start = time.perf_counter()
        bodies = self._reader.read(self._of_bodies.read(raw, 'a'), self._live.files)
        self._bodies.take(bodies, 0.0, 'a')
        return time.perf_counter() - start

    def cycle(self, raw: bytes) -> float:
        """Return what it takes [s] to read and take poses and to ask for distances."""
        start = time.perf_counter()
        with self._live.editing() as scene:
            scene.poses.take(self._of_poses.read(raw, 'b'), 0.0, 'b')
            scene.query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        return time.perf_counter() - start


def of_messages(played: Played, options: argparse.Namespace) -> None:
    """Print what a message of bodies takes, and what they add to a cycle."""
    messages = []
    for k in range(_CYCLES):
        values = np.asarray(played.poses(k / RATE), dtype=np.float64).ravel().tolist()
        messages.append(
            serialize_message(FramePoses(frame_names=played.frame_names, poses=values))
        )
    every = round(RATE / options.rate)
    for kind in options.crowds:
        alone, crowded = Scene(played), Scene(played)
        taken, cycles = [], []
        for k, raw in enumerate(messages):
            if k % every == 0:
                taken.append(
                    crowded.take(serialize_message(crowd(kind, options.bodies, k / RATE)))
                )
            cycles.append((alone.cycle(raw), crowded.cycle(raw)))
        message = float(np.median(taken[_WARM_UP // every :]))
        without, with_them = np.median(cycles[_WARM_UP:], axis=0)
        print(
            f'  {kind:10} a message {message / without:5.2f} of a cycle without bodies '
            f'({1e6 * message:.0f} of {1e6 * without:.0f} us); '
            f'a cycle with bodies / without {with_them / without:5.2f}',
            flush=True,
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--bodies', type=int, default=50)
    parser.add_argument('--body-rate', dest='rate', type=float, default=30.0, help='[Hz]')
    parser.add_argument('--seconds', type=float, default=12.0, help='of streaming, each way')
    parser.add_argument('--crowds', nargs='+', choices=CROWDS, default=list(CROWDS))
    options = parser.parse_args()
    played = two_arms()
    of_messages(played, options)
    of_node(played, options)


if __name__ == '__main__':
    main()
