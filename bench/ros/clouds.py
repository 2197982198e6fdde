"""How late results are where clouds of points come beside poses, and what is lost.

The demo's two arms at 100 Hz, and clouds of 300 000 points at 10 Hz: taken, the arms' own points
left out, thinned, answered with the arms. In turns within one run: nobody sends clouds; they go
to an echo, which is their bare round trip and what sending them costs; they go to the node.

    ./run exec python -m bench.ros.clouds [--points 300000] [--seconds 10] [--queue 20]

``--queue`` sets how many pose messages may wait in the node, ``--lidars`` adds so many sources of
1080 rays at 25 Hz, as columns. Memory: ``bench.ros.cloud_soak``.
"""

from __future__ import annotations

import argparse
import array
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from typing import Any

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs.msg import SignedDistancePairs
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from bench.ros.meanwhile import beside, delays
from bench.ros.processes import Processes, children, processor
from bench.ros.routes import LAST_ANSWERS, Route
from bench.ros.scenes import two_arms

NODE = 'drake_geom_ros.ros.scene_graph_node'
RATE = 10.0  # [Hz] of clouds
RAYS, SCANS = 1080, 25  # of a lidar, and scans a second
LIDAR = 'lidar_{}'  # name of a source; its topic has the same name
MOUNT = 'left::panda_link0'  # frame of the lidars, which stands still
ECHO, TAKEN = 'clouds to an echo', 'clouds to the node'
RESOLUTION = 0.03  # [m]

Floats = NDArray[np.float64]


def room(count: int, seed: int = 0) -> Floats:
    """Return points (n, 3) [m] of a table, a wall, a full box, bars, and the feet of two arms."""
    random = np.random.default_rng(seed)
    uv = random.uniform(-1.5, 1.5, (count, 2))
    noise = random.normal(scale=0.003, size=count)
    which = random.integers(0, 10, count)
    points = np.stack([uv[:, 0], uv[:, 1], noise], axis=1)
    wall = which < 3
    points[wall] = np.stack([1.5 + noise, uv[:, 0], 1.0 + 0.6 * uv[:, 1]], axis=1)[wall]
    box = which == 3
    points[box] = random.uniform([0.6, -0.9, 0.0], [0.9, -0.6, 0.4], (count, 3))[box]
    bars = which == 4  # four upright ones, 4 cm thick, where the arms reach
    around, corner = random.uniform(0.0, 2.0 * np.pi, count), random.integers(0, 4, count)
    x = np.where(corner % 2, 0.45, -0.25) + 0.02 * np.cos(around)
    y = np.where(corner // 2, 0.45, -0.45) + 0.02 * np.sin(around)
    points[bars] = np.stack([x, y, random.uniform(0.0, 0.9, count)], axis=1)[bars]
    feet = which == 5  # which turn in place: these are on bodies, and left out
    x = np.where(corner % 2, 0.6, -0.6) + 0.07 * np.cos(around)
    on_feet = np.stack([x, 0.07 * np.sin(around), random.uniform(0.42, 0.7, count)], axis=1)
    points[feet] = on_feet[feet]
    return points


def cloud_of(points: Floats) -> PointCloud2:
    """Return points as a cloud in the world, as drivers lay it out: x y z and four bytes."""
    rows = np.zeros((len(points), 4), dtype='<f4')
    rows[:, :3] = points
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate('xyz')]
    return PointCloud2(
        header=Header(frame_id='world'),
        width=len(rows),
        height=1,
        fields=fields,
        point_step=16,
        row_step=16 * len(rows),
        data=array.array('B', rows.tobytes()),
    )


class Maps:
    """How late [s] results with a new map were, by the stamps [s] of its cloud."""

    def __init__(self, pid: int, lidars: int = 0) -> None:
        self.delays: dict[float, float] = {}
        self._lidars = lidars
        self._words = ''  # of the node about its cloud
        self._pid = pid  # of the node

    def route(self, node: Node, server: str) -> Route:
        """Return a route whose answers are looked at."""
        node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 10)
        return _MapRoute(self.delays, node, server)

    @contextmanager
    def sent(self, count: int) -> Iterator[None]:
        """Let clouds be sent to the node, and print what became of them."""
        with self._scans(), beside(send, TAKEN, count):
            self.delays.clear()
            begin, used = time.time(), self._processor()
            yield
            passed = time.time() - begin
            both = zip(used, self._processor(), strict=True)
            shares = [(now - then) / passed for then, now in both]
            end = time.time() - LAST_ANSWERS  # no pose comes then
        # Those that could be answered, for poses came; until the first one the last map stays.
        found = [delay for stamp, delay in self.delays.items() if begin <= stamp <= end]
        tell(TAKEN, found, int((end - begin) * RATE))
        node, *its = (f'{100.0 * share:.0f} %' for share in shares)
        print(f'    of a processor the node used {node}, and processes that it started {its}')
        print(f'    by its diagnostics, of all turns: {self._words}')

    def _hear(self, message: DiagnosticArray) -> None:
        values = (each for status in message.status for each in status.values)
        words = next((v.value for v in values if v.key == 'obstacles points'), self._words)
        self._words = words.partition(';')[0]

    def _scans(self) -> AbstractContextManager[None]:
        """Let scans be sent meanwhile, if there are lidars."""
        return beside(send_scans, self._lidars) if self._lidars else nullcontext()

    def _processor(self) -> list[float]:
        return [processor(pid) for pid in (self._pid, *children(self._pid))]


