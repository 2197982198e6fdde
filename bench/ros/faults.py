"""Faults that production brings, one after the other in an order that a seed fixes.

Each fault is a function of the soak: it does harm, and returns what was not as it should be after
it. Those that would take the scene from the callers are done to a second node, beside.
"""

from __future__ import annotations

import math
import random
import signal
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import rclpy
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bench.ros.processes import ROOT, Processes

CALLS = 200  # of a burst
LEASES, AT_ONCE = 1000, 250
LEASE = 2.0  # [s]
DYING = 6  # clients
PATIENCE = 60.0  # [s] what has no answer then has none
SPARE_SCENE = ROOT / 'scenes/minimal.yaml'
LATE = 'sources: [late]\nframes: [{name: hand, source: late}]\n'
# Parameters, their values in the soak, and values at the ends of what may be.
ENDS = (
    ('max_distance', 0.1, (0.0, 5e-324, 1.7e308, math.inf)),
    ('rate', 0.0, (1e-3, 1e4)),
    ('time_budget', 0.0, (5e-324, 1.7e308, math.inf)),
    ('stale_after', 1.0, (0.0, 5e-324, math.inf)),
    ('point_threshold', 0.1, (0.0, 5e-324, math.inf)),
    ('max_answer_size', 64.0, (0.0, 2000.0)),
)
Spin = Callable[[float], None]


