"""Many states by the service ``evaluate_states``, beside single calls and the batch alone.

The demo's two arms. The service is asked from another process than the node's; the batch answers
in a third one: all in turns within one run. Then poses are streamed to the node while nobody asks
and while a million states are evaluated, in turns: how late are the results?

    ./run exec python -m bench.ros.many_states [--states 10000] [--million 1000000]
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor

from bench.ros.processes import Processes
from bench.ros.routes import Route, stream
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

NODE = 'drake_geom_ros.ros.scene_graph_node'
TURNS = 5
SINGLE = 300  # what-if calls of one state, of which the time is scaled
RATE = 100.0  # [Hz] of poses

Floats = NDArray[np.float64]


def timed(ask: Callable[[], Any]) -> float:
    """Return how long [s] something takes."""
    start = time.perf_counter()
    ask()
    return time.perf_counter() - start


def compare(client: SceneGraphClient, played: Played, count: int) -> None:
    """Print what each way takes for the same states, as times and as ratios to the batch's."""
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(played.scene_file, scene_graph))
    context = scene_graph.CreateDefaultContext()
    states = np.random.default_rng(0).uniform(joints.lower, joints.upper, (count, joints.count))
    singles = [dict(zip(joints.names, q, strict=True)) for q in states[:SINGLE].tolist()]
    for want in ('collision', 'least'):

        def batch(want: str = want) -> Any:
            margin = {'max_distance': 0.0} if want == 'collision' else {}
            return evaluate(context, states=states, joints=joints, want=want, **margin)

        def service(want: str = want) -> Any:
            return client.evaluate_states(joints.names, states, want)

        def each(want: str = want) -> None:
            for values in singles:
                if want == 'collision':
                    client.has_collisions(joints=values)
                else:
                    client.signed_distances(joints=values)

        ways = {'batch alone': batch, 'evaluate_states': service}
        same = np.array_equal(service().free, _free(batch(), want))
        print(f'{want}: {count} states; the two agree: {same}')
        taken: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(TURNS):
            for name, ask in ways.items():
                taken[name].append(timed(ask))
        alone = np.array(taken['batch alone'])
        for name, seconds in taken.items():
            ratio = np.median(np.array(seconds) / alone)
            print(f'  {name:28}{np.median(seconds) * 1e3:10.1f} ms{ratio:8.2f} times the batch')
        one = timed(each) / SINGLE * count
        print(f'  {"single calls, scaled":28}{one * 1e3:10.1f} ms{one / np.median(alone):8.0f}')


def _free(found: Any, want: str) -> Any:
    if want == 'collision':
        return ~np.asarray(found)
    return found.distance - found.error_bound > 0.0


def delays(client: SceneGraphClient, played: Played, count: int, seconds: float) -> None:
    """Print how late results are while nobody asks, and while many states are evaluated."""
    rclpy.init()
    node = rclpy.create_node('driver')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    joints = [joint.full_name for joint in client.scene().joints]
    limits = np.array([joint.limits for joint in client.scene().joints]).T
    states = np.random.default_rng(1).uniform(*limits, (count, len(joints)))
    names = 'nobody asks', 'meanwhile states'
    routes = {name: Route(node, 'scene_graph') for name in names}
    while not routes['nobody asks'].publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    asked: list[float] = []
    for _ in range(2):
        stream(executor, routes['nobody asks'], played, RATE, seconds)
        ending = threading.Event()

        def ask(ending: threading.Event = ending) -> None:
            some = states[: max(1, count // 10)]
            while not ending.is_set():
                seconds = timed(partial(client.evaluate_states, joints, some))
                asked.append(len(some) / seconds)

        thread = threading.Thread(target=ask)
        thread.start()
        stream(executor, routes['meanwhile states'], played, RATE, seconds)
        ending.set()
        thread.join()
    for name, route in routes.items():
        found, lost = route.result()
        p50, p99 = np.percentile(found, (50, 99)) * 1e3
        print(f'  {name:28}p50 {p50:8.2f} ms, p99 {p99:8.2f} ms, lost {lost} of {len(found)}')
    print(f'  meanwhile {np.mean(asked):.0f} states a second')
    node.destroy_node()
    rclpy.shutdown()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--states', type=int, default=10_000)
    parser.add_argument('--million', type=int, default=1_000_000)
    parser.add_argument('--seconds', type=float, default=10.0)
    options = parser.parse_args()
    played = two_arms()
    with Processes() as processes:
        processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        with SceneGraphClient(patience=600.0) as client:
            compare(client, played, options.states)
            print(f'poses at {RATE:g} Hz')
            delays(client, played, options.million, options.seconds)


if __name__ == '__main__':
    main()
