"""What a long batch has done until now, in a folder beside its file: one file a block."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import stat
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError, Block
from drake_geom_ros.common.whole_files import whole_file

_TASK = 'task.json'
# Of all that may be called as such a folder, only one with this in its task is ours.
_FORMAT = 'drake_geom_ros parts of a batch 1'
_PART = re.compile(r'[0-9]{12}\.(npz|unfinished)')
# What a task depends on, in words; that which tells most comes first.
_WORDS = {
    'question': 'question',
    'version': 'version of drake_geom_ros',
    'scene': 'scene',
    'states': 'file of states',
    'job': 'choice of joints or frames',
    'blocks': 'division into blocks',
}
_SHOWN = 60  # letters of a value


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

    def begin(self, resume: bool, tell: Callable[[str], None] = lambda text: None) -> list[Block]:
        """Return the blocks that are still to be done.

        What a crash or a full disk left damaged is told, dropped, and done again. Raises
        BatchError where parts are there and shall not be gone on with, or are of another task, and
        where a folder is there that is somebody else's: it stays as it is.
        """
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.folder.mkdir()
        except FileExistsError:
            there = self._task_there()
        else:
            self._write_task()
            return list(self.blocks)
        kept = sorted(self.folder.glob('*.npz'))
        if not resume and kept:
            raise BatchError(
                f'{self.folder} has parts of an earlier run: go on with --resume, or remove it'
            )
        if there is None:
            tell(
                f'{self.folder / _TASK} is damaged: nobody knows of what the parts are, so all go'
            )
        elif kept and (told := self._differences(there)):
            raise BatchError(f'{self.folder} is of another {" and of another ".join(told)}')
        if there is None or not kept:
            for path in self.folder.iterdir():
                if path.name == _TASK or _PART.fullmatch(path.name):
                    path.unlink()
            self._write_task()
            return list(self.blocks)
        return [block for block in self.blocks if not self._is_whole(block, tell)]

    def _write_task(self) -> None:
        with whole_file(self.folder / _TASK) as file:
            json.dump(self._task, file)

    def _differences(self, there: Mapping[str, Any]) -> list[str]:
        """Return in words in what the task that is there differs from this one."""
        different = [key for key in _WORDS if there.get(key) != self._task.get(key)]
        if set(different) - {'job', 'blocks'}:
            # These differ with whatever else does.
            different = [key for key in different if key not in ('job', 'blocks')]
        return [
            _WORDS[key]
            + (
                f' ({str(there.get(key))[:_SHOWN]}, not {str(self._task.get(key))[:_SHOWN]})'
                if key in ('question', 'version')
                else ''
            )
            for key in different
        ]

    def _is_whole(self, block: Block, tell: Callable[[str], None]) -> bool:
        """Return whether a part is there; one that is damaged is told and removed."""
        path = self._path(block)
        if not path.exists():
            return False
        try:
            columns = self.get(block)
            first = columns.get('counts', next(iter(columns.values())))
            if len(first) == block[1] - block[0]:
                return True
            reason = f'it has {len(first)} states, not {block[1] - block[0]}'
        except BatchError as error:
            reason = str(error)
        tell(f'{path} is damaged, and done again: {reason}')
        path.unlink()
        return False

    def put(self, block: Block, columns: Columns) -> None:
        """Keep the answers of a block; Ctrl-C comes when they are kept."""
        path = self._path(block)
        unfinished = path.with_suffix('.unfinished')
        arrays: dict[str, Any] = dict(columns)
        with _later_interrupt():
            with unfinished.open('wb') as file:
                np.savez(file, **arrays)
                file.flush()
                os.fsync(file.fileno())  # or a power cut leaves a name without content
            os.replace(unfinished, path)

    def get(self, block: Block) -> Columns:
        """Return the answers of a block; raises BatchError for a part that cannot be read."""
        try:
            with np.load(self._path(block)) as file:
                return dict(file)
        except Exception as error:
            # Of many kinds: of zip files, of their compression, of arrays.
            reason = ' '.join(str(error).split()) or repr(error)
            raise BatchError(f'{self._path(block)} cannot be read: {reason}') from None

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

    def _task_there(self) -> dict[str, Any] | None:
        """Return the task of the folder that is there, None for one that is damaged.

        Raises BatchError for a folder that is not ours.
        """
        task = None
        with contextlib.suppress(OSError):
            if stat.S_ISDIR(self.folder.lstat().st_mode) and (self.folder / _TASK).is_file():
                try:
                    task = json.loads((self.folder / _TASK).read_text())
                except ValueError:
                    names = {path.name for path in self.folder.iterdir()} - {_TASK}
                    if all(map(_PART.fullmatch, names)):
                        return None
        if not isinstance(task, dict) or task.get('format') != _FORMAT:
            raise BatchError(
                f'{self.folder} is there, and no folder of parts that a batch has made: it stays '
                'as it is. Give another --output, or remove it'
            )
        return task

    def _path(self, block: Block) -> Path:
        return self.folder / f'{block[0]:012d}.npz'
