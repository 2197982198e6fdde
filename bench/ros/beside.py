"""What a node's cycles feel of what is done beside them: three cameras at 30 Hz, or a viewer.

The demo's two arms are posed at 100 Hz, in turns with and without subscribers of the images (or
the viewer's process), which changes nothing else: without subscribers nothing is rendered. Told
are the delay from pose to result, the cycle in the node's own words, poses without an answer, how
many images came a second, of those that were due, and how old they were: since the pose they show
was sent. While nothing moves no image is due, for it would show what the last one showed.

    ./run exec python -m bench.ros.beside [cameras | viewer] [--seconds 20] [--size 640 480]
        [--images color] [--rate 30]
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
import rclpy
from drake_geom_msgs.msg import Camera
from drake_geom_msgs.srv import AddCamera
from geometry_msgs.msg import Point, Pose, Quaternion
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bench.ros.processes import Processes, processor
from bench.ros.routes import WARM_UP, Reports, Route, stream
from bench.ros.scenes import Played, two_arms

NODE = 'drake_geom_ros.ros.scene_graph_node'
VIEWER = 'drake_geom_ros.ros.viewer.scene_viewer'
LISTENER = 'bench.ros.image_listener'
SERVER = 'scene_graph'
POSE_RATE = 100.0  # [Hz]
TURNS = 2  # with and without, back and forth
SETTLING = 5.0  # [s] until who was started listens
# Where three cameras are: frame, position [m] and orientation in it.
PLACES = (
    ('left::panda_hand', (0.09, 0.0, 0.04), (0.0, 0.0, 0.0, 1.0)),
    ('right::panda_hand', (0.09, 0.0, 0.04), (0.0, 0.0, 0.0, 1.0)),
    ('world', (0.0, 0.0, 2.5), (1.0, 0.0, 0.0, 0.0)),  # looks down
)
TOPICS = {'color': 'color/image_raw', 'depth': 'depth/image_rect_raw', 'label': 'labels/image_raw'}


class Came(NamedTuple):
    """An image that came."""

    time: float  # [s] of the steady clock
    topic: int
    stamp: int  # [ns] of the message with the pose that it shows


class Turn(NamedTuple):
    """What a turn of the stream told: seconds, counts, and processor time of the node [s]."""

    delays: list[float]
    cycles: list[float]
    lost: int
    ages: list[float]  # of images, each counted once
    used: float


def add_cameras(node: Node, size: tuple[int, int], rate: float, images: list[str]) -> None:
    """Add three cameras to the node's scene."""
    client = node.create_client(AddCamera, f'/{SERVER}/add_camera')
    client.wait_for_service()
    for number, (frame, p, q) in enumerate(PLACES):
        pose = Pose(
            position=Point(x=p[0], y=p[1], z=p[2]),
            orientation=Quaternion(x=q[0], y=q[1], z=q[2], w=q[3]),
        )
        camera = Camera(name=f'camera_{number}', frame=frame, pose=pose, fov_y=1.0, rate=rate)
        camera.width, camera.height, camera.images = *size, images
        camera.shows = 'proximity'
        future = client.call_async(AddCamera.Request(camera=camera))
        rclpy.spin_until_future_complete(node, future)
        if not future.result().success:
            raise RuntimeError(future.result().message)


class Measurement:
    """One node that is streamed to, with and without what is beside."""

    def __init__(self, node: Node, played: Played, pid: int) -> None:
        self._node, self._played, self._pid = node, played, pid
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._route, self._reports = Route(node, SERVER), Reports(node, SERVER)
        while not self._route.publisher.get_subscription_count():
            self._executor.spin_once(timeout_sec=0.1)

    def turn(self, seconds: float, close: Callable[[], list[Came]]) -> Turn:
        """Stream; ``close()`` ends what is beside and returns the images that came."""
        route, reports = self._route, self._reports
        delays, lost = route.result()
        cycles, before = len(reports.cycles), processor(self._pid)
        first = max(route.sent, default=0) + WARM_UP
        stream(self._executor, route, self._played, POSE_RATE, seconds)
        spent = processor(self._pid) - before
        # One that is sent again, for who comes late, is no other image.
        came: dict[tuple[int, int], float] = {}
        for image in close():
            number = route.numbers.get(image.stamp, -1)
            if number > first:
                came.setdefault((image.topic, number), image.time)
        # The steady clock is that of time.perf_counter on Linux.
        ages = [when - route.sent[number] for (_, number), when in came.items()]
        all_delays, all_lost = route.result()
        return Turn(
            all_delays[len(delays) :], reports.cycles[cycles:], all_lost - lost, ages, spent
        )


