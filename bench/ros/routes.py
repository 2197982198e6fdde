"""There and back: pose messages out on a schedule, results in, each with its delay."""

from __future__ import annotations

import array
import time

import numpy as np
from builtin_interfaces.msg import Time
from drake_geom_msgs.msg import CycleReport, FramePoses, SignedDistancePairs
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from bench.ros.scenes import Played

POSES = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LAST_ANSWERS = 1.0  # [s] what has not come then after the last message is lost
WARM_UP = 50  # messages


class Route:
    """A server of results: a publisher to it, and when each answer came.

    Messages bear the time at which they are sent: what others send beside them has stamps of now,
    too, and a result bears the newest one.
    """

    def __init__(self, node: Node, server: str) -> None:
        self.server = server
        self.publisher = node.create_publisher(FramePoses, f'/{server}/frame_poses', POSES)
        self.listen(node)
        self.latest = SignedDistancePairs()
        self.numbers: dict[int, int] = {}  # by the stamp [ns]
        self.sent: dict[int, float] = {}  # by number
        self.delays: dict[int, float] = {}

    def listen(self, node: Node) -> None:
        """Listen to its answers."""
        topic = f'/{self.server}/signed_distances'
        # An answer that came is not lost because its reader is late.
        node.create_subscription(SignedDistancePairs, topic, self._receive, QoSProfile(depth=100))

    def _receive(self, message: SignedDistancePairs) -> None:
        self.look_at(message)
        number = self.number_of(message.header.stamp)
        if number in self.sent and number not in self.delays:
            self.delays[number] = time.perf_counter() - self.sent[number]
            self.latest = message

    def look_at(self, message: SignedDistancePairs) -> None:
        """Look at an answer that came, whichever it is of."""

    def number_of(self, stamp: Time) -> int:
        """Return the number of the message that was sent at a time; -1: none was."""
        return self.numbers.get(10**9 * stamp.sec + stamp.nanosec, -1)

    def send(self, message: FramePoses, number: int) -> None:
        """Send a message; its answer is known by its stamp."""
        now = time.time_ns()
        message.header.stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
        self.numbers[now], self.sent[number] = number, time.perf_counter()
        self.publisher.publish(message)

    def result(self) -> tuple[list[float], int]:
        """Return the delays [s] after warming up, and how many answers were lost."""
        counted = [n for n in self.sent if n > WARM_UP]
        delays = [self.delays[n] for n in counted if n in self.delays]
        return delays, len(counted) - len(delays)


class Reports:
    """Keeps the seconds of each effect of every cycle."""

    def __init__(self, node: Node, server: str) -> None:
        self.cycles: list[float] = []
        self.effects: dict[str, list[float]] = {}
        self.pairs: list[int] = []
        node.create_subscription(CycleReport, f'/{server}/cycle_report', self._take, 10)

    def _take(self, report: CycleReport) -> None:
        self.cycles.append(report.seconds)
        self.pairs.append(sum(report.method_pairs))
        for name, seconds in zip(report.effects, report.effect_seconds, strict=True):
            self.effects.setdefault(name, []).append(seconds)


def rows_of(played: Played, rate: float, seconds: float) -> list[bytes]:
    """Return the poses of all messages of a stream: to compute them takes a third of its time."""
    times = (k / rate for k in range(WARM_UP + round(rate * seconds)))
    return [np.ascontiguousarray(played.poses(time)).tobytes() for time in times]


def stream(
    executor: SingleThreadedExecutor,
    route: Route,
    played: Played,
    rate: float,
    seconds: float,
    rows: list[bytes] | None = None,
) -> None:
    """Send the motion at a rate, without waiting for answers, and then wait for the last ones.

    ``rows`` are those of ``rows_of``, by who wants them computed before.
    """
    send_all(
        executor, route, played, rate, rows_of(played, rate, seconds) if rows is None else rows
    )
    hear_last(executor)


def send_all(
    executor: SingleThreadedExecutor, route: Route, played: Played, rate: float, rows: list[bytes]
) -> None:
    """Send poses at a rate, without waiting for answers; hear those that come meanwhile."""
    message = FramePoses(frame_names=played.frame_names)
    first = max(route.delays, default=0) + 1
    start = time.perf_counter()
    for k, poses in enumerate(rows):
        message.poses = array.array('d', poses)
        while (left := start + k / rate - time.perf_counter()) > 0.0:
            executor.spin_once(timeout_sec=left)
        route.send(message, first + k)
        executor.spin_once(timeout_sec=0.0)  # who is late with sending hears all the same


def hear_last(executor: SingleThreadedExecutor) -> None:
    """Wait for the last answers."""
    end = time.perf_counter() + LAST_ANSWERS
    while (left := end - time.perf_counter()) > 0.0:
        executor.spin_once(timeout_sec=left)
