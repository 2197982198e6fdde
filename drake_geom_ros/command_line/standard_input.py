"""The name ``-`` in place of a file: the standard input."""

import sys
from pathlib import Path

STANDARD_INPUT = '-'


def name_of(path: str) -> str:
    """Return the name of a file, or of the standard input, in errors."""
    return 'standard input' if path == STANDARD_INPUT else path


def bytes_of(path: str) -> bytes:
    """Return the content of a file, or of the standard input; raises OSError."""
    if path == STANDARD_INPUT:
        return sys.stdin.buffer.read()
    return Path(path).read_bytes()


def is_json(path: str, text: str) -> bool:
    """Return whether a text is JSON: by the name of its file, or by its first character."""
    if path == STANDARD_INPUT:
        return text.lstrip()[:1] in ('{', '[')
    return Path(path).suffix == '.json'
