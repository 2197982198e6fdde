"""Entry points of the programs, which end quietly if they are interrupted while importing.

Imports take a second, and much more on a busy machine. An interrupt during an import would leave
a traceback, or be lost in a destructor.
"""

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from types import FrameType
from typing import ParamSpec

from drake_geom_ros.command_line.exit_codes import BAD_INPUT, INTERRUPTED, READER_LEFT

_Arguments = ParamSpec('_Arguments')

_PACKAGES_OF_ROS = ('rclpy', 'drake_geom_msgs')
# Other packages that programs import at their start, and the extra that brings each.
_EXTRAS = {'matplotlib': 'demo', 'mcap': 'recordings', 'rosbags': 'recordings'}
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


@contextmanager
def _importing() -> Iterator[None]:
    """Have Python look for no garbage among what is imported: it stays.

    Those searches, and one more at exit, took a sixth of the time of a program that answers once.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if was_enabled:
            gc.enable()


def _until_the_reader_leaves(program: Callable[_Arguments, int]) -> Callable[_Arguments, int]:
    """Return a program that ends quietly when a pipe that reads its output is closed."""

    @wraps(program)
    def run(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> int:
        try:
            try:
                return program(*args, **kwargs)
            finally:  # argparse ends the process after printing a help
                sys.stdout.flush()
                gc.freeze()  # the process ends: its garbage needs no search
        except BrokenPipeError:
            # Python flushes once more at exit, so give it another file.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return READER_LEFT

    return run


@_until_the_reader_leaves
def drake_geom_ros(arguments: Sequence[str] | None = None, prog: str = 'drake_geom_ros') -> int:
    """Run the command line: a command of ``command_line``, or a program that uses ROS 2."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in _OF_ROS:
        return _run_program_of_ros(words[0], words[1:])
    with _ending_at_once(INTERRUPTED, b'drake_geom_ros: interrupted\n'), _importing():
        from drake_geom_ros.command_line.program import load, main

        load(words)
    return main(words, prog, {name: words for name, (words, _) in _OF_ROS.items()})


def _run_program_of_ros(name: str, words: Sequence[str]) -> int:
    """Run ``node``, ``status`` and so on, which read ``sys.argv``; exit code 2 for bad input."""
    arguments = list(words)
    if name == 'node' and words and not words[0].startswith('-'):
        scene, *others = words
        if not Path(scene).is_file():
            return _refuse(f'{scene}: there is no such scene file')
        arguments = ['--ros-args', '-p', f'scene_file:={scene}', '--', *others]
    sys.argv = [f'drake_geom_ros {name}', *arguments]
    try:
        return _OF_ROS[name][1]()
    except ModuleNotFoundError as error:
        package = (error.name or '').partition('.')[0]
        if package in _PACKAGES_OF_ROS:
            return _refuse(
                f'{name} needs ROS 2, and there is no {package} here: source the setup file of a '
                "ROS 2 distribution, or pip install 'drake_geom_ros[kilted]' (or jazzy)"
            )
        if package in _EXTRAS:
            extra = _EXTRAS[package]
            return _refuse(f"{name} needs {package}: pip install 'drake_geom_ros[{extra}]'")
        raise


def _refuse(reason: str) -> int:
    print(f'drake_geom_ros: {reason}', file=sys.stderr)
    return BAD_INPUT


@_until_the_reader_leaves
def scene_graph_node() -> int:
    """Run the node."""
    with _ending_at_once(0):  # covers the time before and after the node handles signals
        with _importing():
            from drake_geom_ros.ros.scene_graph_node import main

        return main()


@_until_the_reader_leaves
def scene_viewer() -> int:
    """Run the viewer page of a node."""
    with _ending_at_once(0):
        with _importing():
            from drake_geom_ros.ros.viewer.scene_viewer import main

        return main()


@_until_the_reader_leaves
def pose_player() -> int:
    """Run the player of motions."""
    with _ending_at_once(0):
        with _importing():
            from drake_geom_ros.ros.pose_player import main

        return main()


@_until_the_reader_leaves
def status() -> int:
    """Print the status of a node."""
    with _ending_at_once(INTERRUPTED):
        with _importing():
            from drake_geom_ros.ros.status.program import main

        return main()


@_until_the_reader_leaves
def record() -> int:
    """Record a run of a node."""
    with _ending_at_once(INTERRUPTED), _importing():
        from drake_geom_ros.ros.recorder.program import main
    return main()


@_until_the_reader_leaves
def demo() -> int:
    """Run the demo: a node, a player of two arms, and a client."""
    with _ending_at_once(INTERRUPTED), _importing():
        from drake_geom_ros.ros.demo.program import main
    return main()


# Commands of `drake_geom_ros` besides those of `command_line`: what they are, and their programs.
_OF_ROS: dict[str, tuple[str, Callable[[], int]]] = {
    'node': ('run the node (ROS 2); a scene file may follow', scene_graph_node),
    'status': ('what a running node has and does (ROS 2)', status),
    'viewer': ('the page in the browser of a running node (ROS 2)', scene_viewer),
    'player': ('publish the poses of a motion (ROS 2)', pose_player),
    'demo': ('two arms above a table, a node and its client, shown (ROS 2)', demo),
    'record': ('record what a report needs of a running node (ROS 2)', record),
}
