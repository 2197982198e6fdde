"""The transforms of a TFMessage in columns: names, which repeat, and numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from drake_geom_ros.live.conversions.message_types import (
    TFMessage,
    TimeMessage,
    TransformStampedMessage,
)
from drake_geom_ros.math.array_types import Flags, Floats, Indices

SECOND = 2**32  # of a stamp as one number: nanoseconds, which are 32 bits, come behind the seconds
_NANOSECOND = 1e-9  # [s]
_MOST_LISTS = 64  # lists of names that are kept


class TransformNames:
    """The parents and children that a message names, in order.

    A sender names the same ones in each message. Then ``names_of`` returns the same object, for
    which it is kept what was looked up.

    Example:
        >>> names = names_of((('world', 'base'), ('base', 'hand')))
        >>> sorted(names.children)
        ['base', 'hand']
        >>> names is names_of((('world', 'base'), ('base', 'hand')))
        True
    """

    def __init__(self, pairs: tuple[tuple[str, str], ...]) -> None:
        """``pairs`` are the names of the parent and the child of each transform."""
        self.pairs = pairs

    def __len__(self) -> int:
        return len(self.pairs)

    @cached_property
    def children(self) -> frozenset[str]:
        """The names of all children."""
        return frozenset(child for _, child in self.pairs)

    @cached_property
    def are_good(self) -> Flags:
        """True where both names of a transform are given, and differ (n,)."""
        pairs = (parent and child and parent != child for parent, child in self.pairs)
        return np.fromiter(map(bool, pairs), dtype=np.bool_, count=len(self))

    @cached_property
    def turns(self) -> tuple[Indices, ...]:
        """The transforms in parts in which no child is named twice: each first, then again."""
        times_named: dict[str, int] = {}
        parts: list[list[int]] = []
        for k, (_, child) in enumerate(self.pairs):
            turn = times_named[child] = times_named.get(child, -1) + 1
            if turn == len(parts):
                parts.append([])
            parts[turn].append(k)
        return tuple(np.array(part, dtype=np.int64) for part in parts)


@lru_cache(maxsize=_MOST_LISTS)
def names_of(pairs: tuple[tuple[str, str], ...]) -> TransformNames:
    """Return the object for the names of parents and children."""
    return TransformNames(pairs)


class Transforms(NamedTuple):
    """The n transforms that a message gives to ``names``, valid or not."""

    names: TransformNames
    rows: Floats  # (n, 7) x y z [m] qx qy qz qw
    seconds: Floats  # (n,) [s] stamps
    order: Indices  # (n,) by which stamps are compared: seconds times SECOND, and nanoseconds
    stamp: Callable[[int], TimeMessage]  # returns that of a row as a builtin_interfaces/Time

    def newest_stamp(self, rows: Indices) -> TimeMessage:
        """Return the newest stamp of some rows, of which there is one or more."""
        return self.stamp(int(rows[np.argmax(self.order[rows])]))


def transforms_of(message: TFMessage) -> Transforms:
    """Return the transforms of a tf2_msgs/TFMessage."""
    entries = message.transforms
    numbers = []
    for entry in entries:
        p, q = entry.transform.translation, entry.transform.rotation
        numbers.append((p.x, p.y, p.z, q.x, q.y, q.z, q.w))
    stamps = [entry.header.stamp for entry in entries]
    seconds, nanoseconds = (
        np.array([getattr(stamp, part) for stamp in stamps], dtype=np.int64)
        for part in ('sec', 'nanosec')
    )
    return Transforms(
        names_of(tuple(names_in(entries))),
        np.array(numbers, dtype=np.float64).reshape(-1, 7),
        *times_of(seconds, nanoseconds),
        stamps.__getitem__,
    )


def times_of(seconds: Indices, nanoseconds: Indices) -> tuple[Floats, Indices]:
    """Return stamps as seconds (n,), and as whole numbers (n,) that are in their order."""
    return seconds + _NANOSECOND * nanoseconds, seconds * SECOND + nanoseconds


def names_in(transforms: Sequence[TransformStampedMessage]) -> list[tuple[str, str]]:
    """Return the names of the parent and the child of each transform."""
    return [
        (plain_name(entry.header.frame_id), plain_name(entry.child_frame_id))
        for entry in transforms
    ]


def plain_name(name: str) -> str:
    """Return a TF frame's name without the leading slash that TF once had."""
    return name.removeprefix('/')
