"""Starts the demo's processes, waits for the one that ends by itself, ends the others by pid."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from drake_geom_ros.common.children import end, ends_with_parent

_POLL = 0.05  # [s]
_GRACE = 10.0  # [s] to end after being asked to
_LOG_LINES = 12


class ProcessFailedError(RuntimeError):
    """A process ended too early or with an error; the text names it and quotes its log."""


@dataclass
class _Started:
    process: subprocess.Popen[bytes]
    log: Path | None


class ProcessGroup:
    """Child processes with names; each runs in a session of its own, so that only we end it.

    As a context manager it ends every process that still runs, the one started last first. Where
    this process is killed they end too.
    """

    def __init__(self, environment: dict[str, str]):
        self._environment = environment
        self._started: dict[str, _Started] = {}

    def start(self, name: str, module: str, *arguments: str, log: Path | None = None) -> None:
        """Start ``python -m module arguments``; its output goes to ``log``, or where ours goes."""
        command = [sys.executable, '-m', module, *arguments]
        with contextlib.ExitStack() as opened:
            output = None if log is None else opened.enter_context(log.open('wb'))
            process = subprocess.Popen(
                command,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=None if output is None else subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=ends_with_parent(),
            )
        self._started[name] = _Started(process, log)

    def wait_for(self, name: str) -> None:
        """Return when the process has ended with exit code 0.

        Raises ProcessFailedError when it ends with another one, or when a different one ends
        first. A KeyboardInterrupt is passed on to it, so that it can finish what it does.
        """
        process = self._started[name].process
        while process.poll() is None:
            try:
                time.sleep(_POLL)
                for other, started in self._started.items():
                    if other != name and started.process.poll() is not None:
                        raise self._failure(other)
            except KeyboardInterrupt:
                process.send_signal(signal.SIGINT)
                process.wait()
        if process.returncode != 0:
            raise self._failure(name)

    def _failure(self, name: str) -> ProcessFailedError:
        started = self._started[name]
        text = f'{name} (pid {started.process.pid}) ended with exit code {started.process.poll()}'
        if started.log is not None:
            lines = started.log.read_text(encoding='utf-8', errors='replace').splitlines()
            text += f'; the end of {started.log}:\n' + '\n'.join(lines[-_LOG_LINES:])
        return ProcessFailedError(text)

    def __enter__(self) -> 'ProcessGroup':
        return self

    def __exit__(self, *exception: object) -> None:
        for started in reversed(self._started.values()):
            end(started.process, _GRACE)


def ros_environment() -> dict[str, str]:
    """Return our environment, with localhost discovery and a domain id unless they are set.

    The id is 1 to 101: the ports of higher ones overlap with those the system hands out.
    """
    environment = dict(os.environ)
    environment.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    environment.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 101))
    environment['PYTHONUNBUFFERED'] = '1'
    return environment
