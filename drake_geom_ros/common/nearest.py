"""Suggestions for misspelt names."""

import difflib
from collections.abc import Iterable

_MOST = 3


def nearest(name: str, names: Iterable[str]) -> str:
    """Return a clause with the names most similar to ``name``, to append to an error text.

    Case is ignored. Empty if no name is similar.

    >>> nearest('max_distanse', ['max_distance', 'rate'])
    "; nearest: 'max_distance'"
    """
    folded = {each.casefold(): each for each in names}
    similar = difflib.get_close_matches(name.casefold()[:200], folded, n=_MOST)
    return f'; nearest: {", ".join(repr(folded[each]) for each in similar)}' if similar else ''
