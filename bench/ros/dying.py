"""Clients that ask for large answers and are killed in the middle of them.

Started as a process: it forks the clients, each with a ROS context of its own, and kills them with
SIGKILL in a random order, at random moments after the first request.
"""

from __future__ import annotations

import argparse
import os
import random
import select
import signal
import time
from typing import Any

import rclpy
from drake_geom_msgs import srv

SERVER = '/scene_graph'
PATIENCE = 30.0  # [s] to find the service
LONGEST_LIFE = 3.0  # [s] after the request; an answer of 60 MB takes about half a second


def question(points: int) -> tuple[Any, str, Any]:
    """Return the type, the name and the request of a service: all pairs, or so many points."""
    if not points:
        kind = srv.ComputeSignedDistancePairwise
        return kind, 'compute_signed_distance_pairwise', kind.Request()
    kind = srv.ComputeSignedDistanceToPoint
    request = kind.Request(points=[0.01 * k for k in range(3 * points)])
    return kind, 'compute_signed_distance_to_point', request


def ask(sent: int, points: int) -> None:
    """Ask for ever, and tell by the file descriptor ``sent`` when it began."""
    parent = os.getppid()
    kind, name, request = question(points)
    rclpy.init()
    node = rclpy.create_node(f'dying_{os.getpid()}')
    client = node.create_client(kind, f'{SERVER}/{name}')
    if not client.wait_for_service(PATIENCE):
        os._exit(1)
    os.write(sent, b'.')
    while os.getppid() == parent:
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future, timeout_sec=LONGEST_LIFE)
    os._exit(1)


def live_and_die(count: int, seed: int, points: int, life: float) -> None:
    """Fork ``count`` clients; kill them while they wait or read, within ``life`` [s]."""
    moments = random.Random(seed)
    begun, sent = os.pipe()
    clients = []
    for _ in range(count):
        if not (client := os.fork()):
            ask(sent, points)
        clients.append(client)
    os.close(sent)
    end = time.monotonic() + PATIENCE
    asked = 0
    for _ in clients:  # one that a dead one's mutex holds up is killed with the others
        if not select.select([begun], [], [], max(0.0, end - time.monotonic()))[0]:
            break
        asked += len(os.read(begun, 1))
    print(f'{asked} of {count} clients ask', flush=True)
    moments.shuffle(clients)
    deaths = sorted(moments.uniform(0.0, life) for _ in clients)
    start = time.monotonic()
    for client, death in zip(clients, deaths, strict=True):
        time.sleep(max(0.0, start + death - time.monotonic()))
        os.kill(client, signal.SIGKILL)
        os.waitpid(client, 0)


def main() -> None:
    """Run one round."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--clients', type=int, default=12)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--points', type=int, default=0, help='asked about; 0: all pairs')
    parser.add_argument(
        '--life', type=float, default=LONGEST_LIFE, help='of a client, at most [s]'
    )
    options = parser.parse_args()
    live_and_die(options.clients, options.seed, options.points, options.life)


if __name__ == '__main__':
    main()
