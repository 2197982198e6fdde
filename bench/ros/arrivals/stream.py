"""A process that poses a hand 100 times a second, and notes when results arrive."""

from __future__ import annotations

import multiprocessing
import time
from typing import Any

import numpy as np
import rclpy
from drake_geom_msgs.msg import FramePoses, SignedDistancePairs
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile

from bench.ros.routes import POSES

RATE = 100.0  # [Hz]
HAND = 'mover::hand'
_SWAY = 0.01  # [m] of the hand with each pose


class Stream:
    """Poses the hand from a process of its own, which nothing that is sent holds up."""

    def __init__(self) -> None:
        spawn = multiprocessing.get_context('spawn')
        self._here, there = spawn.Pipe()
        self._ending = spawn.Event()
        self._process = spawn.Process(target=_run, args=(there, self._ending))
        self._process.start()

    def __enter__(self) -> Stream:
        self._here.recv()  # the first result came
        return self

    def __exit__(self, *exception: object) -> None:
        self._ending.set()
        self._process.join()

    def arrivals(self) -> NDArray[np.float64]:
        """Return when [s] of the monotonic clock results arrived since the last call."""
        self._here.send(None)
        arrivals: NDArray[np.float64] = self._here.recv()
        return arrivals


def _run(there: Any, ending: Any) -> None:
    rclpy.init()
    node, executor = rclpy.create_node('stream'), SingleThreadedExecutor()
    executor.add_node(node)
    arrivals: list[float] = []

    def hear(message: SignedDistancePairs) -> None:
        arrivals.append(time.monotonic())

    node.create_subscription(
        SignedDistancePairs, '/scene_graph/signed_distances', hear, QoSProfile(depth=100)
    )
    publisher = node.create_publisher(FramePoses, '/scene_graph/frame_poses', POSES)
    message, count, is_ready = FramePoses(frame_names=[HAND]), 0, False
    due = time.monotonic()
    while not ending.is_set():
        count += 1
        due = max(due + 1.0 / RATE, time.monotonic())
        while (left := due - time.monotonic()) > 0.0:
            executor.spin_once(timeout_sec=left)
        message.header.stamp = node.get_clock().now().to_msg()
        message.poses = [_SWAY * (count % 2), 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        publisher.publish(message)
        if arrivals and not is_ready:
            is_ready = True
            there.send(None)
        if is_ready and there.poll():
            there.recv()
            there.send(np.array(arrivals))
            arrivals.clear()
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown()
