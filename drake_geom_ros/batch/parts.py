"""Parts of a long batch, in a folder beside its file: one file per finished block."""

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
# A folder with the name of ours may be another's; only ours has this format in its task.
_FORMAT = 'drake_geom_ros parts of a batch 1'
_PART = re.compile(r'[0-9]{12}\.(npz|unfinished)')
# Names of the properties of a task, the most informative first.
_WORDS = {
    'question': 'question',
    'version': 'version of drake_geom_ros',
    'scene': 'scene',
    'states': 'file of states',
    'job': 'choice of joints or frames',
    'blocks': 'division into blocks',
}
_SHOWN = 60  # characters of a value in messages


@contextlib.contextmanager
def _later_interrupt() -> Iterator[None]:
    """Delay Ctrl-C until the end of the block, since inside a zip file it becomes a ValueError.

    Signals reach Python's main thread only, so other threads need no delay. A handler that Python
    did not install (None) could not be restored, so it is left alone.
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


class FinishedParts:
    """Finished blocks of a task, which is identified by all that its answers depend on.

    Each is written beside its place and then moved there, so an existing part is complete.
    """

    def __init__(self, file: Path, task: Mapping[str, Any], blocks: list[Block]) -> None:
        self.folder = file.with_name(file.name + '.parts')
        self._task = {'format': _FORMAT, **task, 'blocks': [list(block) for block in blocks]}
        self.blocks = blocks

    def begin(self, resume: bool, tell: Callable[[str], None] = lambda text: None) -> list[Block]:
        """Return the blocks that are not finished.

        Parts that a crash or a full disk damaged are reported, removed, and computed
        again. Raises BatchError if there are parts without ``resume`` or of another task, and if
        the folder exists and is not one of parts; such a folder is not touched.
        """
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            self.folder.mkdir()
        except FileExistsError:
            there = self._task_there()
        else:
            self._write_task()
            return list(self.blocks)
        finished = sorted(self.folder.glob('*.npz'))
        if not resume and finished:
            raise BatchError(
                f'{self.folder} has parts of an earlier run: go on with --resume, or remove it'
            )
        if there is None:
            tell(
                f'{self.folder / _TASK} is damaged: nobody knows of what the parts are, so all go'
            )
        elif finished and (differences := self._differences(there)):
            raise BatchError(f'{self.folder} is of another {" and of another ".join(differences)}')
        if there is None or not finished:
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
        """Return the names of properties in which the existing task differs from this one."""
        different = [key for key in _WORDS if there.get(key) != self._task.get(key)]
        if set(different) - {'job', 'blocks'}:
            # These two differ whenever another property does.
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
        """Return whether a part exists; a damaged one is reported and removed."""
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
        """Write the answers of a block; Ctrl-C is delayed until they are written."""
        path = self._path(block)
        unfinished = path.with_suffix('.unfinished')
        arrays: dict[str, Any] = dict(columns)
        with _later_interrupt():
            with unfinished.open('wb') as file:
                np.savez(file, **arrays)
                file.flush()
                os.fsync(file.fileno())  # otherwise a power cut may leave an empty file
            os.replace(unfinished, path)

    def get(self, block: Block) -> Columns:
        """Return the answers of a block; raises BatchError for a part that cannot be read."""
        try:
            with np.load(self._path(block)) as file:
                return dict(file)
        except Exception as error:
            # There are many kinds: errors of zip files, of their compression, of arrays.
            reason = ' '.join(str(error).split()) or repr(error)
            raise BatchError(f'{self._path(block)} cannot be read: {reason}') from None

    def remove(self) -> bool:
        """Remove all parts, and the folder if it is empty then; return whether it was."""
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
        """Return the task of the existing folder, None for a damaged one.

        Raises BatchError for a folder that is not one of parts.
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
                'as it is. Give another --out, or remove it'
            )
        return task

    def _path(self, block: Block) -> Path:
        return self.folder / f'{block[0]:012d}.npz'
