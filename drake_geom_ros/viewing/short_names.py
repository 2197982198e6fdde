"""Names without what tells nothing apart: where they are many, as in a table, they are shorter."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from itertools import accumulate, takewhile

_PARTS = re.compile(r'(?<=::)|(?<=/)')
_WORDS = re.compile(r'(?<=[_ .-])')


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Return what tells each ``source::frame/geometry`` from the others.

    Of each part is left out with which words all of them go on that begin alike, as in
    ``left::link5/0`` where all links of that arm are a ``panda_``, and all their geometries a
    ``collision_``; so is a part in which they have no choice. Names that would be alike then stay
    as they are.
    """
    parts = {name: _PARTS.split(name) for name in names}
    followers: defaultdict[str, set[str]] = defaultdict(set)
    for each in parts.values():
        for beginning, part in zip(_starts(each), each, strict=True):
            followers[beginning].add(part)
    told = {beginning: _in_common(given) for beginning, given in followers.items()}
    short = {name: _without(each, told) for name, each in parts.items()}
    alike = Counter(short.values())
    return {name: each if alike[each] == 1 else name for name, each in short.items()}


def _without(parts: list[str], told: dict[str, int]) -> str:
    """Return parts joined, each without so many letters as are told of what is before it."""
    kept = [part[told[start] :] for start, part in zip(_starts(parts), parts, strict=True)]
    return ''.join(kept).rstrip('/:') or parts[-1]


def _starts(parts: list[str]) -> list[str]:
    """Return what is before each part."""
    return list(accumulate(['', *parts[:-1]]))


def _in_common(parts: set[str]) -> int:
    """Return the length of the words with which all parts begin."""
    columns = zip(*(_WORDS.split(part) for part in parts), strict=False)
    alike = takewhile(lambda column: len(set(column)) == 1, columns)
    return sum(len(column[0]) for column in alike)
