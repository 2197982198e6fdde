"""Entry points of the programs, which end quietly if they are interrupted while importing.

Imports take a second, and much more on a busy machine. An interrupt during an import would leave
a traceback, or be lost in a destructor.
"""

import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

_INTERRUPTED = 130  # exit code, as shells report SIGINT
_STDERR = 2


@contextmanager
def _ending_at_once(code: int, last_words: bytes = b'') -> Iterator[None]:
    """End the process at once on an interrupt within the context, where no work has begun."""

    def leave(number: int, frame: FrameType | None) -> None:
        os.write(_STDERR, last_words)  # unbuffered: the interrupted code may hold the buffer
        os._exit(code)

    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # otherwise it is ignored, as under nohup
        signal.signal(signal.SIGINT, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def drake_geom_ros(arguments: Sequence[str] | None = None, prog: str = 'drake_geom_ros') -> int:
    """Run the command line."""
    with _ending_at_once(_INTERRUPTED, b'drake_geom_ros: interrupted\n'):
        from drake_geom_ros.command_line.program import main
    return main(arguments, prog)


def scene_graph_node() -> int:
    """Run the node."""
    with _ending_at_once(0):  # covers the time before and after the node handles signals
        from drake_geom_ros.ros.scene_graph_node import main

        return main()


def scene_viewer() -> int:
    """Run the viewer page of a node."""
    with _ending_at_once(0):
        from drake_geom_ros.ros.viewer.scene_viewer import main

        return main()


def pose_player() -> int:
    """Run the player of motions."""
    with _ending_at_once(0):
        from drake_geom_ros.ros.pose_player import main

        return main()


def status() -> int:
    """Print the status of a node."""
    with _ending_at_once(_INTERRUPTED):
        from drake_geom_ros.ros.status.program import main

        return main()


def record() -> int:
    """Record a run of a node."""
    with _ending_at_once(_INTERRUPTED):
        from drake_geom_ros.ros.recorder.program import main
    return main()
