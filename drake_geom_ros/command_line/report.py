"""``report``: how near things came in what ROS recorded, as tables, a plot and a page."""

import argparse
import math
from dataclasses import fields
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.scene_input import read_and_tell
from drake_geom_ros.recordings import (
    Audit,
    Clearances,
    IncompleteRecordingError,
    Outcome,
    Topics,
    audit,
    clearance,
)
from drake_geom_ros.recordings.clearance import STALE_AFTER
from drake_geom_ros.recordings.files import places_of
from drake_geom_ros.recordings.report import check_folder, write_report

NOT_WHOLE, REFUTED = 1, 3  # exit codes
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
    parser.add_argument(
        '--certify',
        type=float,
        nargs='?',
        const=0.001,
        default=0.0,
        metavar='D',
        help='prove what lies between states, with bounds within D of what is seen [m] '
        '(default: 0.001)',
    )
    parser.add_argument(
        '--audit',
        action='store_true',
        help='compute what a node said in the recording again: exit code 3 where it is refuted',
    )
    _add_options_of_a_node(parser)
    parser.set_defaults(run=run)


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
    """Write the report and return the exit code; raises GeometryError or OSError for bad input."""
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
    found = clearance(
        *(options.recording, scene),
        between=options.between,
        max_distance=options.max_distance,
        rate=options.rate,
        certify=options.certify,
        **of_a_node,
    )
    audited = audit(options.recording, scene, **of_a_node) if options.audit else None
    title = f'Clearance of {places[0].parent.name if len(places) > 1 else places[0].name}'
    written = write_report(
        found, folder, title, [str(place) for place in places], thresholds, audited
    )
    _tell(found)
    if audited is not None:
        _tell_of_audit(audited)
    print(*(f'wrote {path}' for path in written), sep='\n')
    counts = {} if audited is None else audited.counts()
    if counts.get(Outcome.REFUTED):
        return REFUTED
    is_whole = not found.reservations() and not counts.get(Outcome.NOT_REPRODUCIBLE)
    return 0 if is_whole else NOT_WHOLE


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
