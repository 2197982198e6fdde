"""What a long batch has done until now, in a folder beside its file: one file a block."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError, Block

_TASK = 'task.json'


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
        self._task = {**task, 'blocks': [list(block) for block in blocks]}
        self.blocks = blocks

    def begin(self, resume: bool) -> list[Block]:
        """Return the blocks that are still to be done.

        Raises BatchError where parts are there and shall not be gone on with, or are of another
        task.
        """
        file = self.folder / _TASK
        if not file.exists():
            self.folder.mkdir(parents=True, exist_ok=True)
            file.write_text(json.dumps(self._task))
            return list(self.blocks)
        if not resume:
            raise BatchError(
                f'{self.folder} has parts of an earlier run: go on with --resume, or remove it'
            )
        there = json.loads(file.read_text())
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

    def remove(self) -> None:
        """Remove all parts."""
        shutil.rmtree(self.folder)

    def _path(self, block: Block) -> Path:
        return self.folder / f'{block[0]:012d}.npz'
