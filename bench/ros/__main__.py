"""From pose message to result message, as a ratio to a bare rclpy round trip of the same sizes.

The node with a scene, and an echo node that answers with messages of the size of the node's
without computing; this process sends the scene's motion at a fixed rate to one, then to the
other, in turns within one run, and never waits for an answer. An answer is known by the number in
its stamp. A bare time means little on a noisy machine, the ratio does.

    ./run exec python -m bench.ros [--scenes arms 200 1000] [--rates 100 500] [--seconds 5]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import rclpy
from drake_geom_msgs.msg import SignedDistancePairs
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from bench.ros.processes import Processes
from bench.ros.routes import Reports, Route, stream
from bench.ros.scenes import Played, bodies, two_arms

NODE = 'drake_geom_ros.ros.scene_graph_node'
TURNS = 2  # of the two routes, back and forth
COLUMNS = 'scene', 'rate', 'pairs', 'node p50', 'p99', 'lost', 'bare p50', 'p99', 'lost'


def measure(node: Node, played: Played, rate: float, seconds: float) -> str:
    """Stream to both in turns; return a row of the table."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    ours, bare = Route(node, 'scene_graph'), Route(node, 'echo')
    template = node.create_publisher(SignedDistancePairs, '/echo/template', 10)
    while not all(p.get_subscription_count() for p in (ours.publisher, bare.publisher, template)):
        executor.spin_once(timeout_sec=0.1)
    for _ in range(TURNS):
        stream(executor, ours, played, rate, seconds / TURNS)
        template.publish(ours.latest)
        stream(executor, bare, played, rate, seconds / TURNS)
    executor.remove_node(node)
    results = [route.result() for route in (ours, bare)]
    quantiles = [np.percentile(delays, (50, 99)) * 1e3 for delays, _ in results]
    cells = [f'{rate:8g}{len(ours.latest.id_a):8}']
    for (p50, p99), (_, lost) in zip(quantiles, results, strict=True):
        cells.append(f'{p50:10.2f}{p99:8.2f}{lost:6}')
    ratios = quantiles[0] / quantiles[1]
    return ''.join(cells) + f'{ratios[0]:8.2f}{ratios[1]:8.2f}'


def profile(node: Node, played: Played, rate: float, seconds: float) -> list[str]:
    """Stream to the node with a subscriber of its reports; return where a cycle's time goes."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    ours, reports = Route(node, 'scene_graph'), Reports(node, 'scene_graph')
    while not ours.publisher.get_subscription_count():
        executor.spin_once(timeout_sec=0.1)
    stream(executor, ours, played, rate, seconds)
    executor.remove_node(node)
    delays, _ = ours.result()
    delay, cycle = np.median(delays) * 1e3, np.median(reports.cycles) * 1e3
    lines = [f'    {name:28}{np.median(all) * 1e3:8.3f}' for name, all in reports.effects.items()]
    return [
        *lines,
        f'    {"cycle":28}{cycle:8.3f}',
        f'    {"delay, transport and all":28}{delay:8.3f}',
    ]


def run(options: argparse.Namespace, name: str, folder: Path) -> None:
    """Measure one scene at all rates, and print."""
    played = two_arms() if name == 'arms' else bodies(int(name), folder)
    with Processes() as processes:
        processes.start(NODE, scene_file=played.scene_file, max_distance=0.1)
        processes.start('bench.ros.echo')
        for rate in options.rates:
            rclpy.init()
            driver = rclpy.create_node('driver')
            print(f'{name:>8}{measure(driver, played, rate, options.seconds)}', flush=True)
            driver.destroy_node()
            rclpy.shutdown()
        rclpy.init()
        driver = rclpy.create_node('profiler')
        print(f'    where the time goes at {options.rates[0]:g} Hz [ms], medians:')
        print('\n'.join(profile(driver, played, options.rates[0], options.seconds)), flush=True)
        rclpy.shutdown()


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        prog='python -m bench.ros', description=__doc__.split('\n')[0]
    )
    parser.add_argument('--scenes', nargs='+', default=['arms', '200', '1000'])
    parser.add_argument('--rates', nargs='+', type=float, default=[100.0, 500.0])
    parser.add_argument('--seconds', type=float, default=5.0, help='of streaming to each')
    options = parser.parse_args()
    widths = (8, 8, 8, 10, 8, 6, 10, 8, 6)
    titles = ''.join(f'{c:>{w}}' for c, w in zip(COLUMNS, widths, strict=True))
    print(f'{titles}{"ratios":>16}   (times in ms, rates in Hz)')
    with tempfile.TemporaryDirectory() as folder:
        for name in options.scenes:
            run(options, name, Path(folder))


if __name__ == '__main__':
    main()
