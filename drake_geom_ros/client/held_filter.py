"""Transient collision filter whose lease a client node renews."""

from __future__ import annotations

from collections.abc import Callable

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.task import Future
from rclpy.timer import Timer

from drake_geom_ros.client.services import Services

LEASE = 2.0  # [s] the filter expires this long after its owner stops renewing it


class HeldFilter:
    """Transient filter declaration whose lease is renewed until ``let_go`` or ``let_run_out``."""

    def __init__(
        self,
        node: Node,
        services: Services,
        declaration: msg.CollisionFilterDeclaration,
        lost: Callable[[], None] = lambda: None,
        lease: float = LEASE,
    ) -> None:
        """Call ``lost()`` if the node removes the filter, as when its scene is replaced."""
        self._node = node
        self._owner = node.get_name()
        self._services = services
        self._lost = lost
        self._lease = lease
        self.declaration = declaration
        self.filter_id = 0
        self._timer: Timer | None = None

    async def hold(self) -> None:
        """Apply the filter and keep renewing it; raise RefusedError if the node refuses.

        This is a coroutine: unless it is awaited, nothing is sent and no pair is filtered. Where
        you cannot await, use the node's executor: ``node.executor.create_task(held.hold())``.
        """
        answer = await self._services.ask(
            'apply_transient_filter',
            declaration=self.declaration,
            owner=self._owner,
            lease=self._lease,
        )
        self.filter_id = answer.filter_id
        self._timer = self._node.create_timer(self._lease / 2, self._renew)

    async def let_go(self) -> None:
        """Remove the filter; raise RefusedError if the node refuses. A coroutine, as ``hold``."""
        self._stop()
        filter_id, self.filter_id = self.filter_id, 0
        await self._services.ask('remove_filter', filter_id=filter_id, owner=self._owner)

    def let_run_out(self) -> None:
        """Stop renewing the filter, so that it is removed when its lease expires."""
        self._stop()
        self.filter_id = 0

    def _renew(self) -> None:
        number, lease = self.filter_id, self._lease
        future = self._services.send(
            'renew_filter', filter_id=number, lease=lease, owner=self._owner
        )
        future.add_done_callback(self._renewed)

    def _renewed(self, future: Future) -> None:
        answer = future.result()
        if self._timer is not None and answer is not None and not answer.active:
            self._stop()
            self.filter_id = 0
            self._lost()

    def _stop(self) -> None:
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None


async def sleep(node: Node, seconds: float) -> None:
    """Wait for some time [s] while other callbacks of the node run."""
    over: Future = Future()
    timer = node.create_timer(seconds, lambda: over.set_result(None))
    await over
    node.destroy_timer(timer)
