"""Files of compiled functions: what was not written to its end counts as missing."""

import os

import pytest
from numba import config

from drake_geom_ros.geometry._proximity.runtime import compiled

if config.DISABLE_JIT:
    pytest.skip('nothing is compiled', allow_module_level=True)
if compiled.numba_inside is None:
    pytest.skip('of the pinned version of Numba only', allow_module_level=True)

from drake_geom_ros.geometry._proximity.runtime.cache_folders import CacheFolders
from drake_geom_ros.geometry._proximity.runtime.numba_inside import kernel_files

CONTENT = b'object code ' * 1000


def test_what_was_written_is_read(tmp_path):
    path = tmp_path / 'new/folder/a.kernel'
    kernel_files.write(path, CONTENT)
    assert kernel_files.read(path) == CONTENT
    kernel_files.write(path, b'')
    assert kernel_files.read(path) == b''
    assert list(path.parent.iterdir()) == [path]


def test_a_file_of_any_other_length_counts_as_missing(tmp_path):
    """A machine that loses power may leave any part of a file, or zeros."""
    path = tmp_path / 'a.kernel'
    assert kernel_files.read(path) is None
    kernel_files.write(path, CONTENT)
    whole = path.read_bytes()
    for broken in (b'', whole[:16], whole[:32], whole[:100], whole[:-1], whole + b'\0'):
        path.write_bytes(broken)
        assert kernel_files.read(path) is None
    path.write_bytes(bytes(len(whole)))
    assert kernel_files.read(path) is None
    path.write_bytes(whole[:500] + bytes([whole[500] ^ 1]) + whole[501:])
    assert kernel_files.read(path) is None


@pytest.mark.processes
def test_a_writer_that_is_killed_leaves_the_file_that_was_there(tmp_path):
    path = tmp_path / 'a.kernel'
    kernel_files.write(path, CONTENT)
    pid = os.fork()
    if not pid:
        kernel_files.os.replace = lambda *_: os.kill(os.getpid(), 9)  # written, and not in place
        kernel_files.write(path, b'other')
        os._exit(0)
    assert os.waitpid(pid, 0)[1] == 9
    assert kernel_files.read(path) == CONTENT
    kernel_files.write(path, b'other')
    assert kernel_files.read(path) == b'other'


def test_what_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(kernel_files.os, 'replace', refuse)
    with pytest.raises(OSError, match='No space left'):
        kernel_files.write(tmp_path / 'a.kernel', CONTENT)
    assert list(tmp_path.iterdir()) == []


def new_function(tmp_path):
    """Return a function that is compiled on its first call, or loaded from a folder."""

    def double(x):
        return x + x

    return compiled._compiled(double, folders=CacheFolders(str(tmp_path), ''))


def test_a_broken_file_is_compiled_and_written_again(tmp_path):
    assert new_function(tmp_path)(2.0) == 4.0
    (path,) = tmp_path.rglob('*.kernel')
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    again = new_function(tmp_path)
    assert again(2.0) == 4.0
    assert sum(again.stats.cache_misses.values()) == 1
    assert kernel_files.read(path) is not None
    assert sum(new_function(tmp_path).stats.cache_misses.values()) == 0


def test_a_full_disk_is_reported_and_no_obstacle(tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(kernel_files, 'write', refuse)
    assert new_function(tmp_path)(2.0) == 4.0
    assert new_function(tmp_path)(3.0) == 6.0
    # Beside it stands how far compiling is, in a process that has compiled for minutes.
    lines = [line for line in capsys.readouterr().err.splitlines() if 'compiling' not in line]
    assert lines == [f'drake_geom_ros: cannot keep kernels in {tmp_path}: No space left on device']
