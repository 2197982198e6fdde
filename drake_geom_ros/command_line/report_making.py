"""Report of one run: its request, its computation, its files and its exit code."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack, nullcontext
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.batch import cluster_executor
from drake_geom_ros.command_line.exit_codes import DONE, NEARER, NO, NOT_PROVED
from drake_geom_ros.command_line.recording_input import topics_of
from drake_geom_ros.command_line.report_output import (
    print_audit,
    print_comparison,
    print_results,
)
from drake_geom_ros.common.progress_bar import progress_bar
from drake_geom_ros.recordings import Audit, Outcome, SetComparison, audit, compare_runs
from drake_geom_ros.recordings.comparison_report import write_comparison
from drake_geom_ros.recordings.moment_pictures import pictures_of
from drake_geom_ros.recordings.opened import Opened, opened_recording
from drake_geom_ros.recordings.pair_sets import pair_sets
from drake_geom_ros.recordings.recording_files import files_read, places_of
from drake_geom_ros.recordings.report import check_folder, leave_only, write_report
from drake_geom_ros.recordings.report_record import code_of, forget, made_of, write_record
from drake_geom_ros.recordings.results import RunAnalysis
from drake_geom_ros.recordings.run import Run, RunOptions
from drake_geom_ros.recordings.stored_states import StoredClearances, StoredStates
from drake_geom_ros.scene_files import SceneDescription, SceneFileError, files_of, save_scene

THRESHOLDS = (0.0, 0.01, 0.05)  # [m]
_NO_MATTER = 'run', 'out', 'resume', 'cluster'  # options that do not change a report
_UNFINISHED = 'unfinished'  # folder of computed states, until the report is complete


class _Runs(NamedTuple):
    """The reported run, and the run that it is compared with."""

    run: Opened
    other: Opened | None

    def all(self) -> list[Opened]:
        return [each for each in self if each is not None]


class _Results(NamedTuple):
    """Results of a run, of its comparison and of its audit."""

    run: RunAnalysis
    compared: list[SetComparison] | None
    audited: Audit | None


def make_report(options: argparse.Namespace, scene: SceneDescription | None) -> int:
    """Write the report of one run and return the exit code; the record is written last."""
    folder = Path(options.out)
    runs = _opened(options, scene)
    inputs = _inputs(options, scene, runs)
    check_folder(folder, inputs)
    request = made_of(
        inputs,
        {n: v for n, v in vars(options).items() if n not in _NO_MATTER},
        [_scene_digest(each) for each in runs.all()],
    )
    if options.resume and (code := code_of(folder, request)) is not None:
        print(f'{folder.name}: there is a report of the same, whose exit code is {code}')
        return code
    try:
        results = _computed(options, scene, runs, request)
    except KeyboardInterrupt:
        if (folder / _UNFINISHED).is_dir():
            print(f'--resume goes on with {folder / _UNFINISHED}', file=sys.stderr)
        raise
    forget(folder)
    written = _write(options, results, folder)
    leave_only(folder, written)
    _print(options, results)
    code = _exit_code(options, results)
    later = {str(p): d for each in runs.all() for p, d in each.playback.robot_files.items()}
    written.append(write_record(folder, request, code, written, later=_settled(runs, later)))
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
    """Return all files on which the report depends, without those that a run names."""
    files = [Path(options.scene)] if options.scene else []
    for paths in filter(None, (options.recording, options.compare)):
        files += files_read(places_of(paths))
    for each in runs.all():
        with each.playback.live.editing() as live:
            files += files_of(live.model.scene_graph, () if scene is None else scene.robots)
    return list(dict.fromkeys(files))


def _scene_digest(opened: Opened) -> str:
    """Return a digest of a scene, including maps and macros, whatever files they came from."""
    with opened.playback.live.editing() as live:
        try:
            text = save_scene(live.model.scene_graph)
        except SceneFileError as error:  # contents that the format cannot express
            text = str(error)
    return sha256(text.encode()).hexdigest()


def _settled(runs: _Runs, later: dict[str, str]) -> dict[str, str] | None:
    """Return the files that robot descriptions named; None if a description was refused.

    The files that it lacked may exist in another run.
    """
    for opened in runs.all():
        for refused in opened.playback.refused:
            if opened.roles.get(refused.topic, '').startswith('robot'):
                return None
    return later


def _computed(
    options: argparse.Namespace,
    scene: SceneDescription | None,
    runs: _Runs,
    request: dict[str, Any],
) -> _Results:
    """Compute the distances, the comparison and the audit that the options request."""
    with ExitStack() as stack:
        executor = None
        if options.cluster:
            executor = stack.enter_context(cluster_executor(options.cluster))

        def analysed(opened: Opened, name: str, certify: float) -> StoredClearances:
            question = RunOptions(
                sets=pair_sets(options.between),
                max_distance=options.max_distance,
                rate=options.rate,
                stale_after=options.stale_after,
                certify=certify,
            )
            stored = StoredStates(
                Path(options.out) / _UNFINISHED / name,
                [pairs.name for pairs in question.sets],
                request,
                certified=bool(certify),
            )
            if not options.resume:
                stored.remove()
            with progress_bar('states') if sys.stderr.isatty() else nullcontext() as show:
                progress = None if show is None else lambda states, _: show(states)
                run = Run(opened, question, executor=executor, progress=progress)
                for _ in run.parts(stored):
                    pass
            return StoredClearances.of(run.facts(), stored)

        run = analysed(runs.run, 'run', options.certify)
        compared = None
        if runs.other is not None:
            compared = compare_runs(run, analysed(runs.other, 'other', 0.0), options.by)
    audited = None
    if options.audit:
        audited = audit(
            *(options.recording, scene),
            topics=topics_of(options),
            stale_after=options.stale_after,
            world_frame=options.world_frame,
            package_roots=options.package_root,
        )
    return _Results(run, compared, audited)


def _write(options: argparse.Namespace, results: _Results, folder: Path) -> list[Path]:
    """Write the files of the report; return them."""
    places = places_of(options.recording)
    title = f'Clearance of {places[0].parent.name if len(places) > 1 else places[0].name}'
    thresholds = sorted(options.threshold or THRESHOLDS)
    written = []
    if results.compared is not None:
        written += write_comparison(results.compared, folder, options.compare)
    return written + write_report(
        *(results.run, folder, title, [str(place) for place in places], thresholds),
        audited=results.audited,
        pictures=pictures_of(results.run, options.pictures),
        compared=results.compared,
    )


def _remove_unfinished(folder: Path) -> None:
    """Remove the computed states, which are in the report now."""
    for name in ('run', 'other'):
        StoredStates.remove_from(folder / _UNFINISHED / name)
    if (folder / _UNFINISHED).is_dir():
        (folder / _UNFINISHED).rmdir()


def _print(options: argparse.Namespace, results: _Results) -> None:
    print_results(results.run)
    if results.audited is not None:
        print_audit(results.audited)
    if results.compared is not None:
        print_comparison(results.compared, options.compare, options.by)


def _exit_code(options: argparse.Namespace, results: _Results) -> int:
    counts = {} if results.audited is None else results.audited.counts()
    if counts.get(Outcome.REFUTED):
        return NOT_PROVED
    compared = results.compared or ()
    if any(each.nearer(allow_incomplete=True)[0] > options.tolerance for each in compared):
        return NEARER
    is_whole = not results.run.reservations() and not counts.get(Outcome.NOT_REPRODUCIBLE)
    is_whole &= results.audited is None or not results.audited.reservations()
    is_whole &= all(each.is_known for each in compared)
    return DONE if is_whole else NO
