"""What a long batch has done until now, in a folder beside its file: one file a block."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import stat
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError, Block
from drake_geom_ros.common.whole_files import whole_file

_TASK = 'task.json'
# Of all that may be called as such a folder, only one with this in its task is ours.
_FORMAT = 'drake_geom_ros parts of a batch 1'


@contextlib.contextmanager
def _later_interrupt() -> Iterator[None]:
    """Let Ctrl-C come after what is done within: from within a zip file it is a ValueError.

    Signals reach Python's main thread alone, so elsewhere nothing needs to wait; a handler that
    Python did not install (None) could not be put back.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


class Parts:
    """The blocks that are done of a task, which is named by what its answers depend on.

    Each is written beside its place and then put there: one that is there is whole.
    """

    def __init__(self, file: Path, task: Mapping[str, Any], blocks: list[Block]) -> None:
        self.folder = file.with_name(file.name + '.parts')
        self._task = {'format': _FORMAT, **task, 'blocks': [list(block) for block in blocks]}
        self.blocks = blocks

    def begin(self, resume: bool) -> list[Block]:
        """Return the blocks that are still to be done.

        Raises BatchError where parts are there and shall not be gone on with, or are of another
        task, and where a folder is there that is somebody else's: it stays as it is.
        """
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.folder.mkdir()
        except FileExistsError:
            there = self._task_there()
        else:
            with whole_file(self.folder / _TASK) as file:
                json.dump(self._task, file)
            return list(self.blocks)
        if not resume:
            raise BatchError(
                f'{self.folder} has parts of an earlier run: go on with --resume, or remove it'
            )
        for key, value in self._task.items():
            if there.get(key) != value:
                raise BatchError(
                    f'{self.folder} is of another {key}: {str(there.get(key))[:80]}, '
                    f'not {str(value)[:80]}'
                )
        return [block for block in self.blocks if not self._path(block).exists()]

    def put(self, block: Block, columns: Columns) -> None:
        """Keep the answers of a block; Ctrl-C comes when they are kept."""
        path = self._path(block)
        unfinished = path.with_suffix('.unfinished')
        arrays: dict[str, Any] = dict(columns)
        with _later_interrupt():
            with unfinished.open('wb') as file:
                np.savez(file, **arrays)
            os.replace(unfinished, path)

    def get(self, block: Block) -> Columns:
        """Return the answers of a block."""
        with np.load(self._path(block)) as file:
            return dict(file)

    def remove(self) -> bool:
        """Remove all parts, and the folder unless it holds what is not ours; return whether."""
        for block in self.blocks:
            self._path(block).unlink(missing_ok=True)
            self._path(block).with_suffix('.unfinished').unlink(missing_ok=True)
        (self.folder / _TASK).unlink(missing_ok=True)
        try:
            self.folder.rmdir()
        except OSError:
            return False
        return True

    def _task_there(self) -> dict[str, Any]:
        """Return the task of the folder that is there; raises BatchError where it is not ours."""
        task = None
        with contextlib.suppress(OSError, ValueError):
            if stat.S_ISDIR(self.folder.lstat().st_mode) and (self.folder / _TASK).is_file():
                task = json.loads((self.folder / _TASK).read_text())
        if not isinstance(task, dict) or task.get('format') != _FORMAT:
            raise BatchError(
                f'{self.folder} is there, and no folder of parts that a batch has made: it stays '
                'as it is. Give another --output, or remove it'
            )
        return task

    def _path(self, block: Block) -> Path:
        return self.folder / f'{block[0]:012d}.npz'
