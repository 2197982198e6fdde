"""Clients that ask for all pairs at once and are killed in the middle of their answers.

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

import rclpy
from drake_geom_msgs import srv

SERVICE = '/scene_graph/compute_signed_distance_pairwise'
PATIENCE = 10.0  # [s] to find the service
LONGEST_LIFE = 3.0  # [s] after the request; an answer of 60 MB takes about half a second


def ask(sent: int) -> None:
    """Ask for all pairs for ever, and tell by the file descriptor ``sent`` when it began."""
    parent = os.getppid()
    rclpy.init()
    node = rclpy.create_node(f'dying_{os.getpid()}')
    client = node.create_client(srv.ComputeSignedDistancePairwise, SERVICE)
    if not client.wait_for_service(PATIENCE):
        os._exit(1)
    os.write(sent, b'.')
    while os.getppid() == parent:
        future = client.call_async(srv.ComputeSignedDistancePairwise.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=LONGEST_LIFE)
    os._exit(1)


def live_and_die(count: int, seed: int) -> None:
    """Fork ``count`` clients and kill them while they wait for answers or read them."""
    moments = random.Random(seed)
    begun, sent = os.pipe()
    clients = []
    for _ in range(count):
        if not (client := os.fork()):
            ask(sent)
        clients.append(client)
    os.close(sent)
    end = time.monotonic() + PATIENCE
    for _ in clients:  # one that a dead one's mutex holds up is killed with the others
        if not select.select([begun], [], [], max(0.0, end - time.monotonic()))[0]:
            break
        os.read(begun, 1)
    moments.shuffle(clients)
    deaths = sorted(moments.uniform(0.0, LONGEST_LIFE) for _ in clients)
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
    options = parser.parse_args()
    live_and_die(options.clients, options.seed)


if __name__ == '__main__':
    main()
