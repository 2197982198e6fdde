"""Clients killed in the middle of large answers, round after round.

    ./run exec python -m bench.ros.killed_clients [--rounds 50] [--seed 0]

After each round the node must answer, and what it is asked must not wait long. A node that does
not is shown, ended by its pid, and replaced by a new one. (Where a thread waits for a mutex of
Fast DDS and holds Python's lock, ``gdb -p PID -batch -ex 'thread apply all bt'`` shows it.)
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from drake_geom_msgs import srv
from rclpy.client import Client
from rclpy.node import Node

from bench.ros.processes import Processes, memory

NODE = 'drake_geom_ros.ros.scene_graph_node'
BODIES = 1000  # their pairs are an answer of 61 MB
PATIENCE = 30.0  # [s] a node that has not answered by then hangs
START = 300.0  # [s] a node that starts for the first time compiles its kernels


def scene_file(folder: Path, bodies: int = BODIES) -> Path:
    """Write a scene of spheres in a row, each on a frame that has a pose."""
    frames, geometries = ['sources: [s]', 'frames:'], ['geometries:']
    for k in range(bodies):
        frames.append(f'- {{name: f{k}, source: s, pose: {{position: [{k}, 0, 0]}}}}')
        geometries.append(
            f'- {{name: g, source: s, frame: f{k}, shape: {{type: sphere, radius: 0.1}}}}'
        )
    path = folder / 'row.yaml'
    path.write_text('\n'.join(frames + geometries))
    return path


def answers(node: Node, client: Client, patience: float) -> float | None:
    """Return after how many seconds the node answered; None: it did not."""
    start = time.monotonic()
    while (left := start + patience - time.monotonic()) > 0.0:
        future = client.call_async(srv.HasCollisions.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=min(left, 10.0))
        if future.done():
            return time.monotonic() - start
    return None


def run(options: argparse.Namespace, folder: Path) -> int:
    """Run all rounds, print each, and return after how many of them the node hung."""
    scene = scene_file(folder)
    hangs = 0
    rclpy.init()
    probe = rclpy.create_node('probe')
    client = probe.create_client(srv.HasCollisions, '/scene_graph/has_collisions')
    with Processes() as processes:
        node = None
        for number in range(options.rounds):
            if node is None:
                node = processes.start(NODE, scene_file=scene)
                client.wait_for_service(START)
            seed = options.seed + number
            arguments = ('--clients', str(options.clients), '--seed', str(seed))
            dying = processes.start('bench.ros.dying', *arguments)
            start = time.monotonic()
            dying.wait()
            seconds = time.monotonic() - start
            after = answers(probe, client, PATIENCE)
            megabytes = memory(node.pid)
            told = 'HANGS' if after is None else f'answered after {after:.2f} s'
            print(f'seed {seed}: {seconds:.1f} s, {told}, {megabytes:.0f} MB', flush=True)
            if after is None:
                hangs += 1
                if options.traces:
                    command = ['gdb', '-p', str(node.pid), '-batch', '-ex', 'thread apply all bt']
                    subprocess.run(command, check=False)
                node.kill()
                node.wait()
                node = None
    rclpy.shutdown()
    return hangs


def main() -> int:
    """Run, print, and return 1 where the node hung."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=50)
    parser.add_argument('--clients', type=int, default=12)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--traces', action='store_true', help='of a node that hangs, by gdb')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        hangs = run(options, Path(folder))
    print(f'{options.rounds} rounds, the node hung after {hangs} of them')
    return 1 if hangs else 0


if __name__ == '__main__':
    sys.exit(main())
