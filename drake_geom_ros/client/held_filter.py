"""A transient filter that lasts as long as the node that asked for it."""

from __future__ import annotations

from collections.abc import Callable

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.task import Future
from rclpy.timer import Timer

from drake_geom_ros.client.services import Services

LEASE = 2.0  # [s] it vanishes this long after its owner did


class HeldFilter:
    """A transient declaration whose lease is renewed until the filter is let go."""

    def __init__(
        self,
        node: Node,
        services: Services,
        declaration: msg.CollisionFilterDeclaration,
        lost: Callable[[], None] = lambda: None,
        lease: float = LEASE,
    ) -> None:
        """``lost()`` is called if the node removed the filter, as when its scene was replaced."""
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

        A coroutine: await it, or nothing is sent and no pair is filtered. Where nobody can, give
        it to the node's executor: ``node.executor.create_task(held.hold())``.
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
        """Remove the filter; raise RefusedError if the node refuses. Await it, as ``hold``."""
        self._stop()
        filter_id, self.filter_id = self.filter_id, 0
        await self._services.ask('remove_filter', filter_id=filter_id, owner=self._owner)

    def let_run_out(self) -> None:
        """Stop renewing the filter: it is removed when its lease ends."""
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
