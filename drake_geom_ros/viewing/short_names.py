"""Short names for tables, without the parts that all names share."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from itertools import accumulate, takewhile

_PARTS = re.compile(r'(?<=::)|(?<=/)')
_WORDS = re.compile(r'(?<=[_ .-])')


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Return a short form of each ``source::frame/geometry`` that differs from the others.

    Leading words of a part are omitted if all names with the same beginning share them: for
    example ``left::link5/0`` if all links of that arm begin with ``panda_``, and all their
    geometries with ``collision_``. A part that is the only one after its beginning is omitted.
    Names that would become equal remain unchanged.
    """
    parts = {name: _PARTS.split(name) for name in names}
    followers: defaultdict[str, set[str]] = defaultdict(set)
    for each in parts.values():
        for beginning, part in zip(_starts(each), each, strict=True):
            followers[beginning].add(part)
    shared = {beginning: _in_common(next_parts) for beginning, next_parts in followers.items()}
    short = {name: _without(each, shared) for name, each in parts.items()}
    alike = Counter(short.values())
    return {name: each if alike[each] == 1 else name for name, each in short.items()}


def _without(parts: list[str], shared: dict[str, int]) -> str:
    """Return the joined parts without their shared letters, whose count depends on the prefix."""
    rests = [part[shared[start] :] for start, part in zip(_starts(parts), parts, strict=True)]
    return ''.join(rests).rstrip('/:') or parts[-1]


def _starts(parts: list[str]) -> list[str]:
    """Return the prefix of the name before each part."""
    return list(accumulate(['', *parts[:-1]]))


def _in_common(parts: set[str]) -> int:
    """Return the number of letters in the leading words that all parts share."""
    columns = zip(*(_WORDS.split(part) for part in parts), strict=False)
    alike = takewhile(lambda column: len(set(column)) == 1, columns)
    return sum(len(column[0]) for column in alike)