def moving(played: Played, rate: float, seconds: float) -> float:
    """Return in which share of the periods of a camera something moves."""
    times = (WARM_UP + np.arange(round(POSE_RATE * seconds))) / POSE_RATE
    all_poses = [played.poses(time) for time in times]
    moves = np.array([not np.array_equal(*two) for two in pairwise(all_poses)])
    periods = (times[1:] * rate).astype(int)
    return len(set(periods[moves])) / len(set(periods))


def start(processes: Processes, options: argparse.Namespace) -> Callable[[], list[Came]]:
    """Start what is beside; return what ends it, and tells the images that came."""
    if options.what == 'viewer':
        process = processes.start(VIEWER, port=18099)
    else:
        topics = product(range(len(PLACES)), options.images)
        names = [f'/{SERVER}/cameras/camera_{k}/{TOPICS[kind]}' for k, kind in topics]
        process = processes.start(LISTENER, *names)
    time.sleep(SETTLING)

    def close() -> list[Came]:
        process.terminate()
        lines = process.stdout.read().splitlines()
        processes.forget(process)
        return [] if options.what == 'viewer' else [Came(*each) for each in json.loads(lines[-1])]

    return close


def row(name: str, turns: list[Turn], due: float, seconds: float) -> str:
    """Return a line of the table, of turns that took so long together."""
    cells = []
    ages = [age for turn in turns for age in turn.ages]
    delays = [delay for turn in turns for delay in turn.delays]
    for values in (delays, [cycle for turn in turns for cycle in turn.cycles], ages or [0.0]):
        cells += [f'{1e3 * q:9.2f}' for q in np.percentile(values, (50, 99))]
    return (
        f'{name:>9}{"".join(cells)}{sum(t.lost for t in turns):6}{len(ages) / seconds:9.1f}'
        f'{due:7.1f}{sum(t.used for t in turns):8.1f}'
    )


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.ros.beside', description=__doc__.split('\n')[0]
    )
    parser.add_argument('what', nargs='?', choices=('cameras', 'viewer'), default='cameras')
    parser.add_argument('--seconds', type=float, default=20.0, help='with, and as long without')
    parser.add_argument('--size', type=int, nargs=2, default=(640, 480))
    parser.add_argument('--rate', type=float, default=30.0, help='of each camera [Hz]')
    parser.add_argument('--images', nargs='+', choices=tuple(TOPICS), default=['color'])
    options = parser.parse_args()
    played = two_arms()
    turns: dict[str, list[Turn]] = {'without': [], 'with': []}
    with Processes() as processes:
        server = processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        rclpy.init()
        node = rclpy.create_node('driver')
        if options.what == 'cameras':
            add_cameras(node, options.size, options.rate, options.images)
        measurement = Measurement(node, played, server.pid)
        for _ in range(TURNS):
            for name, its in turns.items():
                close = start(processes, options) if name == 'with' else list
                its.append(measurement.turn(options.seconds / TURNS, close))
        rclpy.shutdown()
    share = moving(played, options.rate, options.seconds / TURNS)
    due = share * len(PLACES) * len(options.images) * options.rate
    titles = (
        'delay p50      p99 cycle p50      p99   age p50      p99  lost images/s  due/s    used'
    )
    print(f'{"":10}{titles}   (times in ms; used: processor time of the node [s])')
    for name, its in turns.items():
        seen = (name, options.what) == ('with', 'cameras')
        print(row(name, its, due if seen else 0.0, options.seconds))


if __name__ == '__main__':
    main()
