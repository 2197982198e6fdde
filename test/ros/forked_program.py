"""A program of ours, forked by the program server instead of started anew."""

from __future__ import annotations

import functools
import json
import os
import select
import signal
import socket
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SERVER = Path(__file__).parent / 'program_server.py'
_END = b'\n'


class ForkedProgram:
    """A running program, with the methods of ``subprocess.Popen`` that tests use.

    Its parent is the server, which reports the exit code.
    """

    def __init__(
        self, program: str, arguments: tuple[str, ...], environment: dict[str, str], log: Path
    ) -> None:
        """Start a function of ``drake_geom_ros.programs``, with its output in a file."""
        self.args = [program, *arguments]
        self.returncode: int | None = None
        log.write_text('')
        self._connection, other_end = socket.socketpair()
        with other_end:
            socket.send_fds(program_server(), [b'.'], [other_end.fileno()])
        request = {
            'program': program,
            'arguments': arguments,
            'environment': environment,
            'log': str(log.resolve()),
        }
        self._connection.sendall(json.dumps(request).encode() + _END)
        self.pid = self._number()

    def poll(self) -> int | None:
        """Return the exit code, or None while the program runs."""
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code; raise TimeoutExpired if the program runs longer [s]."""
        if self.returncode is None:
            if not select.select([self._connection], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout)
            self.returncode = self._number()
            self._connection.close()
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless the program has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End the program at once."""
        self.send_signal(signal.SIGKILL)

    def _number(self) -> int:
        """Return the number in the next line of the server."""
        line = b''
        while not line.endswith(_END):
            if not (part := self._connection.recv(1)):
                raise RuntimeError(f'the program server has lost {self.args}')
            line += part
        return int(line)


@functools.cache
def program_server() -> socket.socket:
    """Start a server that ends with this process, and return the socket that it listens to."""
    control, other_end = socket.socketpair()
    paths = [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])]
    with other_end:
        subprocess.Popen(
            [sys.executable, str(SERVER), str(other_end.fileno())],
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(paths)},
            pass_fds=[other_end.fileno()],
        )
    return control
