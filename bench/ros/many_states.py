"""Many states by the service ``evaluate_states``, beside single calls and the batch alone.

The demo's two arms. The service is asked from another process than the node's; the batch answers
in a third one: all in turns within one run. Then poses are streamed to the node: how late are the
results while nobody asks, while a process of its own evaluates states on all cores, which is what
cores that are busy cost, and while the node is asked to?

    ./run exec python -m bench.ros.many_states [--states 10000] [--at-once 100000]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
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
TURNS_OF_DELAYS = 3
PLANNER = 'bench.ros.planner'
STARTING = 8.0  # [s] until a planner asks
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


def compare_delays(processes: Processes, played: Played, count: int, seconds: float) -> None:
    """Print how late results are: alone, beside a batch in another process, and while asked."""
    rclpy.init()
    node = rclpy.create_node('driver')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    beside = {'nobody asks': '', 'a batch elsewhere': 'batch', 'evaluate_states': 'service'}
    route = Route(node, 'scene_graph')
    found: dict[str, list[float]] = {name: [] for name in beside}
    lost, rates = dict.fromkeys(beside, 0), {name: [] for name in beside}
    while not route.publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    for _ in range(TURNS_OF_DELAYS):
        for name, way in beside.items():
            if way:
                planner = processes.start(PLANNER, way, str(played.scene_file), str(count))
                time.sleep(STARTING)
            before, lost_before = route.result()
            stream(executor, route, played, RATE, seconds / TURNS_OF_DELAYS)
            delays, all_lost = route.result()
            found[name] += delays[len(before) :]
            lost[name] += all_lost - lost_before
            if way:
                planner.terminate()
                rates[name].append(float(planner.stdout.read().split()[-1]))
                processes.forget(planner)
    for name, each in found.items():
        told = (np.mean(each), *np.percentile(each, (50, 99)))
        cells = ''.join(f'{value * 1e3:9.2f}' for value in told)
        rate = f', {np.mean(rates[name]):.0f} states a second' if rates[name] else ''
        print(f'  {name:20}{cells}{lost[name]:6} of {len(each) + lost[name]}{rate}')
    node.destroy_node()
    rclpy.shutdown()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--states', type=int, default=10_000)
    parser.add_argument('--at-once', type=int, default=100_000, help='states of a call meanwhile')
    parser.add_argument('--seconds', type=float, default=30.0, help='of poses, each way')
    options = parser.parse_args()
    played = two_arms()
    with Processes() as processes:
        processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        with SceneGraphClient(patience=600.0) as client:
            compare(client, played, options.states)
        print(
            f'poses at {RATE:g} Hz: mean, p50 and p99 delay of results [ms], and how many are lost'
        )
        compare_delays(processes, played, options.at_once, options.seconds)


if __name__ == '__main__':
    main()
