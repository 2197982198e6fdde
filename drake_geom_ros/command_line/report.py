"""Command ``report``: clearances of a ROS recording, as tables, a plot and a page."""

import argparse
import math
import sys
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.exit_codes import (
    BAD_INPUT,
    DONE,
    NEARER,
    NO,
    NOT_PROVED,
    UNFORESEEN,
    print_unforeseen,
)
from drake_geom_ros.command_line.option_values import count_or_zero, distance, finite, positive
from drake_geom_ros.command_line.pairs_between import add_between_to
from drake_geom_ros.command_line.recording_input import add_topics_to
from drake_geom_ros.command_line.report_making import THRESHOLDS, make_report
from drake_geom_ros.command_line.scene_input import read_and_warn
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.recordings.comparing import WAYS
from drake_geom_ros.recordings.recording_files import runs_in
from drake_geom_ros.recordings.report import PAGE
from drake_geom_ros.recordings.run import STALE_AFTER
from drake_geom_ros.recordings.tolerances import CERTIFIED, NEARER_BY

_BY_GRAVITY = NOT_PROVED, NEARER, UNFORESEEN, BAD_INPUT, NO, DONE


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'report',
        description='Plays a recording as a node would have taken it, computes the least '
        'distances over its time, and writes clearance.csv, clearance.npz, clearance.png and '
        'report.html. Exit code 0: every state tells of all pairs; 1: something is stale, left '
        'out, damaged, missing or not reproducible, which is said on standard output; 2: what was '
        'asked cannot be; 3: --audit refutes what a node said; 4: --compare finds the run nearer. '
        '70: an error that nobody foresaw. Of a folder of runs it is the gravest one: 3, then 4, '
        '70, 2, 1.',
    )
    parser.add_argument(
        'recording', nargs='+', metavar='RUN', help='files or folders of one recording'
    )
    parser.add_argument(
        '--scene', metavar='FILE', help='scene file; without: the robot_description in RUN'
    )
    parser.add_argument(
        '--out',
        '--output',
        dest='out',
        metavar='FOLDER',
        help="made where it is missing (default: RUN's name and _report, in the current folder)",
    )
    add_between_to(parser, 'the report is')
    parser.add_argument(
        '--max-distance', type=distance, default=math.inf, metavar='D', help='[m] (default: inf)'
    )
    parser.add_argument(
        '--rate',
        type=distance,
        default=0.0,
        metavar='HZ',
        help='states a second; 0: with each message that poses something (default)',
    )
    parser.add_argument(
        '--threshold',
        type=finite,
        action='append',
        metavar='D',
        help=f'[m]; may be repeated (default: {", ".join(f"{d:g}" for d in THRESHOLDS)})',
    )
    _add_judgements(parser)
    _add_options_of_a_node(parser)
    parser.set_defaults(run=run)


def _add_judgements(parser: argparse.ArgumentParser) -> None:
    """Add options for certification, comparison, audit, pictures and the cluster."""
    parser.add_argument(
        '--certify',
        type=positive,
        nargs='?',
        const=CERTIFIED,
        default=0.0,
        metavar='D',
        help='prove what lies between states, with bounds within D of what is seen [m] '
        f'(default: {CERTIFIED:g})',
    )
    parser.add_argument(
        '--compare',
        metavar='OTHER',
        help='a run that this one is held against: exit code 4 where this one comes nearer',
    )
    parser.add_argument(
        '--by', choices=WAYS, default='time', help='how runs are compared (default: time)'
    )
    parser.add_argument(
        '--tolerance',
        type=distance,
        default=NEARER_BY,
        metavar='D',
        help=f'how much nearer this run may come than the other [m] (default: {NEARER_BY:g})',
    )
    parser.add_argument(
        '--pictures',
        type=count_or_zero,
        default=3,
        metavar='N',
        help='pictures of the closest moments of each set of pairs; 0: none (default: 3)',
    )
    parser.add_argument(
        '--cluster', metavar='ADDRESS', help='compute on a Dask cluster, as tcp://host:8786'
    )
    parser.add_argument(
        '--resume',
        action='store_true',
        help='leave out what has a report of the same files, options and version, whose exit code '
        'counts; a run that was interrupted goes on behind what was computed',
    )
    parser.add_argument(
        '--audit',
        action='store_true',
        help='compute what a node said in the recording again: exit code 3 where it is refuted',
    )


def _add_options_of_a_node(parser: argparse.ArgumentParser) -> None:
    """Add the options that a node has as parameters and remapped topics."""
    parser.add_argument(
        '--stale-after', type=positive, default=STALE_AFTER, metavar='S', help='[s] (default: 1)'
    )
    add_topics_to(parser)
    parser.add_argument(
        '--package-root',
        action='append',
        default=[],
        metavar='FOLDER',
        help='where package:// looks first; may be repeated',
    )


def run(options: argparse.Namespace) -> int:
    """Write the report and return the exit code; raises GeometryError or OSError for bad input.

    For a folder of runs, each run gets a folder with its report, and the gravest exit code is
    returned.
    """
    options.out = options.out or name_of(options.recording[0])
    runs = runs_in(Path(options.recording[0])) if len(options.recording) == 1 else []
    folder = Path(options.out).resolve()
    runs = [each for each in runs if not folder.is_relative_to(each.resolve())]
    scene = None
    if options.scene:
        scene = read_and_warn(options.scene, package_roots=options.package_root)
    if not runs:
        return make_report(options, scene)
    codes = []
    for place in runs:
        out = Path(options.out) / place.name
        print(f'{place.name}:')
        of_run = argparse.Namespace(
            **{**vars(options), 'recording': [str(place)], 'out': str(out)}
        )
        try:
            codes.append(make_report(of_run, scene))
        except (GeometryError, OSError) as error:
            older = (
                ' (the report that is there is an earlier one)' if (out / PAGE).exists() else ''
            )
            print(f'{place.name}: {error}{older}', file=sys.stderr)
            codes.append(BAD_INPUT)
        except Exception:  # an internal error in one run must not prevent the other reports
            print_unforeseen(place.name)
            codes.append(UNFORESEEN)
    return min(codes, key=_BY_GRAVITY.index)


def name_of(recording: str) -> str:
    """Return the default folder of a report, in the current one."""
    place = Path(recording).resolve()
    return f'{place.name if place.is_dir() else place.stem}_report'
