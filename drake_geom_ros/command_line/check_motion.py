"""Command ``check-motion``: certify that a path of joint values or a motion is clear."""

import argparse
import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drake_geom_ros.batch.path_profile import PathProfile, draw_profile
from drake_geom_ros.command_line.checked_motions import (
    CLEAR_IN_PIECES,
    CheckedMotion,
    of_motion,
    of_path,
    of_trajectory,
)
from drake_geom_ros.command_line.exit_codes import DONE, NO, NOT_PROVED
from drake_geom_ros.command_line.option_values import (
    ACCURACY_HELP,
    accuracy,
    count,
    count_or_zero,
    distance,
    finite,
    positive,
)
from drake_geom_ros.command_line.scene_input import add_scene_options
from drake_geom_ros.common.whole_files import check_outputs
from drake_geom_ros.geometry import ArgumentError, GeometryId, MotionCheck
from drake_geom_ros.math.tolerances import TIME_TOLERANCE


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'check-motion',
        description='Checks a path of joint values, straight in joint space from row to row, or '
        'the poses of a motion, straight from moment to moment: clear for all times, the first '
        'contact, or from when on nothing is proved. Exit code 0 where it is clear, 1 where it is '
        'not, and 3 where a motion is clear in pieces: of its curve between the moments nothing '
        'is proved. A trajectory is proved along the splines on which controllers take joints. '
        'Times are rows of the path, or seconds.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    add_scene_options(parser)
    moving = parser.add_mutually_exclusive_group(required=True)
    moving.add_argument('--path', metavar='FILE', help='.npy, .npz or .csv, as states of batch')
    moving.add_argument(
        '--trajectory',
        metavar='FILE',
        help='trajectory_msgs/JointTrajectory as YAML, along the splines of controllers',
    )
    moving.add_argument('--motion', metavar='FILE', help='motion of robots and frames, YAML')
    parser.add_argument('--names', nargs='+', metavar='NAME', help='joints of the columns')
    _add_question(parser)
    parser.add_argument('--csv', metavar='FILE', help='what is proved, piece by piece')
    parser.add_argument(
        '--picture', '--plot', metavar='FILE', help='distances and proved bounds over time'
    )
    parser.add_argument(
        '--pieces',
        type=count,
        default=200,
        metavar='N',
        help='of --csv and --picture, and into which a motion is cut (default: 200)',
    )
    parser.set_defaults(run=run)


def _add_question(parser: argparse.ArgumentParser) -> None:
    """Add the options of what is to be proved."""
    parser.add_argument(
        '--min-distance', type=finite, default=0.0, metavar='D', help='[m] (default: 0)'
    )
    parser.add_argument(
        '--time-tolerance',
        type=positive,
        default=TIME_TOLERANCE,
        metavar='T',
        help='longest span that may hold the first contact, in rows or seconds (default: 1e-6)',
    )
    parser.add_argument(
        '--max-evaluations',
        type=count_or_zero,
        default=0,
        metavar='N',
        help='0: no limit (default)',
    )
    parser.add_argument('--accuracy', type=accuracy, default='exact', help=ACCURACY_HELP)
    parser.add_argument(
        '--ignore-start-contacts',
        action='store_true',
        help='leave out pairs that are not clear at the start, and tell how many',
    )
    parser.add_argument(
        '--ignore-limits', action='store_true', help='let joints pass their limits'
    )
    parser.add_argument(
        '--bound-tolerance',
        type=distance,
        default=math.inf,
        metavar='D',
        help='prove more of a clear path, until its bound is so close to the distances seen [m]',
    )


def run(options: argparse.Namespace) -> int:
    """Check, report and return the exit code; GeometryError or OSError for bad input."""
    outputs = {'--csv': options.csv, '--picture': options.picture}
    inputs = options.scene, options.srdf, options.path, options.trajectory, options.motion
    check_outputs(outputs, list(inputs))
    checked = _checked(options)
    check_outputs(outputs, checked.files)
    check = checked.check
    print(
        f'outcome {checked.outcome}', *_lines(check, checked.name_of), *checked.remarks, sep='\n'
    )
    profile = checked.profile() if options.csv or options.picture else None
    if profile is not None and options.csv:
        _write(Path(options.csv), profile)
    if profile is not None and options.picture:
        title = f'{Path(options.scene).stem}: {checked.outcome}'
        file = Path(options.picture)
        draw_profile(profile, check, options.min_distance, title, file, checked.unit)
    return {'clear': DONE, CLEAR_IN_PIECES: NOT_PROVED}.get(checked.outcome, NO)


def _checked(options: argparse.Namespace) -> CheckedMotion:
    """Check what the options name; errors name options of this command, not arguments."""
    if options.motion:
        return of_motion(options)
    try:
        return (of_trajectory if options.trajectory else of_path)(options)
    except ArgumentError as error:
        raise ArgumentError(str(error).replace('ignore_limits=True', '--ignore-limits')) from error


def _lines(check: MotionCheck, name_of: Callable[[GeometryId], str]) -> list[str]:
    """Return the lines of a check's report, without its outcome."""
    lines = [f'times {check.times[0]!r} {check.times[1]!r}']
    if check.id_A is not None and check.id_B is not None:
        names = ' '.join(name_of(id) for id in (check.id_A, check.id_B))
        lines.append(f'distance {check.distance:.9g} at {check.time:.9g} between {names}')
    lines.append(f'lower_bound {check.lower_bound:.9g}')
    lines.append(f'evaluations {check.evaluations}')
    if check.ignored:
        lines.append(f'ignored {check.ignored} pairs that are not clear at the start')
    return lines


def _write(file: Path, profile: PathProfile) -> None:
    """Write the pieces of a profile as CSV."""
    with file.open('w', newline='') as stream:
        rows = csv.writer(stream)
        rows.writerow(('begin', 'end', 'outcome', 'lower_bound', 'distance', 'error_bound'))
        ends = profile.times[1:] if len(profile.times) > 1 else profile.times
        for k, outcome in enumerate(profile.outcomes):
            numbers = profile.lower_bounds[k], profile.distances[k], profile.error_bounds[k]
            digits = (repr(float(x)) for x in numbers)
            rows.writerow((repr(float(profile.times[k])), repr(float(ends[k])), outcome, *digits))
