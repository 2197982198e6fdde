"""Marks of tests that may race, and a guard: who starts a process without the mark fails.

``processes``, ``topics`` and ``clock`` are set by hand. The fixtures that hand out a node or a
client imply ``topics``.
"""

from __future__ import annotations

import sys

import pytest

RACY = ('processes', 'topics', 'clock')
NODE_FIXTURES = frozenset({'node', 'client', 'lone_client', 'module_client'})
STARTS = frozenset({'subprocess.Popen', 'os.posix_spawn', 'os.fork', 'os.forkpty'})


class Started:
    """Counts the processes that this one starts, by Python's audit events."""

    def __init__(self):
        self.count = 0
        sys.addaudithook(self._hear)

    def _hear(self, event, _):
        if event in STARTS and not imports():
            self.count += 1


def imports():
    """Return whether a module is being imported: NumPy's ask the system about the processor."""
    frame = sys._getframe()
    while frame is not None:
        if frame.f_code.co_filename.startswith('<frozen importlib'):
            return True
        frame = frame.f_back
    return False


def is_racy(item):
    """Return whether a test has one of the marks."""
    return any(item.get_closest_marker(mark) for mark in RACY)


def pytest_collection_modifyitems(items):
    for item in items:
        if NODE_FIXTURES & set(getattr(item, 'fixturenames', ())):
            item.add_marker('topics')


def pytest_configure(config):
    config.stash[_STARTED] = Started()


_STARTED = pytest.StashKey[Started]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    started = item.config.stash[_STARTED]
    before = started.count
    result = yield
    if started.count > before and not is_racy(item):
        pytest.fail('starts a process and lacks the mark `processes`: see test/plugins/marks.py')
    return result
