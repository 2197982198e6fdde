"""The program ``record``: writes what a report and its audit need of a run."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_topic_name import validate_topic_name

from drake_geom_ros.common.counting import counted
from drake_geom_ros.program_parser import ProgramParser
from drake_geom_ros.ros.recorder.recorded_topics import topics_of
from drake_geom_ros.ros.recorder.recorder import Recorder
from drake_geom_ros.ros.spinning import StopSignals

INCOMPLETE, MISUSED = 1, 2
_LOOK = 0.1  # [s] between two looks whether to stop


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = ProgramParser(
        description='Records the topics of a scene_graph node that `drake_geom_ros report` needs, '
        'as MCAP, until Ctrl-C. A topic is recorded from its first publisher on.',
    )
    parser.add_argument('--node', default='/scene_graph', help='its full name (%(default)s)')
    parser.add_argument(
        '--out', type=Path, metavar='FOLDER', help='a new folder (run_DATE_TIME where this is)'
    )
    parser.add_argument(
        '--own-tf', action='store_true', help="take /tf and /tf_static of the node's namespace"
    )
    parser.add_argument(
        '--topic', action='append', default=[], metavar='TOPIC', help='record this one as well'
    )
    parser.add_argument('--seconds', type=float, metavar='S', help='stop after so long')
    options = parser.parse_args(words)
    if not options.node.startswith('/'):
        options.node = f'/{options.node}'
    for option, names in (('--node', [options.node]), ('--topic', options.topic)):
        for name in names:
            try:
                validate_topic_name(name)
            except InvalidTopicNameException as error:
                parser.error(f'{option} {name!r}: {" ".join(str(error).split())}')
    if options.seconds is not None and not options.seconds > 0.0:
        parser.error(f'--seconds is {options.seconds:g}; it must be positive')
    options.out = options.out or Path(time.strftime('run_%Y%m%d_%H%M%S'))
    if options.out.exists():
        parser.error(f'--out {options.out} is there already; name a new folder')
    if not options.out.resolve().parent.is_dir():
        parser.error(f'--out {options.out}: there is no folder {options.out.resolve().parent}')
    return options


def main(words: Sequence[str] | None = None) -> int:
    """Record until a signal comes; return 0, or 1 if the recording is empty or incomplete."""
    options = _arguments(sys.argv[1:] if words is None else words)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('record', start_parameter_services=False)
    topics = [*topics_of(options.node, own_tf=options.own_tf), *options.topic]
    recorder = Recorder(node, options.out, topics, warn=_warn)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    end = time.monotonic() + (options.seconds or float('inf'))
    print(f'record: {counted(len(topics), "topic")} to {options.out}; Ctrl-C ends', flush=True)
    with StopSignals(once=True) as signals:
        reported: set[str] = set()
        try:
            while not (signals.received or recorder.failure) and time.monotonic() < end:
                executor.spin_once(timeout_sec=_LOOK)
                for topic in sorted(recorder.heard - reported):
                    print(f'record: {topic}', flush=True)
                    reported.add(topic)
        finally:  # where nobody reads the output any more too
            recorder.close()
    node.destroy_node()
    rclpy.try_shutdown()
    return _report(recorder, options.out)


def _warn(text: str) -> None:
    print(f'drake_geom_ros: {text}', file=sys.stderr, flush=True)


def _report(recorder: Recorder, folder: Path) -> int:
    """Print what was recorded, and warn of topics without a message; return the exit code."""
    for topic in recorder.topics:
        if count := recorder.counts[topic]:
            print(f'{count:9}  {topic}')
    for topic, count in sorted(recorder.lost.items()):
        _warn(f'{counted(count, "message")} of {topic} did not arrive')
    if silent := [topic for topic in recorder.topics if not recorder.counts[topic]]:
        _warn(f'no message of {", ".join(silent)}')
    if recorder.failure is not None:
        _warn(f'stopped, because {folder} cannot be written: {recorder.failure}')
    total = counted(sum(recorder.counts.values()), 'message')
    print(f'record: {total} in {folder}; `drake_geom_ros report {folder} --scene FILE` reads it')
    return 0 if recorder.is_complete else INCOMPLETE
