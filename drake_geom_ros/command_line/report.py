"""``report``: how near things came in what ROS recorded, as tables, a plot and a page."""

import argparse
import math
import sys
from contextlib import ExitStack
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.batch import cluster_executor
from drake_geom_ros.command_line.inputs import files_of
from drake_geom_ros.command_line.report_telling import (
    progress,
    tell,
    tell_of_audit,
    tell_of_comparison,
)
from drake_geom_ros.command_line.scene_input import read_and_tell
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.recordings import (
    Audit,
    Clearances,
    Outcome,
    SetComparison,
    Topics,
    audit,
    clearance,
    compare_runs,
)
from drake_geom_ros.recordings.clearance import STALE_AFTER
from drake_geom_ros.recordings.comparing import WAYS
from drake_geom_ros.recordings.comparison_report import write_comparison
from drake_geom_ros.recordings.files import files_read, places_of, runs_in
from drake_geom_ros.recordings.highlights import closest
from drake_geom_ros.recordings.moment_pictures import Wanted, pictures_of
from drake_geom_ros.recordings.opened import Opened, opened_recording
from drake_geom_ros.recordings.report import PAGE, check_folder, leave_only, write_report
from drake_geom_ros.recordings.report_record import code_of, forget, made_of, write_record
from drake_geom_ros.recordings.tolerances import CERTIFIED, NEARER_BY
from drake_geom_ros.scene_files import SceneDescription

NOT_WHOLE, UNREADABLE, REFUTED, NEARER = 1, 2, 3, 4  # exit codes
_BY_GRAVITY = REFUTED, NEARER, UNREADABLE, NOT_WHOLE, 0
_NO_MATTER = 'run', 'out', 'resume', 'cluster'  # options on which no report depends
_THRESHOLDS = (0.0, 0.01, 0.05)  # [m]


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'report',
        help='how near things came in a recording of ROS (MCAP or sqlite3)',
        description='Plays a recording as a node would have taken it, computes the least '
        'distances over its time, and writes clearance.csv, clearance.npz, clearance.png and '
        'report.html. Exit code 0: every state tells of all pairs; 1: something is stale, left '
        'out, damaged, missing or not reproducible, which is said on standard output; 2: what was '
        'asked cannot be; 3: --audit refutes what a node said; 4: --compare finds the run nearer. '
        'Of a folder of runs it is the gravest one: 3, then 4, 2, 1.',
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
        '--resume',
        action='store_true',
        help='leave out what has a report of the same files, options and version; its exit code '
        'counts',
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

    Of a folder of runs there is a folder with the report of each, and the gravest exit code.
    """
    runs = runs_in(Path(options.recording[0])) if len(options.recording) == 1 else []
    folder = Path(options.out).resolve()
    runs = [each for each in runs if not folder.is_relative_to(each.resolve())]
    scene = None
    if options.scene:
        scene = read_and_tell(options.scene, package_roots=options.package_root)
    if not runs:
        return _report(options, scene)
    codes = []
    for place in runs:
        out = Path(options.out) / place.name
        print(f'{place.name}:')
        of_run = argparse.Namespace(
            **{**vars(options), 'recording': [str(place)], 'out': str(out)}
        )
        try:
            codes.append(_report(of_run, scene))
        except (GeometryError, OSError) as error:
            older = (
                ' (the report that is there is an earlier one)' if (out / PAGE).exists() else ''
            )
            print(f'{place.name}: {error}{older}', file=sys.stderr)
            codes.append(UNREADABLE)
    return min(codes, key=_BY_GRAVITY.index)


def _report(options: argparse.Namespace, scene: SceneDescription | None) -> int:
    """Write the report of one run and return the exit code; what it is made of is written last."""
    folder = Path(options.out)
    inputs = _inputs(options, scene)
    check_folder(folder, inputs)
    asked = made_of(inputs, {n: v for n, v in vars(options).items() if n not in _NO_MATTER})
    if options.resume and (code := code_of(folder, asked)) is not None:
        print(f'{folder.name}: there is a report of the same, whose exit code is {code}')
        return code
    found = _found(options, scene)
    forget(folder)
    written = _write(options, scene, found, folder)
    leave_only(folder, written)
    _tell(options, found)
    code = _exit_code(options, found)
    written.append(write_record(folder, asked, code, written))
    print(*(f'wrote {path}' for path in written), sep='\n')
    return code


class _Found(NamedTuple):
    """What was found of a run."""

    run: Clearances
    compared: list[SetComparison] | None
    audited: Audit | None


def _inputs(options: argparse.Namespace, scene: SceneDescription | None) -> list[Path]:
    """Return all files that decide about the report."""
    found = [Path(options.scene)] if options.scene else []
    for paths in filter(None, (options.recording, options.compare)):
        opened = _opened(options, paths, scene)
        found += files_read(places_of(paths))
        with opened.playback.live.editing() as live:
            found += files_of(live.scene_graph, () if scene is None else scene.robots)
    return list(dict.fromkeys(found))


def _opened(
    options: argparse.Namespace, paths: str | list[str], scene: SceneDescription | None
) -> Opened:
    return opened_recording(
        *(paths, scene, Topics.of(options.topic), options.stale_after, 'exact'),
        *(options.world_frame, options.package_root),
    )


def _found(options: argparse.Namespace, scene: SceneDescription | None) -> _Found:
    """Compute all that is asked."""
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
    return _Found(found, compared, audited)


def _write(
    options: argparse.Namespace, scene: SceneDescription | None, found: _Found, folder: Path
) -> list[Path]:
    """Write the files of the report; return them."""
    places = places_of(options.recording)
    title = f'Clearance of {places[0].parent.name if len(places) > 1 else places[0].name}'
    thresholds = sorted(options.threshold or _THRESHOLDS)
    written = []
    if found.compared is not None:
        written += write_comparison(found.compared, folder, options.by)
    return written + write_report(
        *(found.run, folder, title, [str(place) for place in places], thresholds),
        audited=found.audited,
        pictures=_pictures(options, scene, found.run),
        compared=found.compared,
    )


def _tell(options: argparse.Namespace, found: _Found) -> None:
    tell(found.run)
    if found.audited is not None:
        tell_of_audit(found.audited)
    if found.compared is not None:
        tell_of_comparison(found.compared, options.compare, options.by)


def _exit_code(options: argparse.Namespace, found: _Found) -> int:
    counts = {} if found.audited is None else found.audited.counts()
    if counts.get(Outcome.REFUTED):
        return REFUTED
    compared = found.compared or ()
    if any(each.nearer(allow_incomplete=True)[0] > options.tolerance for each in compared):
        return NEARER
    is_whole = not found.run.reservations() and not counts.get(Outcome.NOT_REPRODUCIBLE)
    is_whole &= found.audited is None or not found.audited.reservations()
    is_whole &= all(each.is_known for each in compared)
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
            progress=progress() if sys.stderr.isatty() else None,
            **asked,
        )


def _pictures(
    options: argparse.Namespace, scene: SceneDescription | None, found: Clearances
) -> dict[tuple[str, int], bytes]:
    """Return pictures of the closest moments."""
    wanted: dict[int, list[Wanted]] = {}
    for name, pairs in found.sets.items():
        for number, state in enumerate(closest(found, pairs, options.pictures), 1):
            wanted.setdefault(state, []).append(Wanted(name, number, pairs.at(state)))
    return pictures_of(_opened(options, options.recording, scene), wanted, options.rate)
