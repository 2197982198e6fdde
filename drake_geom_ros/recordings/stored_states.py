"""Storage of computed states on disk, which bounds memory and allows a run to be resumed.

Rows are in one file, and another has a line for each block: the digest of the question about it,
the digest of its rows, and names. A block is valid if both digests match, so that half a block,
or one that the disk lost, is computed again.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.results import Facts, RunAnalysis, StateMinima
from drake_geom_ros.recordings.set_clearance import COLUMNS, MOTION_COLUMNS, SetClearance

_ROWS, _BLOCKS, _REQUEST = 'states', 'blocks.jsonl', 'asked.json'
_TIMES = 'times', 'stamps', 'travelled'
_WIDE = 'p_WCa', 'p_WCb'  # of three numbers a state
_TYPES = {'stamps': '<i8', 'left_out': '<i8', 'geometry_A': '<i4', 'geometry_B': '<i4'}
_TYPES |= {'is_stale': '?', 'motion': 'i1'}  # others are '<f8'


class _Line(NamedTuple):
    """Index entry of a block."""

    question: str
    states: int
    rows: str  # their digest
    names: list[list[str]]  # of geometries, by set
    waiting: list[list[str]]  # frames, by set


class StoredStates:
    """A folder with the states of a recording that were computed so far."""

    def __init__(
        self, folder: Path, sets: Sequence[str], request: Mapping[str, Any], *, certified: bool
    ) -> None:
        """Open a folder; contents of another ``request``, a JSON value, are removed."""
        self._folder, self._sets, self._request = folder, list(sets), dict(request)
        columns = (*COLUMNS, *(MOTION_COLUMNS if certified else ()))
        self._columns = columns
        self._dtype = np.dtype(
            [(name, _TYPES.get(name, '<f8')) for name in _TIMES]
            + [
                (f'{name}_{k}', _TYPES.get(name, '<f8'), (3,) if name in _WIDE else ())
                for k in range(len(sets))
                for name in columns
            ]
        )
        self._rows = self._bytes = 0  # length of the valid part of both files
        self._left = self._lines()
        if not self._has_same_request():
            self.remove()

    def find(self, question: str) -> StateMinima | None:
        """Return the states of the next block if they are stored, or None to ``add`` them."""
        line = next(self._left, None)
        if line is not None and line.question == question:
            rows = self._read(self._rows, line.states)
            if _digest(rows) == line.rows:
                self._go_on(line)
                return self._states(rows, line)
        self._left.close()  # later lines do not match the next blocks
        return None

    def add(self, question: str, states: StateMinima) -> None:
        """Store the states of the next block."""
        if not self._folder.exists():
            self._folder.mkdir(parents=True)
            (self._folder / _REQUEST).write_text(json.dumps(self._request), encoding='utf-8')
        rows = np.zeros(len(states.times), dtype=self._dtype)
        for name in _TIMES:
            rows[name] = getattr(states, name)
        for k, name in enumerate(self._sets):
            for column, values in states.sets[name].columns().items():
                rows[f'{column}_{k}'] = values
        pairs = [states.sets[name] for name in self._sets]
        line = _Line(
            question=question,
            states=len(rows),
            rows=_digest(rows),
            names=[list(each.names) for each in pairs],
            waiting=[list(each.waiting_frames) for each in pairs],
        )
        _put(self._folder / _ROWS, self._rows * self._dtype.itemsize, rows.tobytes())
        _put(self._folder / _BLOCKS, self._bytes, _text(line))
        self._go_on(line)

    def parts(self) -> Iterator[StateMinima]:
        """Yield the states of the blocks that were found or added."""
        first = 0
        for line in self._lines():
            if first >= self._rows:
                return
            yield self._states(self._read(first, line.states), line)
            first += line.states

    def remove(self) -> None:
        """Remove all stored states."""
        self._left.close()
        self.remove_from(self._folder)

    @staticmethod
    def remove_from(folder: Path) -> None:
        """Remove a folder of stored states with its files."""
        for name in (_ROWS, _BLOCKS, _REQUEST):
            (folder / name).unlink(missing_ok=True)
        if folder.is_dir():
            folder.rmdir()

    def _go_on(self, line: _Line) -> None:
        self._rows += line.states
        self._bytes += len(_text(line))

    def _has_same_request(self) -> bool:
        try:
            text = (self._folder / _REQUEST).read_text(encoding='utf-8')
            return bool(json.loads(text) == self._request)
        except (OSError, ValueError):
            return False

    def _lines(self) -> Generator[_Line]:
        try:
            with (self._folder / _BLOCKS).open('rb') as file:
                for text in file:
                    yield _Line(**json.loads(text))
        except (OSError, ValueError, TypeError):
            return  # the last line is incomplete

    def _read(self, first: int, count: int) -> NDArray[Any]:
        try:
            return np.fromfile(
                self._folder / _ROWS, self._dtype, count, offset=first * self._dtype.itemsize
            )
        except OSError:
            return np.zeros(0, dtype=self._dtype)

    def _states(self, rows: NDArray[Any], line: _Line) -> StateMinima:
        times = {name: np.ascontiguousarray(rows[name]) for name in _TIMES}
        sets = {
            name: SetClearance(
                name=name,
                times=times['times'],
                names=tuple(line.names[k]),
                waiting_frames=tuple(line.waiting[k]),
                **{n: np.ascontiguousarray(rows[f'{n}_{k}']) for n in self._columns},
            )
            for k, name in enumerate(self._sets)
        }
        return StateMinima(**times, sets=sets)


@dataclass(frozen=True, eq=False)
class StoredClearances(RunAnalysis):
    """Results like ``Clearances``, with states on disk."""

    stored: StoredStates

    @classmethod
    def of(cls, facts: Facts, stored: StoredStates) -> StoredClearances:
        """Return the results of a recording with these facts and states."""
        return cls(
            **{field.name: getattr(facts, field.name) for field in fields(Facts)}, stored=stored
        )

    def parts(self) -> Iterator[StateMinima]:
        """Yield all states, a block at a time."""
        return self.stored.parts()


def _digest(rows: NDArray[Any]) -> str:
    return sha256(rows.tobytes()).hexdigest()


def _text(line: _Line) -> bytes:
    return json.dumps(line._asdict()).encode() + b'\n'


def _put(path: Path, length: int, data: bytes) -> None:
    """Cut a file to ``length`` bytes and append data."""
    with path.open('ab') as file:
        file.truncate(length)
        file.write(data)
