"""The names that somebody may have meant who gave one that does not exist."""

import difflib
from collections.abc import Iterable

_MOST = 3


def nearest(name: str, names: Iterable[str]) -> str:
    """Return the names that are most like ``name``, to go behind what is wrong with it.

    Case does not count. Empty where no name is like it.

    >>> nearest('max_distanse', ['max_distance', 'rate'])
    "; nearest: 'max_distance'"
    """
    given = {each.casefold(): each for each in names}
    found = difflib.get_close_matches(name.casefold()[:200], given, n=_MOST)
    return f'; nearest: {", ".join(repr(given[each]) for each in found)}' if found else ''
