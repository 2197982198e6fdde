"""``FileRows``: rows of a .npy file, read block by block, with detection of changes."""

from __future__ import annotations

import hashlib
import os
import weakref
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import SceneFileError

_PIECE = 1024  # rows that are hashed, and so read, at once: memory stays flat


class FileRows:
    """The rows of a file of doubles, in C order; indexing by a slice reads them.

    Slices are copies and not a memory map, because truncation of a mapped file kills the process
    that reads it. The whole file is read and hashed once; a piece with another hash later has been
    overwritten. Time stamps of files are too coarse for this: the kernel's ticks.
    """

    dtype = np.dtype(np.float64)

    def __init__(self, path: Path, descriptor: int, shape: tuple[int, ...], offset: int) -> None:
        """Read the file once; raises OSError, and SceneFileError for a file that is too short.

        This object takes ownership of the descriptor.
        """
        self._descriptor = descriptor
        weakref.finalize(self, os.close, descriptor)
        self.shape, self.ndim, self._path, self._offset = shape, len(shape), path, offset
        self._bytes = int(np.prod(shape[1:], dtype=np.int64)) * self.dtype.itemsize  # of a row
        self._hashes = [
            _hash(self._read(first, min(first + _PIECE, len(self))))
            for first in range(0, len(self), _PIECE)
        ]
        self.digest = hashlib.sha256(b''.join([repr(shape).encode(), *self._hashes])).hexdigest()

    @staticmethod
    def of(path: Path) -> FileRows | None:
        """Return the rows of a file, None unless it has doubles in C order.

        Raises OSError, and ValueError unless it is a .npy file.
        """
        with path.open('rb') as file:
            version = npy.read_magic(file)
            if version not in ((1, 0), (2, 0)):
                return None
            read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
            shape, is_fortran, dtype = read(file)
            if dtype != np.float64 or len(shape) < 2 or is_fortran:
                return None
            return FileRows(path, os.dup(file.fileno()), shape, file.tell())

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: slice) -> Floats:
        """Return rows in a new array; raises SceneFileError if the file has changed."""
        first, last, step = rows.indices(len(self))
        if step != 1:
            raise IndexError(f'{rows}: rows are read one after the other')
        begin, end = first // _PIECE * _PIECE, min(-(-last // _PIECE) * _PIECE, len(self))
        pieces = self._read(begin, end)
        for piece in range(begin, end, _PIECE):
            if (
                _hash(pieces[piece - begin : piece - begin + _PIECE])
                != self._hashes[piece // _PIECE]
            ):
                raise self._changed()
        return pieces[first - begin : last - begin]

    def _read(self, first: int, last: int) -> Floats:
        wanted = max(0, last - first) * self._bytes
        buffer = bytearray(wanted)
        view, at = memoryview(buffer), 0
        while at < wanted:
            # With an explicit offset, since several threads read at once.
            count = os.preadv(
                self._descriptor, [view[at:]], self._offset + first * self._bytes + at
            )
            if count == 0:
                raise self._changed()
            at += count
        return np.frombuffer(buffer, dtype=self.dtype).reshape(
            max(0, last - first), *self.shape[1:]
        )

    def _changed(self) -> SceneFileError:
        return SceneFileError(
            'the file of states was written over, or cut short, while it was read: what was '
            'answered would be of old and of new ones. Begin anew, on a file that stays',
            str(self._path),
        )


def _hash(rows: Floats) -> bytes:
    return hashlib.sha256(rows.data).digest()
