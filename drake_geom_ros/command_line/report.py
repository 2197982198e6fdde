"""``report``: how near things came in what ROS recorded, as tables, a plot and a page."""

import argparse
import math
import sys
import time
from contextlib import ExitStack
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.batch import cluster_executor
from drake_geom_ros.command_line.scene_input import read_and_tell
from drake_geom_ros.recordings import (
    Audit,
    Clearances,
    IncompleteRecordingError,
    Outcome,
    RecordingError,
    SetComparison,
    Topics,
    audit,
    clearance,
    compare_runs,
)
from drake_geom_ros.recordings.clearance import STALE_AFTER, Progress
from drake_geom_ros.recordings.comparing import WAYS
from drake_geom_ros.recordings.comparison_report import write_comparison
from drake_geom_ros.recordings.files import places_of, runs_in
from drake_geom_ros.recordings.highlights import closest
from drake_geom_ros.recordings.moment_pictures import Wanted, pictures_of
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.report import PAGE, check_folder, write_report
from drake_geom_ros.recordings.tolerances import CERTIFIED, NEARER_BY
from drake_geom_ros.scene_files import SceneDescription

NOT_WHOLE, UNREADABLE, REFUTED, NEARER = 1, 2, 3, 4  # exit codes
_MOST_PAIRS = 5  # that are told of two runs
_THRESHOLDS = (0.0, 0.01, 0.05)  # [m]


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'report',
        help='how near things came in a recording of ROS (MCAP or sqlite3)',
        description='Plays a recording as a node would have taken it, computes the least '
        'distances over its time, and writes clearance.csv, clearance.npz, clearance.png and '
        'report.html. Exit code 0 where every state tells of all pairs, and 1 where something is '
        'stale, left out, damaged or missing: what is said on standard output.',
    )
    parser.add_argument(
        'recording', nargs='+', metavar='RUN', help='files or folders of one recording'
    )
    parser.add_argument(
        '--scene', metavar='FILE', help='scene file; without: the robot_description in RUN'
    )
    parser.add_argument('--out', required=True, metavar='FOLDER', help='made where it is missing')
    parser.add_argument(
        '--between',
        action='append',
        default=[],
        metavar='A:B',
        help='pairs of two names or patterns of sources, frames or geometries; may be repeated',
    )
    parser.add_argument(
        '--max-distance', type=float, default=math.inf, metavar='D', help='[m] (default: inf)'
    )
    parser.add_argument(
        '--rate',
        type=float,
        default=0.0,
        metavar='HZ',
        help='states a second; 0: with each message that poses something (default)',
    )
    parser.add_argument(
        '--threshold',
        type=float,
        action='append',
        metavar='D',
        help=f'[m]; may be repeated (default: {", ".join(f"{d:g}" for d in _THRESHOLDS)})',
    )
    _add_judgements(parser)
    _add_options_of_a_node(parser)
    parser.set_defaults(run=run)


def _add_judgements(parser: argparse.ArgumentParser) -> None:
    """Add what more is to be found out, and by whom."""
    parser.add_argument(
        '--certify',
        type=float,
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
        type=float,
        default=NEARER_BY,
        metavar='D',
        help=f'how much nearer this run may come than the other [m] (default: {NEARER_BY:g})',
    )
    parser.add_argument(
        '--pictures',
        type=int,
        default=3,
        metavar='N',
        help='pictures of the closest moments of each set of pairs, for which the recording is '
        'read again up to there; 0: none (default: 3)',
    )
    parser.add_argument(
        '--cluster', metavar='ADDRESS', help='compute on a Dask cluster, as tcp://host:8786'
    )
    parser.add_argument(
        '--resume', action='store_true', help='leave out runs of a folder that have a report'
    )
    parser.add_argument(
        '--audit',
        action='store_true',
        help='compute what a node said in the recording again: exit code 3 where it is refuted',
    )


def _add_options_of_a_node(parser: argparse.ArgumentParser) -> None:
    """Add what a node has as parameters and remapped topics."""
    names = ', '.join(field.name for field in fields(Topics))
    parser.add_argument(
        '--stale-after', type=float, default=STALE_AFTER, metavar='S', help='[s] (default: 1)'
    )
    parser.add_argument(
        '--topic',
        action='append',
        default=[],
        metavar='NAME=TOPIC',
        help=f'another topic than the usual one, or none: NAME is one of {names}',
    )
    parser.add_argument(
        '--world-frame', default='world', metavar='NAME', help='as TF calls it (default: world)'
    )
    parser.add_argument(
        '--package-root',
        action='append',
        default=[],
        metavar='FOLDER',
        help='where package:// looks first; may be repeated',
    )


def run(options: argparse.Namespace) -> int:
    """Write the report and return the exit code; raises GeometryError or OSError for bad input.

    Of a folder of runs there is a folder with the report of each, and the worst exit code.
    """
    runs = runs_in(Path(options.recording[0])) if len(options.recording) == 1 else []
    if not runs:
        return _report(options)
    codes = []
    for place in runs:
        out = Path(options.out) / place.name
        if options.resume and (out / PAGE).exists():
            print(f'{place.name}: there is a report')
            continue
        print(f'{place.name}:')
        of_run = argparse.Namespace(
            **{**vars(options), 'recording': [str(place)], 'out': str(out)}
        )
        try:
            codes.append(_report(of_run))
        except RecordingError as error:
            print(f'{place.name}: {error}', file=sys.stderr)
            codes.append(UNREADABLE)
    return max(codes, default=0)


