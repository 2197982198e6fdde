"""Child processes: ended by their pids, and none outlives the process that started it."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from typing import Any

_PR_SET_PDEATHSIG = 1  # linux/prctl.h


def ends_with_parent() -> Callable[[], None] | None:
    """Return a ``preexec_fn`` of Popen: the child gets a signal when its parent dies, however.

    The kernel sends it, so that a parent killed by SIGKILL counts too, and it outlasts ``exec``.
    Strictly it is sent when the thread that started the child ends: start it in one that lasts.
    None where the system is not Linux, which has no such thing.
    """
    if not sys.platform.startswith('linux'):
        return None
    # Between fork and exec of the child there is no safe place to load a library.
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    parent = os.getpid()

    def bind() -> None:
        if prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM), 0, 0, 0):
            raise OSError(ctypes.get_errno(), 'prctl')
        if os.getppid() != parent:  # it died before it was asked for
            os.kill(os.getpid(), signal.SIGTERM)

    return bind


def end(process: subprocess.Popen[Any], grace: float, asked: int = signal.SIGTERM) -> int:
    """Ask a process to end by a signal, kill it after ``grace`` [s]; return its exit code."""
    if process.poll() is None:
        process.send_signal(asked)
        try:
            process.wait(grace)
        except subprocess.TimeoutExpired:
            process.kill()
    return process.wait()
