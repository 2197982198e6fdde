"""The file that a scene is saved to, on behalf of whoever can call a service.

They may make files that are scenes, and replace those that were made this way: never a script, the
start of a shell, a mesh, or a scene that somebody wrote by hand. No ROS import.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from drake_geom_ros.common.whole_files import open_folder, replaced
from drake_geom_ros.geometry import ArgumentError

SUFFIXES = ('.yaml', '.yml')
MARK = '# Written by save_scene, which may replace this file as long as this line is its first.\n'


class SavedFile:
    """A path whose folder is resolved, and may be written to."""

    def __init__(self, path: Path) -> None:
        """Raise ArgumentError where no scene may be written, before one is made."""
        self._path = path
        if path.suffix not in SUFFIXES:
            raise self._refusal(f'the name of a scene file ends with {" or ".join(SUFFIXES)}')
        with self._folder() as folder:
            self._check(folder)

    def write(self, text: str) -> None:
        """Write the file whole: one who is killed meanwhile leaves what was there before."""
        with self._folder() as folder:
            self._check(folder)
            with replaced(folder, self._path.name) as file:
                file.write(MARK + text)

    @contextlib.contextmanager
    def _folder(self) -> Iterator[int]:
        try:
            folder = open_folder(self._path.parent)
            try:
                yield folder
            finally:
                os.close(folder)
        except OSError as error:
            raise self._refusal(str(error)) from None

    def _check(self, folder: int) -> None:
        """Raise ArgumentError where something is there that is not to be replaced."""
        name = self._path.name
        try:
            there = os.stat(name, dir_fd=folder, follow_symlinks=False)
        except FileNotFoundError:
            return
        if not stat.S_ISREG(there.st_mode):
            kind = 'a folder' if stat.S_ISDIR(there.st_mode) else 'a link, a pipe or a device'
            raise self._refusal(f'what is there is no plain file, but {kind}')
        if not there.st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH):
            raise self._refusal('the file that is there is write-protected')
        flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        descriptor = os.open(name, flags, dir_fd=folder)
        try:
            is_ours = os.read(descriptor, len(MARK)) == MARK.encode()
        finally:
            os.close(descriptor)
        if not is_ours:
            raise self._refusal(
                'the file that is there was not written by save_scene, which begins its files '
                f'with the line {MARK.strip()!r}; give another name, or remove it'
            )

    def _refusal(self, reason: str) -> ArgumentError:
        return ArgumentError(f'the scene cannot be written to {self._path}: {reason}')