class _MapRoute(Route):
    """A route that looks at how old the map was in each answer: its pose is the oldest there."""

    def __init__(self, delays: dict[float, float], node: Node, server: str) -> None:
        super().__init__(node, server)
        self._delays = delays

    def look_at(self, message: SignedDistancePairs) -> None:
        """Note the first answer with a map; stamps of clouds are multiples of a period."""
        now = time.time()
        if np.isfinite(message.oldest_pose_age):
            stamp = np.floor((now - message.oldest_pose_age) * RATE) / RATE
            self._delays.setdefault(stamp, now - stamp)


def send(way: str, count: int, ready: Any, ending: Any) -> None:
    """Send clouds until it shall end; of the echo's answers print how late they are."""
    rclpy.init()
    node = rclpy.create_node('camera')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    topic = '/echo/clouds' if way == ECHO else '/scene_graph/obstacles/points'
    publisher = node.create_publisher(PointCloud2, topic, newest)
    cloud = cloud_of(room(count))
    found: list[float] = []

    def heard(header: Header) -> None:
        found.append(time.time() - header.stamp.sec - 1e-9 * header.stamp.nanosec)

    if way == ECHO:
        node.create_subscription(Header, '/echo/heard', heard, 10)
    while not publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    number, due, used = 0, int(time.time() * RATE) + 2, time.process_time()
    while not ending.is_set():
        while (left := due / RATE - time.time()) > 0.0:
            executor.spin_once(timeout_sec=left)
        # A hair later, lest rounding make it one of the period before.
        cloud.header.stamp = Time(sec=due // int(RATE), nanosec=due % int(RATE) * 10**8 + 1000)
        publisher.publish(cloud)
        number, due = number + 1, due + 1
        ready.set()
    if way == ECHO:
        tell(way, found, number)
    print(f'    {1e3 * (time.process_time() - used) / number:.1f} ms of the processor to send one')
    node.destroy_node()
    rclpy.shutdown()


def send_scans(lidars: int, ready: Any, ending: Any) -> None:
    """Send scans of a round room until it shall end; print how many of each lidar."""
    rclpy.init()
    node = rclpy.create_node('lidars')
    newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    publishers = [
        node.create_publisher(LaserScan, f'/{LIDAR.format(k)}', newest) for k in range(lidars)
    ]
    step = 1.5 * np.pi / RAYS
    ranges = np.random.default_rng(0).normal(2.0, 0.005, RAYS).astype(np.float32)
    scan = LaserScan(
        header=Header(frame_id=MOUNT),
        angle_min=-0.75 * np.pi,
        angle_increment=step,
        range_min=0.05,
        range_max=10.0,
        ranges=array.array('f', ranges.tobytes()),
    )
    number, start = 0, time.time()
    while not ending.is_set():
        time.sleep(max(0.0, start + number / SCANS - time.time()))
        scan.header.stamp = node.get_clock().now().to_msg()
        for publisher in publishers:
            publisher.publish(scan)
        number += 1
        ready.set()
    print(f'  scans to the node: {number} of each of {lidars} lidars', flush=True)
    node.destroy_node()
    rclpy.shutdown()


def tell(way: str, found: list[float], number: int) -> None:
    """Print how late [s] answers were, and of how many clouds there was none."""
    if not found:
        print(f'  {way}: no cloud of {number} was answered', flush=True)
        return
    told = (np.mean(found), *np.percentile(found, (50, 99)))
    print(
        f'  {way}: delay from cloud to result [ms], mean, p50, p99: '
        + ''.join(f'{1e3 * value:9.1f}' for value in told)
        + f'{len(found):6} of {number}',
        flush=True,
    )


def parameters(lidars: int = 0) -> dict[str, object]:
    """Return the parameters of the node that takes the clouds, and the scans of lidars."""
    values: dict[str, object] = {
        'max_distance': 0.1,
        'obstacles': '[points]',
        'obstacle_resolution': RESOLUTION,
        'obstacle_self_filter': 'robots',
    }
    if lidars:
        names = [LIDAR.format(k) for k in range(lidars)]
        keys = 'type: laser_scan, topic: /{}, extrude: [0.0, 1.8]'
        each = ', '.join(f'{name}: {{{keys.format(name)}}}' for name in names)
        values['obstacle_sources'] = f"'{{{each}}}'"
    return values


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--points', type=int, default=300_000)
    parser.add_argument('--seconds', type=float, default=10.0, help='of poses, in a turn')
    parser.add_argument('--queue', type=int, help='pose messages that may wait in the node')
    parser.add_argument('--lidars', type=int, default=0, help='laser scans beside the clouds')
    options = parser.parse_args()
    played, given = two_arms(), parameters(options.lidars)
    if options.queue:
        given['qos_overrides./scene_graph/frame_poses.subscription.depth'] = options.queue
    with Processes() as processes:
        node = processes.start(NODE, scene_file=played.scene_file, **given)
        processes.start('bench.ros.cloud_echo')
        maps = Maps(node.pid, options.lidars)
        ways = {
            ECHO: partial(beside, send, ECHO, options.points),
            TAKEN: partial(maps.sent, options.points),
        }
        delays(played, ways, options.seconds, maps.route)


if __name__ == '__main__':
    main()
