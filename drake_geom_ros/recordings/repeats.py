"""Repeating messages of a batch as arrays, and stretches of only such messages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.inputs.tf_edges import are_transforms
from drake_geom_ros.math.array_types import Flags, Floats, Indices
from drake_geom_ros.recordings.layouts import (
    TRANSFORM_NUMBERS,
    TRANSFORMS,
    Bytes,
    Layouts,
    MessageLayout,
    rows_of,
)
from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TF
from drake_geom_ros.recordings.playback import is_jump
from drake_geom_ros.recordings.raw_messages import NANOSECONDS, Raw, RecordedTopic

_STAMP = {
    CLOCK: 'clock',
    JOINTS: 'header.stamp',
    POSES: 'header.stamp',
    TF: f'{TRANSFORMS}.header.stamp',
}
_NUMBERS = {JOINTS: 'position', POSES: 'poses'}
_FINITE = {JOINTS: ('position', 'velocity'), POSES: ('poses',), CLOCK: ()}


class TimeFields(NamedTuple):
    """The fields of a builtin_interfaces/Time."""

    sec: int
    nanosec: int


class Repeated(NamedTuple):
    """The messages of a batch that share a layout."""

    topic: RecordedTopic
    layout: MessageLayout
    at: Indices  # (n,) their places in the batch
    seconds: Indices  # (n,) of stamps, or of the clock
    nanoseconds: Indices  # (n,)
    numbers: Floats  # (n, k) positions, poses or transforms; none for a clock
    # (n,) usable in a run: numbers are finite, the clock does not jump, and the stamp differs
    # from the previous one. Of TF, all transforms are valid and have one stamp, which is later
    # than the previous one.
    is_good: Flags


class MessageBatch:
    """Messages as bytes, with the repeating ones as arrays."""

    def __init__(self, raws: Sequence[Raw], layouts: Layouts) -> None:
        self.raws = raws
        self.times = np.array([raw.time for raw in raws], dtype=np.int64)
        self.repeated = _repeated(raws, layouts)
        # The index in ``repeated`` of each message, and its row there; -1: it does not repeat.
        self.owner, self.row = np.full((2, len(raws)), -1, dtype=np.int64)
        self.is_good = np.zeros(len(raws), dtype=np.bool_)
        self.stamps = np.zeros((len(raws), 2), dtype=np.int64)
        for number, each in enumerate(self.repeated):
            self.owner[each.at], self.row[each.at] = number, np.arange(len(each.at))
            self.is_good[each.at] = each.is_good
            self.stamps[each.at] = np.column_stack((each.seconds, each.nanoseconds))


@dataclass(frozen=True, eq=False)
class Stretch:
    """Consecutive repeating messages of a batch."""

    batch: MessageBatch
    begin: int
    end: int

    @property
    def count(self) -> int:
        """Number of messages."""
        return self.end - self.begin

    @cached_property
    def owners(self) -> list[int]:
        """Indices of the senders' repeated messages in the batch, without clocks."""
        owners = np.unique(self.batch.owner[self.begin : self.end]).tolist()
        return [k for k in owners if self.batch.repeated[k].topic.type != CLOCK]

    def rows_of(self, sender: int) -> tuple[Indices, Indices]:
        """Return places of a sender's messages in the stretch, and their rows in ``repeated``."""
        owner = self.batch.owner[self.begin : self.end]
        at = np.flatnonzero(owner == self.owners[sender])
        return at, self.batch.row[self.begin + at]

    def messages(self) -> Iterator[tuple[int, int, TimeFields]]:
        """Yield time [ns], sender or -1 for a clock, and stamp of each."""
        part = slice(self.begin, self.end)
        senders = {owner: number for number, owner in enumerate(self.owners)}
        rows = zip(
            self.batch.times[part].tolist(),
            self.batch.owner[part].tolist(),
            self.batch.stamps[part].tolist(),
            strict=True,
        )
        for time, owner, stamp in rows:
            yield time, senders.get(owner, -1), TimeFields(*stamp)


def _repeated(raws: Sequence[Raw], layouts: Layouts) -> list[Repeated]:
    alike: dict[tuple[RecordedTopic, int], list[int]] = {}
    for k, raw in enumerate(raws):
        alike.setdefault((raw.topic, len(raw.data)), []).append(k)
    repeated = []
    for (topic, size), places in alike.items():
        if not layouts.may_know(topic, size, len(places)):
            continue
        at, rows = np.array(places), rows_of([raws[k].data for k in places])
        for layout, chosen in layouts.of(topic, rows):
            repeated.append(_arrays_of(topic, layout, at[chosen], rows[chosen]))
    return repeated


def _arrays_of(topic: RecordedTopic, layout: MessageLayout, at: Indices, rows: Bytes) -> Repeated:
    """Return the contents of messages of a layout as arrays."""
    if topic.type == TF:
        return _transforms_of(topic, layout, at, rows)
    stamp = _STAMP[topic.type]
    parts = (layout.numbers(rows, f'{stamp}.{name}')[:, 0] for name in ('sec', 'nanosec'))
    seconds, nanoseconds = (part.astype(np.int64) for part in parts)
    # The first has no previous one in the batch to compare with.
    is_good = np.append(False, np.ones(len(at) - 1, dtype=np.bool_))
    for path in _FINITE[topic.type]:
        is_good &= np.isfinite(layout.numbers(rows, path)).all(axis=1)
    if topic.type == CLOCK:
        now = seconds + nanoseconds / NANOSECONDS
        is_good[1:] &= ~is_jump(now[:-1], now[1:])
        return Repeated(topic, layout, at, seconds, nanoseconds, np.zeros((len(at), 0)), is_good)
    unstamped = (seconds == 0) & (nanoseconds == 0)
    is_good[1:] &= unstamped[1:] | (np.diff(seconds) != 0) | (np.diff(nanoseconds) != 0)
    numbers = layout.numbers(rows, _NUMBERS[topic.type])
    return Repeated(topic, layout, at, seconds, nanoseconds, numbers, is_good)


def _transforms_of(
    topic: RecordedTopic, layout: MessageLayout, at: Indices, rows: Bytes
) -> Repeated:
    """Return the contents of TF messages as arrays."""
    seconds, nanoseconds = (
        layout.numbers(rows, f'{_STAMP[TF]}.{name}').astype(np.int64)
        for name in ('sec', 'nanosec')
    )
    if not seconds.shape[1]:  # no transforms at all
        none = np.zeros(len(at), dtype=np.int64)
        return Repeated(topic, layout, at, none, none, np.zeros((len(at), 0)), none > 0)
    numbers = np.stack([layout.numbers(rows, path) for path in TRANSFORM_NUMBERS], axis=-1)
    are_good = are_transforms(numbers.reshape(-1, 7)).reshape(numbers.shape[:2])
    is_good: Flags = np.logical_and.reduce(are_good, axis=1)
    for parts in (seconds, nanoseconds):
        is_good &= (parts == parts[:, :1]).all(axis=1)
    stamps = zip(seconds[:, 0].tolist(), nanoseconds[:, 0].tolist(), strict=True)
    held = np.array([seconds_of(TimeFields(*each)) for each in stamps])
    is_good[0] = False  # it has no previous one in the batch to compare with
    is_good[1:] &= (np.diff(held) > 0.0) | ((held == 0.0)[1:] & (held == 0.0)[:-1])
    return Repeated(
        topic, layout, at, seconds[:, 0], nanoseconds[:, 0], numbers.reshape(len(at), -1), is_good
    )
