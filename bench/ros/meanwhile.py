"""How late results of streamed poses are while nobody asks a node, and while somebody does."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor

from bench.ros.routes import Route, stream
from bench.ros.scenes import Played

RATE = 100.0  # [Hz] of poses
TURNS = 2
FIRST = 3.0  # [s] that no figure contains


@contextmanager
def thread(ask: Callable[[], object]) -> Iterator[list[float]]:
    """Ask again and again by a thread of this process; yields how long [s] each call took."""
    taken: list[float] = []
    ending = threading.Event()

    def again() -> None:
        while not ending.is_set():
            start = time.perf_counter()
            ask()
            taken.append(time.perf_counter() - start)

    asking = threading.Thread(target=again)
    asking.start()
    try:
        yield taken
    finally:
        ending.set()
        asking.join()


def delays(
    played: Played, name: str, asking: Callable[[], AbstractContextManager[object]], seconds: float
) -> None:
    """Print how late results are in turns of so many seconds, without and within ``asking``."""
    rclpy.init()
    node = rclpy.create_node('driver')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    routes = {each: Route(node, 'scene_graph') for each in ('nobody asks', name)}
    while not routes['nobody asks'].publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    stream(executor, Route(node, 'scene_graph'), played, RATE, FIRST)  # loads what is compiled
    for _ in range(TURNS):
        stream(executor, routes['nobody asks'], played, RATE, seconds)
        with asking():
            stream(executor, routes[name], played, RATE, seconds)
    for each, route in routes.items():
        found, lost = route.result()
        p50, p99 = np.percentile(found, (50, 99)) * 1e3
        print(f'  {each:28}p50 {p50:8.2f} ms, p99 {p99:8.2f} ms, lost {lost} of {len(found)}')
    node.destroy_node()
    rclpy.shutdown()
