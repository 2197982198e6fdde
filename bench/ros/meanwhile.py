"""How late results of streamed poses are while nobody asks a node, and while somebody does."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bench.ros.routes import Route, rows_of, stream
from bench.ros.scenes import Played

RATE = 100.0  # [Hz] of poses
TURNS = 3
FIRST = 3.0  # [s] that no figure contains
NOBODY = 'nobody asks'


@contextmanager
def beside(ask_on: Callable[..., None], *arguments: Any) -> Iterator[None]:
    """Let a process of its own ask until this ends: ``ask_on(*arguments, ready, ending)``.

    Within the process that streams poses, what takes long would make these late.
    """
    spawn = multiprocessing.get_context('spawn')
    ready, ending = spawn.Event(), spawn.Event()
    other = spawn.Process(target=ask_on, args=(*arguments, ready, ending))
    other.start()
    ready.wait()
    try:
        yield
    finally:
        ending.set()
        other.join()


def delays(
    played: Played,
    ways: dict[str, Callable[[], AbstractContextManager[object]]],
    seconds: float,
    route_to: Callable[[Node, str], Route] = Route,
) -> None:
    """Print how late results are in turns of so many seconds: alone, and within each way."""
    rclpy.init()
    node = rclpy.create_node('driver')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    route = route_to(node, 'scene_graph')
    found: dict[str, list[float]] = {name: [] for name in (NOBODY, *ways)}
    lost = dict.fromkeys(found, 0)
    rows = rows_of(played, RATE, seconds)

    def turn(name: str) -> None:
        before, lost_before = route.result()
        stream(executor, route, played, RATE, seconds, rows)
        after, lost_after = route.result()
        found[name] += after[len(before) :]
        lost[name] += lost_after - lost_before

    while not route.publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    stream(executor, route, played, RATE, FIRST)  # loads what is compiled
    for _ in range(TURNS):
        turn(NOBODY)
        for name, way in ways.items():
            with way():
                turn(name)
    print(f'poses at {RATE:g} Hz: delay of results [ms], mean, p50, p99; poses without a result')
    for name, each in found.items():
        told = (np.mean(each), *np.percentile(each, (50, 99)))
        cells = ''.join(f'{value * 1e3:9.2f}' for value in told)
        print(f'  {name:28}{cells}{lost[name]:6} lost of {len(each) + lost[name]}')
    node.destroy_node()
    rclpy.shutdown()
