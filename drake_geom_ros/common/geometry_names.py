"""What a geometry is called, and which patterns stand for it."""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase
from typing import NamedTuple

from drake_geom_ros.common.frame_names import full_name

WORLD = 'world'


class GeometryNames(NamedTuple):
    """What a geometry is called; ``frame_name`` is its frame's own name."""

    source: str
    frame_name: str
    name: str
    is_anchored: bool  # then its frame is the world, or fixed to it
    # Names of the frames that carry it as their part, and of their sources.
    carriers: tuple[str, ...] = ()

    @property
    def short_name(self) -> str:
        """The name without its source: ``frame/geometry``."""
        return f'{self.frame_name}/{self.name}'

    @property
    def full_name(self) -> str:
        """The name that services take: ``source::frame/geometry``."""
        return f'{self.source}::{self.short_name}'

    @property
    def frame(self) -> str:
        """The full name of its frame, ``source::frame``; ``world`` where it is anchored."""
        return WORLD if self.is_anchored else full_name((self.source, self.frame_name))

    @property
    def body(self) -> str:
        """The name of the thing it is part of: its frame, or itself where it is anchored."""
        return full_name((self.source, self.name)) if self.is_anchored else self.frame

    @property
    def found_by(self) -> tuple[str, ...]:
        """The names that it is found by: of its source, frame and carriers, and its own."""
        of_others = self.source, self.frame, self.frame_name, self.body
        return (*of_others, self.name, self.short_name, self.full_name, *self.carriers)


def carrier_names(frames: Iterable[tuple[str, str, bool]]) -> tuple[str, ...]:
    """Return the names of what carries the first frame as its part.

    ``frames`` are that frame and those that it hangs on, upwards: source, own name, and whether it
    is attached to the next one as a part of it.

    >>> carrier_names([('s', 'part', True), ('arm', 'tool', False), ('arm', 'base', False)])
    ('arm', 'tool', 'arm::tool')
    """
    found: list[str] = []
    is_part = False
    for source, name, is_part_of_next in frames:
        if is_part:
            found += [source, name, full_name((source, name))]
        is_part = is_part_of_next
    return tuple(dict.fromkeys(found))


def is_plain(pattern: str) -> bool:
    """Return whether a pattern stands for one name, itself."""
    return not {'*', '?'}.intersection(pattern)


def matches(names: Iterable[str], pattern: str) -> bool:
    """Return whether one of the names is ``pattern``, which may hold ``*`` and ``?``.

    >>> matches(['left', 'left::hand'], 'left::*'), matches(['finger[0]'], 'finger[0]')
    (True, True)
    """
    # A bracket is no pattern here: links are called `finger[0]`.
    pattern = pattern.replace('[', '[[]')
    return any(fnmatchcase(name, pattern) for name in names)
