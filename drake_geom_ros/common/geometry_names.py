"""Names of geometries, and patterns that match them."""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase
from typing import NamedTuple

from drake_geom_ros.common.frame_names import full_name

WORLD = 'world'


class GeometryNames(NamedTuple):
    """Names of a geometry; ``frame_name`` is its frame's own name."""

    source: str
    frame_name: str
    name: str
    is_anchored: bool  # true: its frame is the world, or fixed to it
    # Names of the frames that carry it as a part, and of their sources.
    carriers: tuple[str, ...] = ()
    is_zone: bool = False  # only rules that name it see it

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
        """The full name of its frame, ``source::frame``; ``world`` if it is anchored."""
        return WORLD if self.is_anchored else full_name((self.source, self.frame_name))

    @property
    def body(self) -> str:
        """The name of the body it is part of: its frame, or itself if it is anchored."""
        return full_name((self.source, self.name)) if self.is_anchored else self.frame

    @property
    def own_names(self) -> tuple[str, ...]:
        """The names of the geometry alone, without those of what it is part of."""
        return self.name, self.short_name, self.full_name

    @property
    def found_by(self) -> tuple[str, ...]:
        """The names that patterns match: of its source, frame and carriers, and its own."""
        of_others = self.source, self.frame, self.frame_name, self.body
        return (*of_others, *self.own_names, *self.carriers)


def carrier_names(frames: Iterable[tuple[str, str, bool]]) -> tuple[str, ...]:
    """Return the names of the frames, and their sources, that carry the first one as a part.

    ``frames`` are that frame and its ancestors, upwards: source, own name, and whether it is
    attached to the next one as a part of it.

    >>> carrier_names([('s', 'part', True), ('arm', 'tool', False), ('arm', 'base', False)])
    ('arm', 'tool', 'arm::tool')
    """
    names: list[str] = []
    is_part = False
    for source, name, is_part_of_next in frames:
        if is_part:
            names += [source, name, full_name((source, name))]
        is_part = is_part_of_next
    return tuple(dict.fromkeys(names))


def is_plain(pattern: str) -> bool:
    """Return whether a pattern has no wildcards and matches only itself."""
    return not {'*', '?'}.intersection(pattern)


def matches(names: Iterable[str], pattern: str) -> bool:
    """Return whether one of the names matches ``pattern``, which may contain ``*`` and ``?``.

    >>> matches(['left', 'left::hand'], 'left::*'), matches(['finger[0]'], 'finger[0]')
    (True, True)
    """
    # Brackets are literal, since links have names such as `finger[0]`.
    pattern = pattern.replace('[', '[[]')
    return any(fnmatchcase(name, pattern) for name in names)
