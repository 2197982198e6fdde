"""Freeing many objects in pieces, so that other threads run in between.

Python frees all that only one object refers to in one go, and holds its interpreter's lock
meanwhile: of a scene of 4000 bodies for 10 ms and more, in which no cycle begins.
"""

from __future__ import annotations

from typing import Any


def free_in_pieces(objects: list[Any]) -> None:
    """Free a list of objects one by one, as far as nothing else refers to them."""
    while objects:
        objects.pop()
