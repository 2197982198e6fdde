"""Errors about libraries that are installed by an extra of this package."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator


@contextlib.contextmanager
def needed_for(what: str, how: str) -> Iterator[None]:
    """Let an import that fails for a missing library say what needs it and how to install it.

    Args:
        what: what needs the library, in the plural, such as ``'data frames'``.
        how: the name of an extra of this package, or a whole sentence for other libraries.

    Raises:
        ImportError: the library that the context imports is missing.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        advice = how if ' ' in how else f"pip install 'drake_geom_ros[{how}]'"
        text = f'{what} need {error.name}, which is not installed: {advice}'
        raise ImportError(text, name=error.name) from None
