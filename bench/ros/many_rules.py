"""What a thousand proximity rules add to a cycle of a node with a thousand bodies.

    ./run exec python -m bench.ros.many_rules [--rate 100] [--seconds 30]

Two nodes have the same bodies, which sway; in one of them each body has a rule against all
others. Poses are sent to both in turns. A cycle is what the node's report says: poses are taken,
distances within 0.1 m computed, rules decided and results published. Milliseconds.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor

from bench.ros.processes import Processes
from bench.ros.routes import Reports, Route, stream
from bench.ros.scenes import Played, bodies

NODE = 'drake_geom_ros.ros.scene_graph_node'
BODIES, TURNS, REACH = 1000, 4, 0.1
WARM_UP = 3.0  # [s] that no figure contains
RULE = '- {{name: rule {0}, set_a: "s::{0}", level: warn, enter: 0.01, leave: 0.02}}'


def with_rules(played: Played) -> Path:
    """Return a scene file of the same bodies with a rule for each."""
    text = played.scene_file.read_text()
    rules = '\n'.join(RULE.format(name) for name in played.frame_names)
    path = played.scene_file.with_name('with_rules.yaml')
    path.write_text(f'{text}proximity_rules:\n{rules}\n')
    return path


def measure(played: Played, rate: float, seconds: float) -> None:
    """Stream to both in turns, and print."""
    node, executor = rclpy.create_node('driver'), SingleThreadedExecutor()
    executor.add_node(node)
    names = 'without', 'with_rules'
    routes, reports = ({n: kind(node, n) for n in names} for kind in (Route, Reports))
    while not all(route.publisher.get_subscription_count() for route in routes.values()):
        executor.spin_once(timeout_sec=0.1)
    for name in names:
        stream(executor, routes[name], played, rate, WARM_UP)
    before = {name: len(reports[name].cycles) for name in names}
    for _ in range(TURNS):
        for name in names:
            stream(executor, routes[name], played, rate, seconds / TURNS)
    means = []
    print(f'{BODIES} bodies, {len(routes[names[0]].latest.id_a)} pairs; mean, p50, p99 [ms]')
    for name in names:
        cycles = np.array(reports[name].cycles[before[name] :]) * 1e3
        means.append(cycles.mean())
        told = ''.join(f'{v:8.2f}' for v in (cycles.mean(), *np.percentile(cycles, (50, 99))))
        print(f'  {name:12}{told}   {len(cycles)} cycles, {routes[name].result()[1]} lost')
    print(f'  ratio of means {means[1] / means[0]:.2f}')


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--rate', type=float, default=100.0)
    parser.add_argument('--seconds', type=float, default=30.0, help='of streaming to each')
    options = parser.parse_args()
    rclpy.init()
    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        played = bodies(BODIES, Path(folder))
        for name, file in (('without', played.scene_file), ('with_rules', with_rules(played))):
            remapped = ('--ros-args', '-r', f'__node:={name}', '--')
            processes.start(NODE, *remapped, scene_file=file, max_distance=REACH)
        measure(played, options.rate, options.seconds)
    rclpy.shutdown()


if __name__ == '__main__':
    main()
