"""Progress of long work on standard error: how much is done, how fast, how long it will take."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_SECONDS = 1.0  # between two lines


@contextmanager
def progress_bar(unit: str, total: int | None = None) -> Iterator[Callable[[int], None]]:
    """Yield a function that is called with how much is done, of ``total`` where it is known."""
    from tqdm import tqdm  # where something takes long; it costs others 50 ms

    with tqdm(
        total=total, unit=f' {unit}', file=sys.stderr, mininterval=_SECONDS, dynamic_ncols=True
    ) as bar:

        def show(done: int) -> None:
            bar.update(done - bar.n)

        yield show
