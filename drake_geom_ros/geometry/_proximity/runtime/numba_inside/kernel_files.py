"""Files of compiled functions: complete, or counted as missing.

A process can be killed, a disk can be full and a machine can lose power while a file is written.
So each file begins with a digest of the rest; one that is broken is compiled and written again.
It is written under another name and moved into place, so no process ever reads half of one.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import uuid
from pathlib import Path

_DIGEST = hashlib.sha256
_DIGEST_SIZE = 32  # bytes


def read(path: Path) -> bytes | None:
    """Return the content of a file, or None where it is missing or broken."""
    try:
        whole = path.read_bytes()
    except OSError:
        return None
    digest, content = whole[:_DIGEST_SIZE], whole[_DIGEST_SIZE:]
    return content if _DIGEST(content).digest() == digest else None


def write(path: Path, content: bytes) -> None:
    """Write a file as a whole, and its folder where that is missing; raise OSError on failure."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    unfinished = path.with_name(f'{uuid.uuid4().hex}.part')
    try:
        unfinished.write_bytes(_DIGEST(content).digest() + content)
        os.replace(unfinished, path)
    except OSError:
        with contextlib.suppress(OSError):
            unfinished.unlink()
        raise
