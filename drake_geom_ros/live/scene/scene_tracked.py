"""The bodies that trackers see: what the live scene knows of each, and since when.

The source ``tracked`` also has a heartbeat: a geometry that is in no pair, and whose pose is as
old as the last message of the tracker. Rules about ``tracked`` need it, so they are stale while
the tracker is silent, and they go on while no body is there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import FrameId, GeometryId, Shape, SourceId
from drake_geom_ros.live.conversions.names import TRACKED
from drake_geom_ros.live.scene.clocks import Clocks, Heard
from drake_geom_ros.live.scene.feeds import Feeds
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.math.array_types import Indices

_EARLY = 0.01  # [s] far more than what rounding makes of the end of a lifetime
NAMED_AS_TRACKED = (
    f'the scene has a source {TRACKED!r}, which is what that of tracked bodies is called; give it '
    'another name, or remove it'
)


class TrackedBody(NamedTuple):
    """A body of the scene."""

    frame: FrameId
    geometry: GeometryId
    shape: Shape


class Heartbeat(NamedTuple):
    """The source of tracked bodies, and its frame and geometry that are no body."""

    source: SourceId
    frame: FrameId
    geometry: GeometryId


class SceneTracked:
    """The tracked bodies of the live scene by name.

    - ``heartbeat`` is None before the first message of a tracker.
    - ``feeds`` are the trackers, each with the time of its last message.
    - ``kinds`` are the types of shapes of which bodies were there once.
    """

    def __init__(self, model: SceneModel, clocks: Clocks) -> None:
        self._model, self._clocks = model, clocks
        # Called with the scene where the heartbeat has gone with another scene, to have it again.
        self.stand: Callable[[Any], object] | None = None
        self.kinds: set[type[Shape]] = set()
        self.forget()

    def forget(self) -> None:
        """Know of no body and no tracker."""
        self.heartbeat: Heartbeat | None = None
        self.bodies: dict[str, TrackedBody] = {}
        self._named: dict[str, tuple[float, Heard]] = {}  # lifetime [s], and when it was named
        # No lifetime ends before this time [s] of this epoch: a message looks at no body until
        # then. It is raised where all are looked at.
        self._first_end, self._epoch = -math.inf, self._clocks.epoch
        self.feeds: Feeds[None] = Feeds(self._clocks)
        self._listed: tuple[tuple[str, ...], Indices, frozenset[int]] | None = None

    def change_to(self, bodies: Mapping[str, TrackedBody]) -> None:
        """Have these bodies."""
        self.bodies, self._listed = dict(bodies), None
        self._named = {name: each for name, each in self._named.items() if name in bodies}

    def is_of(self, source: SourceId) -> bool:
        """Return whether a source is that of tracked bodies."""
        return self.heartbeat is not None and self.heartbeat.source == source

    def frames(self, names: tuple[str, ...]) -> tuple[Indices, frozenset[int]]:
        """Return the frames of bodies by the values of their ids, in order and as a set.

        The same ones as for the last call where the names are the same: a tracker repeats them.
        """
        if self._listed is None or self._listed[0] != names:
            values = [self.bodies[name].frame.get_value() for name in names]
            self._listed = names, np.array(values, dtype=np.int64), frozenset(values)
        return self._listed[1:]

    def hear(self, names: Sequence[str], lifetimes: Sequence[float], waited: float) -> None:
        """Note that bodies were named by a message that came ``waited`` [s] ago."""
        heard = self._clocks.heard(waited)
        self._first_end = min(self._first_end, heard.time + min(lifetimes, default=math.inf))
        self._named.update(zip(names, zip(lifetimes, repeat(heard)), strict=True))

    def ended(self) -> list[str]:
        """Return the bodies that were not named for their lifetimes.

        The node's clock counts, by which senders stamp: while simulated time rests, none ends.
        After a jump of that clock lifetimes begin anew.
        """
        now = self._clocks.heard()
        if now.epoch == self._epoch and now.time < self._first_end - _EARLY:
            return []
        before_jump = [n for n, (_, heard) in self._named.items() if heard.epoch != now.epoch]
        for name in before_jump:
            self._named[name] = self._named[name][0], now
        self._epoch = now.epoch
        ends = (heard.time + lifetime for lifetime, heard in self._named.values())
        self._first_end = min(ends, default=math.inf)
        return [n for n, (life, heard) in self._named.items() if now.time - heard.time > life]

    def troubles(self) -> list[str]:
        """Return which trackers there are, in words, where several are."""
        ages = list(self.feeds.ages())
        if len(ages) < 2:
            return []
        each = '; '.join(f'{f.frame} of {f.publisher}: {age:.3g} s old' for f, age in ages)
        return [
            f'{counted(len(ages), "tracker")} send bodies: {each}. The heartbeat is as old as the '
            f'oldest; remove_source {TRACKED} forgets one that has ended'
        ]
