"""Recognition of files that were stored in place of the intended ones, such as LFS pointers."""

from __future__ import annotations

_LFS_POINTER = b'version https://git-lfs.github.com/spec/'
_PAGE = (b'<!doctype html', b'<html')


def stand_in(data: bytes) -> str:
    """Return a remark about contents that replace the intended file; empty if none is recognised.

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
