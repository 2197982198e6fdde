"""Keeps a scene_graph node's collision filters as a client wants them, through its services."""

from __future__ import annotations

from collections.abc import Callable

from drake_geom_msgs import msg
from rclpy.node import Node

from drake_geom_ros.client import HeldFilter, RefusedError, Services, sleep
from drake_geom_ros.client.held_filter import LEASE

_SERVICES = (
    *('apply_filter', 'apply_transient_filter', 'renew_filter', 'remove_filter'),
    'get_filters',
)


class FilterKeeper:
    """One persistent declaration, then one transient filter that follows intended contacts.

    ``changed(text)`` is called after each change, ``failed(text)`` when a service refuses.
    """

    def __init__(
        self, node: Node, changed: Callable[[str], None], failed: Callable[[str], None]
    ) -> None:
        self._node = node
        self._changed = changed
        self._failed = failed
        self._services = Services(node, 'scene_graph')
        self._wanted = self._applied = msg.CollisionFilterDeclaration()
        self._held: HeldFilter | None = None
        # Wishes wait until the persistent declaration is in place.
        self._busy = True
        self.filtered_pairs: int | None = None

    def missing(self) -> list[str]:
        """Return the services that are needed and that nobody serves yet."""
        return self._services.missing(*_SERVICES)

    async def exclude_for_good(
        self, declaration: msg.CollisionFilterDeclaration, text: str
    ) -> None:
        """Apply a persistent declaration, then begin to follow the wishes."""
        before = await self._count()
        while True:
            try:
                await self._services.ask('apply_filter', declaration=declaration)
                break
            except RefusedError as error:
                # The transient filter of a client before us: its lease runs out.
                self._node.get_logger().warning(str(error))
                await sleep(self._node, LEASE / 4)
        after = await self._count()
        self._changed(f'for good: {text} ({before} -> {after} filtered pairs)')
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
            try:
                await self._exchange(wanted)
                await self._count()
            except RefusedError as error:
                self._failed(str(error))
            self._applied = wanted
        self._busy = False

    async def _exchange(self, wanted: msg.CollisionFilterDeclaration) -> None:
        """Put a transient filter in the place of the one before."""
        held, self._held = self._held, None
        if held is not None:
            filter_id = held.filter_id
            await held.let_go()
            self._changed(f'transient filter #{filter_id} removed')
        if wanted.statements:
            self._held = HeldFilter(self._node, self._services, wanted)
            await self._held.hold()
            texts = '; '.join(_text_of(statement) for statement in wanted.statements)
            self._changed(f'transient filter #{self._held.filter_id}: {texts}')

    async def _count(self) -> int:
        answer = await self._services.ask('get_filters')
        self.filtered_pairs = int(answer.filtered_pairs)
        return self.filtered_pairs


def _text_of(statement: msg.CollisionFilterStatement) -> str:
    members = [', '.join([*s.frames, *s.geometries]) for s in (statement.set_a, statement.set_b)]
    return f'{members[0]} against {members[1]}'
