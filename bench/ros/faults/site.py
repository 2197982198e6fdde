"""What faults are done to: a node with a scene, a spare one beside it, and how they are asked."""

from __future__ import annotations

import random
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from drake_geom_msgs import srv
from rclpy.client import Client
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from bench.ros.processes import ROOT, Processes

NODE = 'drake_geom_ros.ros.scene_graph_node'
SPARE_SCENE = ROOT / 'scenes/minimal.yaml'
DEPTH = 2000  # answers that wait for this process to look
LOST = 120.0  # [s] an answer that has not come by then is lost; at a load of 20 some took 60 s
PATIENCE = 300.0  # [s] for all that a fault waits for
ONE_CALL = 10.0  # [s] after which a call that may be made twice is made again
Spin = Callable[[float], None]


class Site:
    """The node ``server``, whose process is ``process``, and ``spare``, which may lose its scene.

    The spare node has simulated time.
    """

    def __init__(
        self,
        node: Node,
        spin: Spin,
        processes: Processes,
        process: subprocess.Popen[str],
        server: str,
        folder: Path,
    ) -> None:
        """``spin(seconds)`` serves the callbacks of ``node``; the server may open ``folder``."""
        self.node, self.spin, self.processes = node, spin, processes
        self.server, self.pid, self.folder = server, process.pid, folder
        self._process = process
        self.random = random.Random(0)
        self.pause: Callable[[bool], None] = lambda paused: None
        self._clients: dict[str, Client] = {}
        self._publishers: dict[str, Publisher] = {}
        self.spare = f'/spare{server}'
        arguments = ('-r', '__ns:=/spare', '-p', f'scene_file:={SPARE_SCENE}')
        arguments += ('-p', 'use_sim_time:=true', '--log-level', 'error')
        processes.start(NODE, '--ros-args', *arguments)

    def client(self, kind: Any, name: str) -> Client:
        """Return a client of a service that was found."""
        if name not in self._clients:
            profile = QoSProfile(depth=DEPTH)
            self._clients[name] = self.node.create_client(kind, name, qos_profile=profile)
        self.wait_for(self._clients[name].service_is_ready, name)
        return self._clients[name]

    def publisher(self, kind: Any, topic: str) -> Publisher:
        """Return a publisher that somebody listens to."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(kind, topic, 100)
        found = self._publishers[topic]
        self.wait_for(found.get_subscription_count, f'a listener to {topic}')
        return found

    def ask(self, kind: Any, name: str, /, **fields: Any) -> Any:
        """Return the answer to a request, which is made again where it is lost.

        (An answer is while a node that opens its services anew finds who asks.)
        """
        client = self.client(kind, name)
        for _ in range(int(PATIENCE / ONE_CALL)):
            if (answer := self.answer(client, kind.Request(**fields))) is not None:
                return answer
        raise TimeoutError(f'no answer of {name} in {PATIENCE:g} s')

    def answer(self, client: Client, request: Any, patience: float = ONE_CALL) -> Any:
        """Return the answer to one call; None where none comes within ``patience`` [s]."""
        future = client.call_async(request)
        end = time.monotonic() + patience
        self.wait_for(lambda: future.done() or time.monotonic() > end, client.srv_name)
        return future.result() if future.done() else None

    def trouble(self) -> str:
        """Return why the node does not answer; empty where it does."""
        answer = self.ask(srv.HasCollisions, f'{self.server}/has_collisions')
        return '' if answer.success else f'has_collisions says {answer.message}'

    def wait_for(self, fact: Callable[[], Any], what: str) -> None:
        """Serve callbacks until something holds; raises TimeoutError where it does not come."""
        end = time.monotonic() + PATIENCE
        while not fact():
            if self._process.poll() is not None:
                code = self._process.returncode
                raise NodeDiedError(f'the node ended with exit code {code} before {what}')
            if time.monotonic() > end or not rclpy.ok():
                raise TimeoutError(f'waited {PATIENCE:g} s for {what}')
            self.spin(0.005)

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep the callers of the soak, who expect the node to do all they ask, from calling."""
        self.pause(True)
        try:
            yield
        finally:
            self.pause(False)


class NodeDiedError(RuntimeError):
    """The node is gone: no fault may do that."""