def _report(options: argparse.Namespace) -> int:
    """Write the report of one run, the page last of all."""
    places, folder = places_of(options.recording), Path(options.out)
    thresholds = sorted(options.threshold or _THRESHOLDS)
    scene = None
    if options.scene:
        scene = read_and_tell(options.scene, package_roots=options.package_root)
    check_folder(folder, [*places, options.scene])
    of_a_node: dict[str, Any] = {
        'topics': Topics.of(options.topic),
        'stale_after': options.stale_after,
        'world_frame': options.world_frame,
        'package_roots': options.package_root,
    }
    asked: dict[str, Any] = {
        'between': options.between,
        'max_distance': options.max_distance,
        'rate': options.rate,
        **of_a_node,
    }
    found = _clearance(options, scene, asked)
    compared = None
    if options.compare:
        other = clearance(options.compare, scene, **asked)
        compared = compare_runs(found, other, options.by)
    audited = audit(options.recording, scene, **of_a_node) if options.audit else None
    title = f'Clearance of {places[0].parent.name if len(places) > 1 else places[0].name}'
    pictures = _pictures(options, scene, found)
    files = [str(place) for place in places]
    written = write_report(found, folder, title, files, thresholds, audited, pictures)
    if compared is not None:
        written += write_comparison(compared, folder, options.by)
    _tell(found)
    if audited is not None:
        _tell_of_audit(audited)
    print(*(f'wrote {path}' for path in written), sep='\n')
    counts = {} if audited is None else audited.counts()
    if counts.get(Outcome.REFUTED):
        return REFUTED
    if compared is not None and _comes_nearer(compared, options):
        return NEARER
    is_whole = not found.reservations() and not counts.get(Outcome.NOT_REPRODUCIBLE)
    is_whole &= compared is None or all(each.is_whole.all() for each in compared)
    return 0 if is_whole else NOT_WHOLE


def _clearance(
    options: argparse.Namespace, scene: SceneDescription | None, asked: dict[str, Any]
) -> Clearances:
    """Return the least distances of the run, by a cluster where there is one."""
    with ExitStack() as stack:
        executor = None
        if options.cluster:
            executor = stack.enter_context(cluster_executor(options.cluster))
        return clearance(
            *(options.recording, scene),
            certify=options.certify,
            executor=executor,
            progress=_progress() if sys.stderr.isatty() else None,
            **asked,
        )


def _progress() -> Progress:
    """Return what tells on standard error how far it is, once a second."""
    shown = time.monotonic()

    def tell(states: int, seconds: float) -> None:
        nonlocal shown
        if time.monotonic() - shown >= 1.0:
            shown = time.monotonic()
            print(f'\r{states} states, {seconds:.0f} s', end='', file=sys.stderr, flush=True)

    return tell


def _pictures(
    options: argparse.Namespace, scene: SceneDescription | None, found: Clearances
) -> dict[tuple[str, int], bytes]:
    """Return pictures of the closest moments."""
    wanted: dict[int, list[Wanted]] = {}
    for name, pairs in found.sets.items():
        for number, state in enumerate(closest(found, pairs, options.pictures), 1):
            wanted.setdefault(state, []).append(Wanted(name, number, pairs.at(state)))
    opened = opened_recording(
        *(options.recording, scene, Topics.of(options.topic), options.stale_after, 'exact'),
        *(options.world_frame, options.package_root),
    )
    return pictures_of(opened, wanted, options.rate)


def _comes_nearer(compared: list[SetComparison], options: argparse.Namespace) -> bool:
    """Tell how much nearer the run comes than the other one; return whether it is too much."""
    unit = ' s' if options.by == 'time' else ' of the motion'
    for each in compared:
        much, where = each.nearer()
        print(
            f'{each.name}: {much:.6g} m nearer than in {options.compare} at most, at '
            f'{where:.3f}{unit}; {int(np.count_nonzero(~each.is_whole))} of {len(each.run)} parts '
            'are not known of both'
        )
        for pair in each.pairs[:_MOST_PAIRS]:
            print(f'  {pair.name_A} and {pair.name_B}: {pair.run:.6g} m, there {pair.other:.6g} m')
    return any(each.nearer()[0] > options.tolerance for each in compared)


def _tell_of_audit(audited: Audit) -> None:
    counts = audited.counts().items()
    print('audit: ' + ', '.join(f'{count} {outcome.value}' for outcome, count in counts))
    for topic, first, count in audited.by_reason():
        print(
            f'{first.outcome.value}: {count} of {topic}, the first at {first.time:.3f} s, '
            f'{first.what}: {first.because}'
        )


def _tell(found: Clearances) -> None:
    print(f'states {len(found.times)}, {found.duration:.3f} s')
    for name in found.sets:
        try:
            least = found.least(name, allow_incomplete=True)
            print(
                f'{name}: distance {least.distance:.9g} m within {least.error_bound:.2g} m at '
                f'{least.time:.3f} s between {least.name_A} {least.name_B}'
            )
        except IncompleteRecordingError as error:
            print(f'{name}: {error}')
        if found[name].motion is not None:
            proved = found[name].certified()
            print(
                f'{name}: motions between states: certified {proved.lower_bound:.9g} m where '
                f'clear; {proved.clear} clear, {proved.contact} contact, {proved.unknown} unknown'
            )
    print(f'read in {found.seconds_reading:.2f} s, computed in {found.seconds_computing:.2f} s')
    for told in found.reservations():
        print(f'not known: {told}')
    for trouble in found.troubles:
        print(f'wrong: {trouble.words}')
