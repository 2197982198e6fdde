"""Processes of a measurement: Python modules, started here and ended by their own pids."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path
from types import TracebackType

from drake_geom_ros.common.children import end, ends_with_parent

ROOT = Path(__file__).resolve().parents[2]
_GRACE = 20.0  # [s] to end after being asked to


class Processes:
    """Starts modules; all that still run are ended on leaving, or when this process dies."""

    def __init__(self) -> None:
        self._environment = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', **os.environ}
        self._started: list[subprocess.Popen[str]] = []

    def start(self, module: str, *arguments: str, **parameters: object) -> subprocess.Popen[str]:
        """Start ``python -m module``; ``parameters`` are ROS parameters; its output is piped."""
        command = [sys.executable, '-m', module, *arguments]
        if parameters:
            command.append('--ros-args')
            for name, value in parameters.items():
                command += ['-p', f'{name}:={value}']
        process = subprocess.Popen(
            command,
            cwd=ROOT,
            env=self._environment,
            stdout=subprocess.PIPE,
            text=True,
            preexec_fn=ends_with_parent(),
        )
        self._started.append(process)
        return process

    def forget(self, process: subprocess.Popen[str]) -> None:
        """Close what is left of a process that has ended."""
        process.wait()
        process.stdout.close()
        self._started.remove(process)

    def __enter__(self) -> Processes:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for process in reversed(self._started):
            end(process, _GRACE)
            process.stdout.close()


def memory(pid: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def children(pid: int) -> list[int]:
    """Return the processes that one has started."""
    told = []
    for task in Path(f'/proc/{pid}/task').iterdir():
        with contextlib.suppress(FileNotFoundError):  # a thread that has ended since
            told.append(task.joinpath('children').read_text())
    return sorted(int(child) for text in told for child in text.split())


def processor(pid: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
