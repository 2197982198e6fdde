"""Entry points of the programs, which end quietly if they are interrupted while importing.

Imports take a second, and much more on a busy machine. An interrupt during an import would leave
a traceback, or be lost in a destructor.
"""

import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from drake_geom_ros.command_line.exit_codes import BAD_INPUT, INTERRUPTED

_PACKAGES_OF_ROS = ('rclpy', 'drake_geom_msgs', 'ament_index_python')
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
    """Run the command line: a command of ``command_line``, or a program that uses ROS 2."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in _OF_ROS:
        return _run_program_of_ros(words, prog)
    with _ending_at_once(INTERRUPTED, b'drake_geom_ros: interrupted\n'):
        from drake_geom_ros.command_line.program import load, main

        load(words)
    return main(words, prog, {name: words for name, (words, _) in _OF_ROS.items()})


def _run_program_of_ros(words: Sequence[str], prog: str) -> int:
    """Run ``node``, ``status`` and so on, which read ``sys.argv``; exit code 2 without ROS 2."""
    name, rest = words[0], list(words[1:])
    if name == 'node':
        rest = _with_scene_parameter(rest)
    sys.argv = [f'{prog} {name}', *rest]
    try:
        return _OF_ROS[name][1]()
    except ModuleNotFoundError as error:
        if (error.name or '').partition('.')[0] not in _PACKAGES_OF_ROS:
            raise
        print(
            f'drake_geom_ros: {name} needs ROS 2, and there is no {error.name} here: source the '
            'setup file of a ROS 2 distribution, or see docs/installation.md',
            file=sys.stderr,
        )
        return BAD_INPUT


def _with_scene_parameter(words: Sequence[str]) -> list[str]:
    """Return the arguments of a node in which a file that comes first is its scene file."""
    if not words or words[0].startswith('-'):
        return list(words)
    return ['--ros-args', '-p', f'scene_file:={words[0]}', '--', *words[1:]]


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
    with _ending_at_once(INTERRUPTED):
        from drake_geom_ros.ros.status.program import main

        return main()


def record() -> int:
    """Record a run of a node."""
    with _ending_at_once(INTERRUPTED):
        from drake_geom_ros.ros.recorder.program import main
    return main()


# Commands of `drake_geom_ros` besides those of `command_line`: what they are, and their programs.
_OF_ROS: dict[str, tuple[str, Callable[[], int]]] = {
    'node': ('run the node (ROS 2); a scene file may follow', scene_graph_node),
    'status': ('what a running node has and does (ROS 2)', status),
    'viewer': ('the page in the browser of a running node (ROS 2)', scene_viewer),
    'player': ('publish the poses of a motion (ROS 2)', pose_player),
    'record': ('record what a report needs of a running node (ROS 2)', record),
}
