"""Rows of three numbers in scene files, listed or packed as base64."""

from __future__ import annotations

from base64 import b64decode
from typing import Any

import numpy as np


def numbers_of(plain: Any, kind: str) -> Any:
    """Return rows (n, 3) that are listed, or packed as base64; ValueError for invalid text."""
    if not isinstance(plain, str):
        return plain
    try:
        return np.frombuffer(b64decode(plain, validate=True), kind).reshape(-1, 3)
    except ValueError as error:
        raise ValueError(f'rows of three {kind} are packed as base64: {error}') from None
