"""Clients that call everything: a mix of changes, filters, queries and impossible requests.

A client's life is a generator: it yields a call and is sent the answer. Each client keeps to a
source, a frame and a geometry of its own, so that what it may expect of each answer is known while
others do the same at once. It does what docs/reliability.md asks of clients: it keeps many
answers, and where none comes it calls again.
"""

from __future__ import annotations

import random
import time
from collections import Counter
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any

from drake_geom_msgs import msg, srv
from rclpy.client import Client
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from bench.ros.faults.site import DEPTH, LOST
from bench.ros.hostile import requests
from drake_geom_ros.ros.services.table import SERVICES

Life = Generator[Any, Any, None]
_REASON_LENGTH = 60
_PATIENCE = 300.0  # [s] a node that starts for the first time compiles its kernels


@dataclass
class Tally:
    """What the clients did, and what they did not expect."""

    calls: Counter[str] = field(default_factory=Counter)
    refusals: Counter[str] = field(default_factory=Counter)
    problems: list[str] = field(default_factory=list)


def open_services(node: Node, server: str) -> dict[str, Client]:
    """Return clients of all services of a server, found; the callers share them."""
    profile = QoSProfile(depth=DEPTH)
    services = {
        name: node.create_client(kind, f'{server}/{name}', qos_profile=profile)
        for name, kind, _ in SERVICES
    }
    for name, client in services.items():
        if not client.wait_for_service(_PATIENCE):
            raise RuntimeError(f'there is no service {server}/{name}')
    return services


