"""One run's report: what it depends on, what is asked, and its files."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.batch import cluster_executor
from drake_geom_ros.command_line.recording_input import topics_of
from drake_geom_ros.command_line.report_telling import (
    progress,
    tell,
    tell_of_audit,
    tell_of_comparison,
)
from drake_geom_ros.recordings import Audit, Outcome, SetComparison, audit, compare_runs
from drake_geom_ros.recordings.comparison_report import write_comparison
from drake_geom_ros.recordings.files import files_read, places_of
from drake_geom_ros.recordings.kept_states import KeptClearances, KeptStates
from drake_geom_ros.recordings.moment_pictures import pictures_of
from drake_geom_ros.recordings.opened import Opened, opened_recording
from drake_geom_ros.recordings.pair_sets import pair_sets
from drake_geom_ros.recordings.report import check_folder, leave_only, write_report
from drake_geom_ros.recordings.report_record import code_of, forget, made_of, write_record
from drake_geom_ros.recordings.results import Told
from drake_geom_ros.recordings.run import Asked, Run
from drake_geom_ros.scene_files import SceneDescription, SceneFileError, files_of, save_scene

NOT_WHOLE, UNREADABLE, REFUTED, NEARER = 1, 2, 3, 4  # exit codes
THRESHOLDS = (0.0, 0.01, 0.05)  # [m]
_NO_MATTER = 'run', 'out', 'resume', 'cluster'  # options on which no report depends
_UNFINISHED = 'unfinished'  # in the folder of a report: what was computed until it is there


class _Runs(NamedTuple):
    """The run that is reported, and the one that it is compared with."""

    run: Opened
    other: Opened | None

    def all(self) -> list[Opened]:
        return [each for each in self if each is not None]


class _Found(NamedTuple):
    """What was found of a run."""

    run: Told
    compared: list[SetComparison] | None
    audited: Audit | None


def make_report(options: argparse.Namespace, scene: SceneDescription | None) -> int:
    """Write the report of one run and return the exit code; what it is made of is written last."""
    folder = Path(options.out)
    runs = _opened(options, scene)
    inputs = _inputs(options, scene, runs)
    check_folder(folder, inputs)
    asked = made_of(
        inputs,
        {n: v for n, v in vars(options).items() if n not in _NO_MATTER},
        [_told(each) for each in runs.all()],
    )
    if options.resume and (code := code_of(folder, asked)) is not None:
        print(f'{folder.name}: there is a report of the same, whose exit code is {code}')
        return code
    try:
        found = _found(options, scene, runs, asked)
    except KeyboardInterrupt:
        if (folder / _UNFINISHED).is_dir():
            print(f'--resume goes on with {folder / _UNFINISHED}', file=sys.stderr)
        raise
    forget(folder)
    written = _write(options, found, folder)
    leave_only(folder, written)
    _tell(options, found)
    code = _exit_code(options, found)
    later = {str(p): d for each in runs.all() for p, d in each.playback.robot_files.items()}
    written.append(write_record(folder, asked, code, written, later=_settled(runs, later)))
    _remove_unfinished(folder)
    print(*(f'wrote {path}' for path in written), sep='\n')
    return code


def _opened(options: argparse.Namespace, scene: SceneDescription | None) -> _Runs:
    def opened(paths: str | list[str]) -> Opened:
        return opened_recording(
            paths,
            scene=scene,
            topics=topics_of(options),
            stale_after=options.stale_after,
            accuracy='exact',
            world_frame=options.world_frame,
            package_roots=options.package_root,
        )

    return _Runs(opened(options.recording), opened(options.compare) if options.compare else None)


def _inputs(
    options: argparse.Namespace, scene: SceneDescription | None, runs: _Runs
) -> list[Path]:
    """Return all files that decide about the report, but for those that are named in a run."""
    found = [Path(options.scene)] if options.scene else []
    for paths in filter(None, (options.recording, options.compare)):
        found += files_read(places_of(paths))
    for each in runs.all():
        with each.playback.live.editing() as live:
            found += files_of(live.scene_graph, () if scene is None else scene.robots)
    return list(dict.fromkeys(found))


def _told(opened: Opened) -> str:
    """Return a digest of a scene: maps and macros are in it, whatever files they came from."""
    with opened.playback.live.editing() as live:
        try:
            text = save_scene(live.scene_graph)
        except SceneFileError as error:  # what the format cannot say
            text = str(error)
    return sha256(text.encode()).hexdigest()


def _settled(runs: _Runs, later: dict[str, str]) -> dict[str, str] | None:
    """Return the files that robots' descriptions named; None where one of these was refused.

    What it lacked may be there another time.
    """
    for opened in runs.all():
        for refused in opened.playback.refused:
            if opened.roles.get(refused.topic, '').startswith('robot'):
                return None
    return later


def _found(
    options: argparse.Namespace,
    scene: SceneDescription | None,
    runs: _Runs,
    asked: dict[str, Any],
) -> _Found:
    """Compute all that is asked."""
    with ExitStack() as stack:
        executor = None
        if options.cluster:
            executor = stack.enter_context(cluster_executor(options.cluster))

        def found(opened: Opened, name: str, certify: float) -> KeptClearances:
            question = Asked(
                sets=pair_sets(options.between),
                max_distance=options.max_distance,
                rate=options.rate,
                stale_after=options.stale_after,
                certify=certify,
            )
            kept = KeptStates(
                Path(options.out) / _UNFINISHED / name,
                [pairs.name for pairs in question.sets],
                asked,
                certified=bool(certify),
            )
            if not options.resume:
                kept.remove()
            told = progress() if sys.stderr.isatty() else None
            run = Run(opened, question, executor=executor, progress=told)
            for _ in run.parts(kept):
                pass
            return KeptClearances.of(run.facts(), kept)

        run = found(runs.run, 'run', options.certify)
        compared = None
        if runs.other is not None:
            compared = compare_runs(run, found(runs.other, 'other', 0.0), options.by)
    audited = None
    if options.audit:
        audited = audit(
            *(options.recording, scene),
            topics=topics_of(options),
            stale_after=options.stale_after,
            world_frame=options.world_frame,
            package_roots=options.package_root,
        )
    return _Found(run, compared, audited)


def _write(options: argparse.Namespace, found: _Found, folder: Path) -> list[Path]:
    """Write the files of the report; return them."""
    places = places_of(options.recording)
    title = f'Clearance of {places[0].parent.name if len(places) > 1 else places[0].name}'
    thresholds = sorted(options.threshold or THRESHOLDS)
    written = []
    if found.compared is not None:
        written += write_comparison(found.compared, folder, options.compare)
    return written + write_report(
        *(found.run, folder, title, [str(place) for place in places], thresholds),
        audited=found.audited,
        pictures=pictures_of(found.run, options.pictures),
        compared=found.compared,
    )


def _remove_unfinished(folder: Path) -> None:
    """Remove what was computed: it is in the report."""
    for name in ('run', 'other'):
        KeptStates.remove_from(folder / _UNFINISHED / name)
    if (folder / _UNFINISHED).is_dir():
        (folder / _UNFINISHED).rmdir()


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
