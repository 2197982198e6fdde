"""Work on long tables piece by piece, so that scratch arrays stay small."""

from __future__ import annotations

from collections.abc import Iterator

PIECE = 1 << 12  # rows


def slices_of(count: int, piece: int = PIECE) -> Iterator[slice]:
    """Yield slices of at most ``piece`` rows that follow one another up to ``count``."""
    for first in range(0, count, piece):
        yield slice(first, min(first + piece, count))