class MixedClient:
    """One client: a call at a time, the next one with the next tick."""

    def __init__(self, services: dict[str, Client], name: str, seed: int, tally: Tally) -> None:
        self._services, self._name = services, name
        self._random = random.Random(seed)
        self._tally = tally
        self._request: tuple[str, Any] = ('', None)
        self._call: Any = None
        self._sent = 0.0  # [s] of the steady clock
        self._called_again = self._stopping = False
        self.ready = self.finished = False
        self._life = self._live()
        next(self._life)

    def tick(self) -> None:
        """Send the next call if the last one was answered, and that one again if it is late."""
        if self.finished:
            return
        if not self.is_answered():
            if time.monotonic() > self._sent + LOST:
                self._call_again()
            return
        try:
            answer = None if self._call is None else self._call.result()
            service, kind, fields = self._life.send(answer)
        except StopIteration:
            self.finished = True
        else:
            self._request, self._called_again = (service, kind.Request(**fields)), False
            self._send()

    def _send(self) -> None:
        service, request = self._request
        self._call, self._sent = self._services[service].call_async(request), time.monotonic()

    def _call_again(self) -> None:
        """Give a call up, and make it once more: what it was to change may be changed already."""
        service, _ = self._request
        self._services[service].remove_pending_request(self._call)
        self._tally.problems.append(f'{self._name}: {service} had no answer in {LOST:g} s')
        self._called_again = True
        self._send()

    def is_answered(self) -> bool:
        """Return whether no call waits for its answer."""
        return self._call is None or self._call.done()

    def stop(self) -> None:
        """Take back what was registered after the current turn, then be ``finished``."""
        self._stopping = True

    def _ask(self, service: str, kind: Any, expected: bool | None = True, **fields: Any) -> Life:
        """Yield one call and return its answer; None: both answers are right."""
        answer = yield service, kind, fields
        self._tally.calls[service] += 1
        if not answer.success:
            self._tally.refusals[f'{service}: {answer.message[:_REASON_LENGTH]}'] += 1
        if expected not in (None, answer.success) and not self._called_again:
            self._tally.problems.append(
                f'{self._name}: {service} said {answer.success}: {answer.message[:200]}'
            )
        return answer

    def _live(self) -> Life:
        yield
        name = self._name
        yield from self._ask('register_source', srv.RegisterSource, name=name)
        yield from self._ask('register_frame', srv.RegisterFrame, source=name, name='f')
        self.ready = True
        turns = (self._query, self._query, self._query, self._filter, self._change, self._hostile)
        while not self._stopping:
            yield from self._register()
            for _ in range(self._random.randint(1, 6)):
                yield from self._random.choice(turns)()
            geometry = f'{name}::f/g'
            yield from self._ask('remove_geometry', srv.RemoveGeometry, geometry=geometry)

    def _register(self) -> Life:
        shapes = (
            msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1]),
            msg.Shape(type=msg.Shape.CAPSULE, dimensions=[0.05, 0.2]),
        )
        yield from self._ask(
            'register_geometry',
            srv.RegisterGeometry,
            source=self._name,
            frame='f',
            name='g',
            shape=self._random.choice(shapes),
            roles=[msg.Role(role=msg.Role.PROXIMITY)],
        )

    def _query(self) -> Life:
        what = self._random.randrange(7)
        aside = msg.FramePoses(frame_names=[f'{self._name}::f'], poses=[3.0, 0, 0, 0, 0, 0, 1])
        mine = f'{self._name}::f/g'
        if what == 0:
            yield from self._ask('has_collisions', srv.HasCollisions, poses=aside)
        elif what == 1:
            kind = srv.ComputeSignedDistancePairwise
            service = 'compute_signed_distance_pairwise'
            yield from self._ask(service, kind, max_distance=0.1, poses=aside)
        elif what == 2:
            kind = srv.ComputeSignedDistanceToPoint
            service = 'compute_signed_distance_to_point'
            yield from self._ask(service, kind, points=[0.0, 0, 1] * 20, threshold=0.5)
        elif what == 3:
            # In its frame it has a pose; where the frame is nobody ever said.
            place = self._random.choice((srv.GetPose.Request.WORLD, srv.GetPose.Request.PARENT))
            is_known = place == srv.GetPose.Request.PARENT
            yield from self._ask(
                'get_pose', srv.GetPose, is_known, geometry=mine, relative_to=place
            )
        elif what == 4:
            pair = {'geometry_a': mine, 'geometry_b': mine}
            yield from self._ask('explain_filter', srv.ExplainFilter, **pair)
        elif what == 5:
            yield from self._ask('find_collision_candidates', srv.FindCollisionCandidates)
        else:
            yield from self._ask('save_scene', srv.SaveScene)

    def _filter(self) -> Life:
        statement = msg.CollisionFilterStatement(
            operation=msg.CollisionFilterStatement.EXCLUDE_BETWEEN,
            set_a=msg.GeometrySet(frames=[f'{self._name}::f']),
            set_b=msg.GeometrySet(frames=['world']),
        )
        declaration = msg.CollisionFilterDeclaration(statements=[statement])
        if self._random.random() < 0.2:
            # Refused while anybody's transient filter is active.
            yield from self._ask('apply_filter', srv.ApplyFilter, None, declaration=declaration)
            return
        if self._random.random() < 0.1:
            yield from self._ask('flatten_filters', Trigger)
            return
        applied = yield from self._ask(
            'apply_transient_filter',
            srv.ApplyTransientFilter,
            declaration=declaration,
            lease=self._random.choice((0.2, 5.0)),
        )
        number = applied.filter_id
        yield from self._ask('renew_filter', srv.RenewFilter, filter_id=number, lease=0.5)
        yield from self._ask('get_filters', srv.GetFilters)
        if self._random.random() < 0.5:  # the others vanish with their lease
            yield from self._ask('remove_filter', srv.RemoveFilter, filter_id=number)

    def _change(self) -> Life:
        mine = f'{self._name}::f/g'
        shape = msg.Shape(type=msg.Shape.CAPSULE, dimensions=[0.1, 0.3])
        yield from self._ask('change_shape', srv.ChangeShape, geometry=mine, shape=shape)
        role = msg.Role(role=msg.Role.ILLUSTRATION)
        yield from self._ask('assign_role', srv.AssignRole, geometry=mine, role=role)
        yield from self._ask('remove_role', srv.RemoveRole, geometry=mine, role=role.role)

    def _hostile(self) -> Life:
        entries = list(requests(self._name, 'f', f'{self._name}::f/g'))
        service, kind, fields, _ = self._random.choice(entries)
        yield from self._ask(service, kind, False, **fields)
