"""The file that a scene is saved to, on behalf of whoever can call a service.

They may make files that are scenes, and replace those that were made this way: never a script, the
start of a shell, a mesh, or a scene that somebody wrote by hand.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from drake_geom_ros.common.whole_files import open_folder, replaced
from drake_geom_ros.geometry import ArgumentError

MARK = '# Written by save_scene, which may replace this file as long as this line is its first.\n'


class FileKind(NamedTuple):
    """A kind of file: its name and its suffixes, and what those of a service begin with."""

    name: str
    suffixes: tuple[str, ...]
    service: str
    first: bytes  # lines that the format wants first
    mark: bytes  # the line behind, by which they are known


SCENE_FILE = FileKind(
    'scene',
    ('.yaml', '.yml'),
    'save_scene',
    b'',
    MARK.encode(),
)
MAP_FILE = FileKind(
    'map',
    ('.bt',),
    'save_obstacles',
    b'# Octomap OcTree binary file\n',
    b'# Written by save_obstacles, which may replace this file as long as this is line 2.\n',
)


class SavedFile:
    """A path whose folder is resolved, and may be written to."""

    def __init__(self, path: Path, kind: FileKind = SCENE_FILE) -> None:
        """Raise ArgumentError where no file may be written, before one is made."""
        self._path, self._kind = path, kind
        if path.suffix not in kind.suffixes:
            suffixes = ' or '.join(kind.suffixes)
            raise self._refusal(f'the name of a {kind.name} file ends with {suffixes}')
        with self._folder() as folder:
            self._check(folder)

    def write(self, content: bytes) -> None:
        """Write the file whole: one who is killed meanwhile leaves what was there before."""
        first, mark = self._kind.first, self._kind.mark
        with self._folder() as folder:
            self._check(folder)
            with replaced(folder, self._path.name, 'wb') as file:
                file.write(first + mark + content.removeprefix(first))

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
            begin = self._kind.first + self._kind.mark
            is_ours = os.read(descriptor, len(begin)) == begin
        finally:
            os.close(descriptor)
        if not is_ours:
            raise self._refusal(
                f'the file that is there was not written by {self._kind.service}, which begins '
                f'its files with the line {self._kind.mark.decode().strip()!r}; give another '
                'name, or remove it'
            )

    def _refusal(self, reason: str) -> ArgumentError:
        return ArgumentError(f'the {self._kind.name} cannot be written to {self._path}: {reason}')
