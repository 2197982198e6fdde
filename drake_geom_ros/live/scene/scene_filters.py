"""The filters of the live scene that come and go: transient ones, and those of scene files."""

from __future__ import annotations

import math
from collections.abc import Iterable

from drake_geom_ros.geometry import FilterError, FilterId, FrameId
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.awaited_filters import AwaitedFilters
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.leases import Leases
from drake_geom_ros.live.scene.scene_log import SceneLog
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.touch_links import AttachmentFilters
from drake_geom_ros.scene_files import TouchLinks

_MANY = 100  # geometries of a filter that takes longer than a cycle may wait


class SceneFilters:
    """Owners and leases of transient filters, and the filters that wait for a robot.

    ``touch_links`` are the transient filters of attached frames.
    """

    def __init__(self, model: SceneModel, clocks: Clocks, log: SceneLog) -> None:
        self._model, self._clocks, self._log = model, clocks, log
        self.most_per_owner: float = math.inf  # transient ones that an owner may have
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all filters: another scene takes the place of this one."""
        self.awaited = AwaitedFilters()
        self.touch_links = AttachmentFilters(self._model)
        self._leases = Leases(self._clocks.steady)
        self._owners: dict[int, str] = {}
        self._long: set[int] = set()  # transient ones about many geometries

    def lease(self, filter_id: FilterId, seconds: float) -> None:
        """Let a transient filter vanish after ``seconds``; 0: it stays."""
        self._leases.grant(filter_id, seconds)

    def begin(self, filter_id: FilterId, owner: str, seconds: float, *, is_short: bool) -> int:
        """Keep the owner and the lease of a transient filter that was applied; return its number.

        ``is_short``: it is soon removed, in a large scene too.
        """
        number = filter_id.get_value()
        self._owners[number] = owner
        if not is_short:
            self._long.add(number)
        until = f'for {seconds:g} s' if seconds else 'until it is removed'
        self._log.notes.append(f'transient filter {number} {until}{owned_by(owner)}')
        self.lease(filter_id, seconds)
        return number

    def begin_attached(self, frame: FrameId, owner: str, touch_links: TouchLinks) -> None:
        """Keep the filter of a frame that is attached, which has no lease yet."""
        is_short = len(touch_links.names) < _MANY
        self.begin(touch_links.filter_id, owner, 0.0, is_short=is_short)
        self.touch_links.begin(frame, touch_links)

    def lasting_touch_links(self) -> dict[FrameId, tuple[str, ...]]:
        """Return what attached frames may touch until they are detached: no lease ends it."""
        leased = self._leases.left()
        return {
            frame: names
            for frame, names in self.touch_links.names().items()
            if self.touch_links.filter_of(frame) not in leased
        }

    def end(self, filter_id: FilterId) -> None:
        """Forget the lease of a transient filter that was removed."""
        self.lease(filter_id, 0.0)
        owner = owned_by(self.owner_of(filter_id))
        self._log.notes.append(f'transient filter {filter_id.get_value()} removed{owner}')

    def forget_frames(self, frames: Iterable[FrameId]) -> None:
        """End the filters of attached frames that have gone."""
        for filter_id in self.touch_links.forget(frames):
            self.end(filter_id)

    def refuse_too_many(self, owner: str) -> None:
        """Raise FilterError where an owner has as many transient filters as one may have."""
        limit = self.most_per_owner
        if list(self._owners.values()).count(owner) < limit:
            return  # some of these may be gone, which costs more to know
        if list(self.owners().values()).count(owner) >= limit:
            raise FilterError(
                f'the owner {owner!r} has {limit} transient filters, the most that the parameter '
                'filters_per_owner allows; remove those that are no longer needed '
                '(remove_filter), or let their leases expire'
            )

    def owners(self) -> dict[int, str]:
        """Return who asked for each active transient filter, by its id; empty: nobody said."""
        manager = self._model.filter_manager
        active = []
        if manager.has_transient_history():
            active = [each.get_value() for each in manager.active_filter_ids()]
        # Those of filters that are gone are forgotten here.
        self._owners = {number: self._owners.get(number, '') for number in active}
        self._long.intersection_update(active)
        return dict(self._owners)

    def owner_of(self, filter_id: FilterId) -> str:
        """Return who asked for a transient filter; empty: nobody said, or there is no such one."""
        return self._owners.get(filter_id.get_value(), '') if filter_id.is_valid() else ''

    def is_short(self, filter_id: FilterId) -> bool:
        """Return whether a transient filter is soon removed, in a large scene too."""
        return not filter_id.is_valid() or filter_id.get_value() not in self._long

    def leases(self) -> dict[int, float]:
        """Return how long each transient filter with a lease still has it [s], by its id."""
        return {each.get_value(): left for each, left in self._leases.left().items()}

    def expire(self) -> list[FilterId]:
        """Remove the transient filters whose lease ran out; return them.

        Filters that waited for these to go hold from now on.
        """
        expired = self._leases.take_expired()
        numbers_of: dict[str, list[int]] = {}
        for filter_id in self._model.filter_manager.RemoveDeclarations(expired):
            number = filter_id.get_value()
            numbers_of.setdefault(self._owners.get(number, ''), []).append(number)
        for owner, numbers in numbers_of.items():
            self._log.notes.append(
                f'the lease of {_filters(numbers)} expired: removed{owned_by(owner)}'
            )
        self.bind()
        return expired

    def bind(self) -> None:
        """Apply the filters of scene files that waited for what is there now."""
        self._log.notes += self.awaited.bind(self._model.scene_graph)


def _filters(numbers: list[int]) -> str:
    """Return transient filters in words; thousands may go at once."""
    if len(numbers) == 1:
        return f'transient filter {numbers[0]}'
    return f'{len(numbers)} transient filters ({some_of(numbers)})'


def owned_by(owner: str) -> str:
    """Return an owner in words, to go behind what is owned; empty for none."""
    return f' (owner {owner!r})' if owner else ''
