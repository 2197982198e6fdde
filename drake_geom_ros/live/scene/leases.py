"""Leases of transient filters, and which of them ran out; ``scene_filters`` removes these."""

from __future__ import annotations

from collections.abc import Callable

from drake_geom_ros.geometry import FilterId


class Leases:
    """The ends of leases [s] by filter, by one clock."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._ends: dict[FilterId, float] = {}

    def grant(self, filter_id: FilterId, seconds: float) -> None:
        """Let a lease end after ``seconds`` from now; 0: the filter has none any more."""
        if seconds > 0.0:
            self._ends[filter_id] = self._now() + seconds
        else:
            self._ends.pop(filter_id, None)

    def left(self) -> dict[FilterId, float]:
        """Return how long each lease still holds [s]."""
        now = self._now()
        return {filter_id: max(0.0, end - now) for filter_id, end in self._ends.items()}

    def take_expired(self) -> list[FilterId]:
        """Return the filters whose lease has run out, and forget them."""
        now = self._now()
        expired = [filter_id for filter_id, end in self._ends.items() if end <= now]
        for filter_id in expired:
            del self._ends[filter_id]
        return expired
