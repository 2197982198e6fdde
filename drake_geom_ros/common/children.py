"""Child processes that end with their parent, and the ending of processes by pid."""

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
    """Return a ``preexec_fn`` for Popen that makes the child get a signal when its parent dies.

    The kernel sends it, so that it also works after SIGKILL of the parent, and it survives
    ``exec``. Strictly it is sent when the starting thread ends, so start the child in a lasting
    thread. None on systems other than Linux, which lack this feature.
    """
    if not sys.platform.startswith('linux'):
        return None
    # Loading a library between fork and exec of the child would not be safe.
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    parent = os.getpid()

    def bind() -> None:
        if prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM), 0, 0, 0):
            raise OSError(ctypes.get_errno(), 'prctl')
        if os.getppid() != parent:  # the parent died before the call of prctl
            os.kill(os.getpid(), signal.SIGTERM)

    return bind


def end(process: subprocess.Popen[Any], grace: float, number: int = signal.SIGTERM) -> int:
    """Send a signal to a process, kill it after ``grace`` [s], and return its exit code."""
    if process.poll() is None:
        process.send_signal(number)
        try:
            process.wait(grace)
        except subprocess.TimeoutExpired:
            process.kill()
    return process.wait()
