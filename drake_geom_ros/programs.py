"""The programs: each imports what it runs, and is silent where it is told to end meanwhile.

Imports take a second, and much more on a busy machine. An interrupt that came then left a
traceback, or was lost where it hit a destructor.
"""

import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

_INTERRUPTED = 130  # as a shell reports a process that SIGINT ended
_STDERR = 2


@contextmanager
def _ending_at_once(code: int, last_words: bytes = b'') -> Iterator[None]:
    """While entered, an interrupt ends the process: nothing has begun that could be finished."""

    def leave(number: int, frame: FrameType | None) -> None:
        os.write(_STDERR, last_words)  # whose buffer may be in use: this comes at any moment
        os._exit(code)

    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else it is ignored, as under nohup
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
    with _ending_at_once(0):  # before the node handles signals, and again behind it
        from drake_geom_ros.ros.scene_graph_node import main

        return main()


def scene_viewer() -> int:
    """Run the page of a node."""
    with _ending_at_once(0):
        from drake_geom_ros.ros.viewer.scene_viewer import main

        return main()


def pose_player() -> int:
    """Run the player of motions."""
    with _ending_at_once(0):
        from drake_geom_ros.ros.pose_player import main

        return main()


def status() -> int:
    """Tell the status of a node."""
    with _ending_at_once(_INTERRUPTED):
        from drake_geom_ros.ros.status.program import main

        return main()
