"""Files in memory."""

from __future__ import annotations

import os
from pathlib import Path

# Contents up to this many bytes are printed whole, so that the repr recreates the file.
MOST_PRINTED = 100


class MemoryFile:
    """The contents of a file, its extension, and a name for messages; compared by all three.

    ``contents`` are bytes, or text, which is encoded as UTF-8. ``extension`` is empty or begins
    with a dot, and becomes lower case. ``filename_hint`` names the file to people only. Raises
    RuntimeError for another extension.

        >>> MemoryFile('v 0 0 0', '.OBJ', 'a point').extension()
        '.obj'
    """

    __slots__ = ('_contents', '_extension', '_filename_hint')

    def __init__(
        self, contents: bytes | str = b'', extension: str = '', filename_hint: str = ''
    ) -> None:
        if not isinstance(contents, (bytes, str)):
            raise RuntimeError(f'MemoryFile: contents = {contents!r} must be bytes or text')
        if extension and (not extension.startswith('.') or len(extension) == 1):
            raise RuntimeError(
                f"MemoryFile: extension = {extension!r} must be empty or like '.obj'"
            )
        self._contents = contents.encode() if isinstance(contents, str) else contents
        self._extension = extension.lower()
        self._filename_hint = str(filename_hint)

    @staticmethod
    def Make(path: str | os.PathLike[str]) -> MemoryFile:
        """Return the file at ``path``, read now; raises RuntimeError if it cannot be read."""
        try:
            contents = Path(path).read_bytes()
        except OSError as error:
            raise RuntimeError(f'MemoryFile.Make: {str(path)!r}: {error.strerror}') from None
        return MemoryFile(contents, Path(path).suffix, str(path))

    def contents(self) -> bytes:
        """Return the contents."""
        return self._contents

    def extension(self) -> str:
        """Return the extension, lower case with its dot, or nothing."""
        return self._extension

    def filename_hint(self) -> str:
        """Return the name for messages."""
        return self._filename_hint

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MemoryFile):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[bytes, str, str]:
        return self._contents, self._extension, self._filename_hint

    def __repr__(self) -> str:
        contents = repr(self._contents)
        if len(self._contents) > MOST_PRINTED:
            contents = f'<{self._contents[:MOST_PRINTED]!r}...>'
        return (
            f'MemoryFile(contents={contents}, extension={self._extension!r}, '
            f'filename_hint={self._filename_hint!r})'
        )
