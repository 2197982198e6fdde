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
        """What it is found by: its source, frame and thing, and its own names."""
        of_others = self.source, self.frame, self.frame_name, self.body
        return (*of_others, self.name, self.short_name, self.full_name)


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
