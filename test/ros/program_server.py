"""A process that has imported what our programs import, and forks one for each request.

An interpreter that starts anew spends most of a start on imports. The server starts no thread and
opens nothing of ROS, for neither outlives a fork.

``python program_server.py FD`` takes connections from a Unix socket that it inherits. A connection
sends one line of JSON: the program (a function of ``drake_geom_ros.programs``), its arguments,
environment and log file. It receives the process id in one line, and the exit code in another once
the program has ended. The server ends when the socket is closed.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import os
import signal
import socket
import sys
import threading
from pathlib import Path
from typing import Any

from numba.core.registry import cpu_target
from rclpy.type_support import check_for_type_support

import drake_geom_ros.ros.pose_player
import drake_geom_ros.ros.scene_graph_node  # noqa: F401
from drake_geom_ros import programs
from drake_geom_ros.common.children import ends_with_parent
from drake_geom_ros.ros.services.table import SERVICES

ROOT = Path(__file__).resolve().parents[2]


def load_ahead() -> None:
    """Load what every node loads: the types of its services, and what Numba puts off.

    Compiled kernels are left out: a process that was forked with some crashes when it ends.
    """
    for _, kind, _ in SERVICES:
        check_for_type_support(kind)
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()
    gc.collect()
    gc.freeze()  # a search for garbage in a child would copy the memory of all of this
    assert threading.active_count() == 1, threading.enumerate()


def serve(control: socket.socket) -> dict[str, Any]:
    """Take connections; return a request, in the process that is forked for it."""
    # Ctrl-C ends pytest and the programs. One that comes before a program handles it waits.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the kernel buries the supervisors
    while True:
        _, descriptors, *_ = socket.recv_fds(control, 1, 1)
        if not descriptors:
            sys.exit()
        bind = ends_with_parent()
        with socket.socket(fileno=descriptors[0]) as connection:
            if not os.fork():
                bind()
                control.close()
                return supervise(connection)


def supervise(connection: socket.socket) -> dict[str, Any]:
    """Fork the process of a program, which returns; report its id and its exit code."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    with connection.makefile() as lines:
        request = json.loads(lines.readline())
    bind = ends_with_parent()
    if not (pid := os.fork()):
        bind()
        return request
    connection.sendall(f'{pid}\n'.encode())
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    connection.sendall(f'{code}\n'.encode())
    os._exit(0)


def become(program: str, arguments: list[str], environment: dict[str, str], log: str) -> int:
    """Run a program in this process, as if it had been started with all of this."""
    output = os.open(log, os.O_WRONLY)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.close(output)
    faulthandler.enable()  # PYTHONFAULTHANDLER is read at the start of an interpreter
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = [program, *arguments]
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    return getattr(programs, program)()


if __name__ == '__main__':
    load_ahead()
    sys.exit(become(**serve(socket.socket(fileno=int(sys.argv[1])))))
