"""Tables of texts that a scene gives to a page, such as the ages of sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class TextRow:
    """A row: its cells, whether it is a warning, and the pair (id values) that it is about."""

    cells: Sequence[str]
    warns: bool = False
    pair: tuple[int, int] | None = None


@dataclass(frozen=True)
class TextTable:
    """A table with a title and columns; ``empty`` is the text without rows."""

    title: str
    columns: Sequence[str]
    rows: Sequence[TextRow]
    empty: str = 'none'
