"""Atomic writing of files, and checks that outputs do not overwrite inputs."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

_ONLY_FOLDERS = os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC
# No space, no quota, a file too large, a broken disk.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC


@contextlib.contextmanager
def whole_file(path: str | Path, mode: str = 'w', newline: str | None = None) -> Iterator[Any]:
    """Yield a file that replaces ``path`` when the context exits without an error.

    ``mode`` is ``'w'`` (UTF-8) or ``'wb'``. Until then, and after an error, an existing file is
    unchanged. A link is followed, and the permissions of a replaced file are preserved. If the
    path is no plain file, such as a terminal or a pipe, it is written directly. Raises OSError.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        encoding = None if 'b' in mode else 'utf-8'
        with _naming(path), target.open(mode, newline=newline, encoding=encoding) as file:
            yield file
        return
    try:
        folder = os.open(target.parent, _ONLY_FOLDERS)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        with _naming(path), replaced(folder, target.name, mode, newline) as file:
            yield file
    finally:
        os.close(folder)


@contextlib.contextmanager
def _naming(path: str | Path) -> Iterator[None]:
    """Let an error of a file in here name it: one of writing, as on a full disk, names none."""
    try:
        yield
    except OSError as error:
        if error.filename is None and error.errno in _FULL:
            error.filename = str(path)
        raise


@contextlib.contextmanager
def replaced(folder: int, name: str, mode: str = 'w', newline: str | None = None) -> Iterator[Any]:
    """Yield a file like ``whole_file`` for a name in an open folder, without following links.

    The unfinished file has a random new name, which nobody can have prepared.
    """
    part = f'.{secrets.token_hex(8)}.part'
    descriptor = os.open(part, _NEW, 0o666, dir_fd=folder)
    try:
        encoding = None if 'b' in mode else 'utf-8'
        with open(descriptor, mode, newline=newline, encoding=encoding) as file:
            yield file
            file.flush()
            with contextlib.suppress(FileNotFoundError):
                before = os.stat(name, dir_fd=folder, follow_symlinks=False)
                if stat.S_ISREG(before.st_mode):
                    os.fchmod(file.fileno(), stat.S_IMODE(before.st_mode))
            # Without fsync a power loss could leave the new name with an empty file.
            os.fsync(file.fileno())
        os.replace(part, name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(part, dir_fd=folder)
        raise


def open_folder(path: Path) -> int:
    """Return a descriptor of a folder by its resolved path, which the caller must close.

    No part of the path may be a link, so that a part that was replaced by a link since it was
    resolved is refused. Raises OSError.
    """
    first, *names = path.parts
    folder = os.open(first, _ONLY_FOLDERS)
    for name in names:
        above = folder
        try:
            folder = os.open(name, _ONLY_FOLDERS | os.O_NOFOLLOW, dir_fd=above)
        finally:
            os.close(above)
    return folder


def check_outputs(
    outputs: Mapping[str, str | Path | None], inputs: Iterable[str | Path | None]
) -> None:
    """Raise FileExistsError if an output, by its option, is an input or another output.

    Files are compared by identity, also through links. Empty paths and None are ignored.
    """
    input_paths = [Path(path) for path in inputs if path]
    written: list[tuple[str, Path]] = []
    for option, path in outputs.items():
        if not path:
            continue
        for read in input_paths:
            if _same(Path(path), read):
                raise FileExistsError(
                    f'{option} {path} is the file {read} that is read: it would be written over; '
                    'give another name'
                )
        for other, other_path in written:
            if _same(Path(path), other_path):
                raise FileExistsError(f'{option} and {other} are the same file, {path}')
        written.append((option, Path(path)))


def check_first_line(path: Path, first: str) -> None:
    """Raise FileExistsError if a file exists whose first line differs, and so is not ours."""
    if not os.path.lexists(path):
        return
    with contextlib.suppress(OSError, UnicodeDecodeError), path.open(encoding='utf-8') as file:
        if file.readline().rstrip('\r\n') == first:
            return
    raise FileExistsError(
        f'{path} is there, and not written by this command, which would replace it: give another '
        'folder, or move it away'
    )


def _same(a: Path, b: Path) -> bool:
    """Return whether two paths are of one file, existing or not."""
    try:
        # Sharing a terminal or the null device is fine.
        return os.path.samefile(a, b) and a.is_file()
    except OSError:
        return os.path.realpath(a) == os.path.realpath(b)
