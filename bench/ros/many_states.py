"""Many states by the service ``evaluate_states``, beside single calls and the batch alone.

The demo's two arms. The service is asked from another process than the node's; the batch answers
in a third one: all in turns within one run. Then poses are streamed to the node: how late are the
results while nobody asks, while another process evaluates states on all cores, which is what busy
cores cost, and while the node evaluates them?

    ./run exec python -m bench.ros.many_states [--states 10000] [--at-once 100000]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.ros.meanwhile import beside, delays
from bench.ros.processes import Processes
from bench.ros.scenes import Played, two_arms
from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

NODE = 'drake_geom_ros.ros.scene_graph_node'
TURNS = 5
BATCH, SERVICE = 'a batch elsewhere', 'evaluate_states'
SINGLE = 300  # what-if calls of one state, of which the time is scaled

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


def ask_on(way: str, scene_file: Path, count: int, ready: Any, ending: Any) -> None:
    """Evaluate states, so many at once, until it shall end; print how many a second.

    By a node, or by a batch of this process, which takes as much of the cores and nothing else.
    """
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(scene_file, scene_graph))
    context = scene_graph.CreateDefaultContext()
    generator = np.random.default_rng(1)
    states = generator.uniform(joints.lower, joints.upper, (count, joints.count))
    taken = []
    with SceneGraphClient(patience=600.0) as client:
        ask = {
            BATCH: partial(evaluate, context, states=states, joints=joints, want='collision'),
            SERVICE: partial(client.evaluate_states, joints.names, states),
        }[way]
        ask()
        ready.set()
        while not ending.is_set():
            taken.append(timed(ask))
    print(f'  {way}: {count / np.mean(taken):.0f} states a second')


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--states', type=int, default=10_000)
    parser.add_argument('--at-once', type=int, default=100_000, help='states, while poses stream')
    parser.add_argument('--seconds', type=float, default=10.0, help='of poses, in a turn')
    options = parser.parse_args()
    played = two_arms()
    with Processes() as processes:
        processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        with SceneGraphClient(patience=600.0) as client:
            compare(client, played, options.states)
        ways = {
            way: partial(beside, ask_on, way, played.scene_file, options.at_once)
            for way in (BATCH, SERVICE)
        }
        delays(played, ways, options.seconds)


if __name__ == '__main__':
    main()
