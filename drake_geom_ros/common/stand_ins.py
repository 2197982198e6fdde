"""Files that stand where another one was meant to be: what they are, and what to do."""

from __future__ import annotations

_LFS_POINTER = b'version https://git-lfs.github.com/spec/'
_PAGE = (b'<!doctype html', b'<html')


def stand_in(data: bytes) -> str:
    """Return what is there in the place of a file, in words; empty where nothing is known to be.

    >>> stand_in(b'')
    'it is empty'
    """
    if not data:
        return 'it is empty'
    if data.startswith(_LFS_POINTER):
        return 'it is a Git LFS pointer, not the file itself: run `git lfs pull` where it lies'
    if data[:100].lstrip().lower().startswith(_PAGE):
        return 'it is a web page, not the file itself: download the raw file'
    return ''