class Faults:
    """Does one fault after the other."""

    def __init__(
        self, node: Node, spin: Spin, processes: Processes, server: str, seed: int
    ) -> None:
        """``spin(seconds)`` serves the callbacks of ``node``."""
        self._spin, self._processes, self._server = spin, processes, server
        self._random = random.Random(seed)
        self._node = node
        self._clients: dict[str, Client] = {}
        self._spare = f'/spare{server}'
        processes.start(
            'drake_geom_ros.ros.scene_graph_node',
            *('--ros-args', '-r', '__ns:=/spare', '-p', f'scene_file:={SPARE_SCENE}'),
        )
        self.counts: Counter[str] = Counter()
        self._faults: tuple[Callable[[], str], ...] = (
            self.burst,
            self.killed_clients,
            self.stopped_subscriber,
            self.parameter_at_its_end,
            self.leases,
            self.cleanup,
        )

    def do_one(self) -> list[str]:
        """Do a fault, and return what was not as it should be."""
        fault = self._random.choice(self._faults)
        name = fault.__name__
        self.counts[name] += 1
        print(f'fault {self.counts.total()}: {name}', flush=True)
        try:
            problem = fault()
        except TimeoutError as error:
            problem = str(error)
        return [f'{name}, fault {self.counts.total()}: {problem}'] if problem else []

    # The faults.

    def burst(self) -> str:
        """Call two hundred times at once."""
        client = self._client(srv.HasCollisions, f'{self._server}/has_collisions')
        futures = [client.call_async(srv.HasCollisions.Request()) for _ in range(CALLS)]
        self._wait_for(lambda: all(f.done() for f in futures), f'{CALLS} answers')
        return ''

    def killed_clients(self) -> str:
        """Kill clients while they wait for answers or read them."""
        arguments = ('--clients', str(DYING), '--seed', str(self._random.randrange(10**6)))
        dying = self._processes.start('bench.ros.dying', *arguments)
        self._wait_for(lambda: dying.poll() is not None, 'the clients to die')
        return self._still_answers()

    def stopped_subscriber(self) -> str:
        """Stop a subscriber that reads, and kill it later."""
        listener = self._processes.start('bench.ros.listener')
        self._spin(self._random.uniform(1.0, 3.0))
        listener.send_signal(signal.SIGSTOP)
        self._spin(self._random.uniform(1.0, 5.0))
        listener.kill()
        listener.wait()
        return self._still_answers()

    def parameter_at_its_end(self) -> str:
        """Set a parameter to what is just allowed, and back."""
        name, usual, ends = self._random.choice(ENDS)
        for value in (self._random.choice(ends), usual):
            number = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
            parameters = [Parameter(name=name, value=number)]
            answer = self._ask(SetParameters, f'{self._server}/set_parameters', parameters)
            if not answer.results[0].successful:
                return f'{name} {value}: {answer.results[0].reason}'
            self._spin(0.5)
        return ''

    def leases(self) -> str:
        """Take a thousand leases, which run out almost together."""
        name = f'{self._server}/apply_transient_filter'
        client = self._client(srv.ApplyTransientFilter, name)
        request = srv.ApplyTransientFilter.Request(
            declaration=msg.CollisionFilterDeclaration(), lease=LEASE, owner='leases'
        )
        futures: list[Any] = []

        def all_done() -> bool:
            return all(future.done() for future in futures)

        while len(futures) < LEASES:
            futures += [client.call_async(request) for _ in range(AT_ONCE)]
            self._wait_for(all_done, f'{len(futures)} leases')
        mine = {f.result().filter_id for f in futures if f.result().success}

        def left() -> set[int]:
            answer = self._ask(srv.GetFilters, f'{self._server}/get_filters')
            return mine & set(answer.active_filter_ids)

        self._wait_for(lambda: not left(), 'the end of the leases')
        return ''

    def cleanup(self) -> str:
        """Clean the spare node up while it loads: it comes back with its scene."""
        before = self._ask(srv.SaveScene, f'{self._spare}/save_scene').text
        loading = self._client(srv.LoadScene, f'{self._spare}/load_scene')
        late = loading.call_async(srv.LoadScene.Request(text=LATE))
        self._spin(self._random.uniform(0.0, 0.1))
        for number in (
            Transition.TRANSITION_DEACTIVATE,
            Transition.TRANSITION_CLEANUP,
            Transition.TRANSITION_CONFIGURE,
            Transition.TRANSITION_ACTIVATE,
        ):
            transition = Transition(id=number)
            if not self._ask(ChangeState, f'{self._spare}/change_state', transition).success:
                return f'transition {number} failed'
        after = self._ask(srv.SaveScene, f'{self._spare}/save_scene').text
        late.cancel()
        return '' if after == before else f'the scene came back as {after!r}'

    # What faults need.

    def _still_answers(self) -> str:
        answer = self._ask(srv.HasCollisions, f'{self._server}/has_collisions')
        return '' if answer.success else str(answer.message)

    def _client(self, kind: Any, name: str) -> Client:
        if name not in self._clients:
            profile = QoSProfile(depth=2 * LEASES)
            self._clients[name] = self._node.create_client(kind, name, qos_profile=profile)
        self._wait_for(self._clients[name].service_is_ready, name)
        return self._clients[name]

    def _ask(self, kind: Any, name: str, value: Any = None) -> Any:
        """Return the answer to a request; ``value`` is its one field."""
        request = kind.Request()
        if value is not None:
            (field,) = kind.Request.get_fields_and_field_types()
            setattr(request, field, value)
        client = self._client(kind, name)
        # An answer may be lost while a node that opens its services anew finds who asks.
        for _ in range(int(PATIENCE / 10.0)):
            future = client.call_async(request)
            end = time.monotonic() + 10.0
            self._wait_for(lambda f=future, e=end: f.done() or time.monotonic() > e, name)
            if future.done():
                return future.result()
        raise TimeoutError(f'no answer of {name} in {PATIENCE:g} s')

    def _wait_for(self, fact: Callable[[], Any], what: str) -> None:
        end = time.monotonic() + PATIENCE
        while not fact():
            if time.monotonic() > end or not rclpy.ok():
                raise TimeoutError(f'waited {PATIENCE:g} s for {what}')
            self._spin(0.02)


def listed(counts: Counter[str]) -> str:
    """Return how many of each in words."""
    return ', '.join(f'{n} {name.replace("_", " ")}' for name, n in sorted(counts.items()))
