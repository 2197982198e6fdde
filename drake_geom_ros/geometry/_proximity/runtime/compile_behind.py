"""Compilation for this CPU by a child of low priority, while kernels for any CPU answer.

``DRAKE_GEOM_ROS_COMPILE`` says what is done where the package brings kernels for any CPU and there
are none for this one: ``behind`` (the default) uses them and starts the child, whose kernels the
next process uses; ``never`` uses them and starts none; ``first`` compiles before it answers. What
the package brings no kernel for is compiled when it is needed, in any case.
"""

from __future__ import annotations

import enum
import fcntl
import functools
import hashlib
import os
import subprocess
import sys
import threading
from pathlib import Path

from drake_geom_ros.geometry._proximity.runtime.sources import PACKAGE

VARIABLE = 'DRAKE_GEOM_ROS_COMPILE'
_LOWEST = 19  # nice
# The package by its place: the child may be started from anywhere.
_CODE = """
import sys
sys.path.insert(0, sys.argv[1])
from drake_geom_ros.every_kernel import compile_every_kernel
compile_every_kernel()
open(sys.argv[2], 'w').close()
"""


class Mode(enum.Enum):
    """The values of ``DRAKE_GEOM_ROS_COMPILE``."""

    NEVER = 'never'
    BEHIND = 'behind'
    FIRST = 'first'


@functools.cache
def mode() -> Mode:
    """Return the mode that the environment asks for; report a value that is none."""
    value = os.environ.get(VARIABLE) or Mode.BEHIND.value
    try:
        return Mode(value)
    except ValueError:
        allowed = ', '.join(each.value for each in Mode)
        print(
            f'drake_geom_ros: {VARIABLE} is {value!r}, not one of {allowed} '
            f'(docs/installation.md); taken as {Mode.BEHIND.value}',
            file=sys.stderr,
        )
        return Mode.BEHIND


@functools.cache  # once a process
def compile_behind(folder: str, machine: tuple[str, ...]) -> None:
    """Start the child, unless it did its work, is at it, or is not wanted.

    Args:
        folder: the cache of the user, empty where none can be written.
        machine: how Numba describes this CPU.
    """
    if mode() is not Mode.BEHIND or not folder or not sys.executable:
        return
    done = Path(folder) / f'compiled-{hashlib.sha256(repr(machine).encode()).hexdigest()[:16]}'
    if done.exists():
        return
    try:
        with open(Path(folder) / 'behind.lock', 'w') as lock:
            # The child inherits the lock and holds it until it ends, however it does.
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            child = _start(Path(folder) / 'behind.log', str(done), lock.fileno())
    except OSError:  # another process has started one, or no more can be started
        return
    print(
        'drake_geom_ros: kernels for any CPU answer; those for this one are compiled beside, '
        f'once, by process {child.pid} of low priority ({VARIABLE}=never: not at all)',
        file=sys.stderr,
        flush=True,
    )
    threading.Thread(target=child.wait, name='compile behind', daemon=True).start()


def _start(log: Path, done: str, lock: int) -> subprocess.Popen[bytes]:
    """Start the child in a session of its own, which outlives this process."""
    with open(log, 'wb') as output:
        child = subprocess.Popen(
            [sys.executable, '-c', _CODE, str(PACKAGE.parent), done],
            env={**os.environ, VARIABLE: Mode.FIRST.value},
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            start_new_session=True,
            pass_fds=[lock],
        )
    os.setpriority(os.PRIO_PROCESS, child.pid, _LOWEST)
    return child
