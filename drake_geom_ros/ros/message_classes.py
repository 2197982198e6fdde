"""Classes of messages by the names of their types."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def message_class(kind: str) -> Any:
    """Return the class of a type, ``package/msg/Type`` or ``package/srv/Type``.

    Raises ImportError where its package is not installed, AttributeError where that lacks it.
    """
    package, folder, name = kind.split('/')
    return getattr(import_module(f'{package}.{folder}'), name)
