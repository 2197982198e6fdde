"""Processes that need a function at the same time: one compiles it, the others wait for it."""

import fcntl
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from numba import config
from numba.core import errors

import drake_geom_ros
from drake_geom_ros.geometry._proximity.runtime import compiled
from drake_geom_ros.geometry._proximity.runtime.cache_folders import CacheFolders

if config.DISABLE_JIT:
    pytest.skip('nothing is compiled', allow_module_level=True)
if compiled.numba_inside is None:
    pytest.skip('of the pinned version of Numba only', allow_module_level=True)

from drake_geom_ros.geometry._proximity.runtime.numba_inside import shared_cache

pytestmark = pytest.mark.processes

ROOT = Path(drake_geom_ros.__file__).parents[1]
# Prints `compiling` and stays in there until it reads a line; prints `waiting` when it does.
SCRIPT = """
import sys
from numba.core import event
from drake_geom_ros.geometry._proximity.runtime.numba_inside.shared_cache import WAITING
from drake_geom_ros.geometry._proximity.kernels.vectors import dot

class Announced(event.Listener):
    def on_start(self, event):
        print('waiting' if event.kind == WAITING else 'compiling', flush=True)
        if event.kind != WAITING:
            sys.stdin.readline()

    def on_end(self, event):
        pass

for kind in ('numba:compile', WAITING):
    event.register(kind, Announced())
assert dot((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == 32.0
stats = dot.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


@pytest.fixture
def start(tmp_path):
    """Return a function that starts SCRIPT with a cache that is empty at first."""
    started = []

    def start():
        env = {**os.environ, 'PYTHONPATH': str(ROOT), 'NUMBA_CACHE_DIR': str(tmp_path)}
        env.pop('DRAKE_GEOM_ROS_COMPILE_LOG', None)  # a killed one's is not compiled twice
        command = [sys.executable, '-c', SCRIPT]
        pipe = subprocess.PIPE
        started.append(subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe, text=True))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


def test_two_processes_that_need_a_function_at_the_same_time_compile_it_once(start):
    first = start()
    assert first.stdout.readline() == 'compiling\n'
    second = start()
    assert second.stdout.readline() == 'waiting\n'
    assert first.communicate('\n')[0] == '0 1\n'
    assert second.communicate('\n')[0] == '1 0\n'


def test_what_a_killed_process_was_compiling_another_one_compiles(start):
    first = start()
    assert first.stdout.readline() == 'compiling\n'
    second = start()
    assert second.stdout.readline() == 'waiting\n'
    first.kill()
    assert second.communicate('\n')[0] == 'compiling\n0 1\n'


@pytest.fixture
def function(tmp_path, monkeypatch):
    """Return a function that is compiled on its first call, with an empty cache."""
    monkeypatch.setattr(shared_cache, 'PATIENCE', 0.0)

    def new():
        def double(x):
            return x + x

        return compiled._compiled(double, folders=CacheFolders(str(tmp_path), ''))

    new.folder = tmp_path
    return new


def lock_files(folder):
    return sorted((folder / 'locks').iterdir())


@contextmanager
def locked(file):
    """Lock a file as another process does."""
    with file.open() as held:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield


def misses_and_saved(dispatcher, folder):
    """Return how often a function was not in its cache, and whether it is now."""
    return sum(dispatcher.stats.cache_misses.values()), bool(list(folder.rglob('*.kernel')))


def test_a_function_that_another_process_never_finishes_is_compiled_and_not_saved(function):
    locks = function.folder / 'locks'
    locks.mkdir()
    first = function()
    file = Path(first._cache.lock.path)
    file.touch()
    with locked(file):
        assert first(2.0) == 4.0
        assert misses_and_saved(first, function.folder) == (1, False)
    second = function()
    assert second(2.0) == 4.0
    assert misses_and_saved(second, function.folder) == (1, True)
    third = function()
    assert third(2.0) == 4.0
    assert misses_and_saved(third, function.folder) == (0, True)


def test_a_process_that_compiles_waits_for_no_other_function(function, monkeypatch):
    """Else two processes could wait for each other."""
    monkeypatch.setattr(shared_cache, 'PATIENCE', 1e9)
    outer, inner = (shared_cache.Lock(function.folder / name) for name in ('outer', 'inner'))
    assert outer.take()
    (function.folder / 'inner').touch()
    with locked(function.folder / 'inner'):
        assert not inner.take()
    outer.release()
    assert inner.take()
    inner.release()


def test_what_fails_to_compile_leaves_no_lock(function):
    dispatcher = function()
    with pytest.raises(errors.TypingError):
        dispatcher(None)
    (file,) = lock_files(function.folder)
    with locked(file):
        pass
    assert dispatcher(2.0) == 4.0
    with locked(file):
        pass


def test_a_folder_without_locks_still_keeps_what_is_compiled(function):
    (function.folder / 'locks').write_text('a file, in which no lock can be made')
    dispatcher = function()
    assert dispatcher(2.0) == 4.0
    assert misses_and_saved(dispatcher, function.folder) == (1, True)


def test_a_file_system_that_has_no_locks_still_keeps_what_is_compiled(function, monkeypatch):
    def refuse(*_):
        raise OSError('no locks available')

    monkeypatch.setattr(shared_cache.fcntl, 'flock', refuse)
    dispatcher = function()
    assert dispatcher(2.0) == 4.0
    assert misses_and_saved(dispatcher, function.folder) == (1, True)
