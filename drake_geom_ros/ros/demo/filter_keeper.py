"""Keeps a scene_graph node's collision filters as a client wants them, through its services."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drake_geom_msgs import msg, srv
from rclpy.node import Node
from rclpy.task import Future

LEASE = 2.0  # [s] a transient filter of ours vanishes this long after we do


class FilterKeeper:
    """One persistent declaration at the beginning, then one transient filter that follows wishes.

    ``told(text)`` is called after each change, ``failed(text)`` when a service refuses.
    """

    def __init__(
        self, node: Node, told: Callable[[str], None], failed: Callable[[str], None]
    ) -> None:
        self._node = node
        self._told = told
        self._failed = failed
        self._apply = self._client(srv.ApplyFilter, 'apply_filter')
        self._apply_transient = self._client(srv.ApplyTransientFilter, 'apply_transient_filter')
        self._renew = self._client(srv.RenewFilter, 'renew_filter')
        self._remove = self._client(srv.RemoveFilter, 'remove_filter')
        self._get = self._client(srv.GetFilters, 'get_filters')
        self._wanted = self._applied = msg.CollisionFilterDeclaration()
        self._filter_id = 0
        # Wishes wait until the persistent declaration is in place.
        self._busy = True
        self.filtered_pairs: int | None = None
        node.create_timer(LEASE / 2, self._renew_lease)

    def _client(self, kind: Any, name: str) -> Any:
        return self._node.create_client(kind, f'scene_graph/{name}')

    async def exclude_for_good(
        self, declaration: msg.CollisionFilterDeclaration, text: str
    ) -> None:
        """Apply a persistent declaration, then begin to follow the wishes."""
        before = await self._count()
        request = srv.ApplyFilter.Request(declaration=declaration)
        while not (answer := await self._apply.call_async(request)).success:
            # The transient filter of a client before us: its lease runs out.
            self._node.get_logger().warning(f'apply_filter: {answer.message}')
            await sleep(self._node, LEASE / 4)
        after = await self._count()
        self._told(f'for good: {text} ({before} -> {after} filtered pairs)')
        self._busy = False
        await self.follow(self._wanted)

    async def follow(self, wanted: msg.CollisionFilterDeclaration) -> None:
        """Make the transient filter what is wanted now, one change after the other."""
        self._wanted = wanted
        if self._busy:
            return
        self._busy = True
        while self._applied != self._wanted:
            wanted = self._wanted
            if self._filter_id:
                request = srv.RemoveFilter.Request(filter_id=self._filter_id)
                await self._ask(self._remove, request)
                self._told(f'transient filter #{self._filter_id} removed')
                self._filter_id = 0
            if wanted.statements:
                request = srv.ApplyTransientFilter.Request(
                    declaration=wanted, owner=self._node.get_name(), lease=LEASE
                )
                self._filter_id = (await self._ask(self._apply_transient, request)).filter_id
                texts = '; '.join(_text_of(statement) for statement in wanted.statements)
                self._told(f'transient filter #{self._filter_id}: {texts}')
            self._applied = wanted
            await self._count()
        self._busy = False

    async def _count(self) -> int:
        answer = await self._ask(self._get, srv.GetFilters.Request())
        pairs = int(answer.filtered_pairs)
        self.filtered_pairs = pairs
        return pairs

    async def _ask(self, client: Any, request: Any) -> Any:
        answer = await client.call_async(request)
        if not answer.success:
            self._failed(f'{client.srv_name} refused: {answer.message}')
        return answer

    def _renew_lease(self) -> None:
        if self._filter_id:
            request = srv.RenewFilter.Request(filter_id=self._filter_id, lease=LEASE)
            self._renew.call_async(request)


async def sleep(node: Node, seconds: float) -> None:
    """Return after some time [s], while the node's other callbacks run."""
    over: Future = Future()
    timer = node.create_timer(seconds, lambda: over.set_result(None))
    await over
    node.destroy_timer(timer)


def exclude_between(
    set_a: msg.GeometrySet, set_b: msg.GeometrySet
) -> msg.CollisionFilterStatement:
    """Return the statement that excludes the pairs of two sets."""
    return msg.CollisionFilterStatement(
        operation=msg.CollisionFilterStatement.EXCLUDE_BETWEEN, set_a=set_a, set_b=set_b
    )


def _text_of(statement: msg.CollisionFilterStatement) -> str:
    members = [', '.join([*s.frames, *s.geometries]) for s in (statement.set_a, statement.set_b)]
    return f'{members[0]} against {members[1]}'
