"""The whole run: subjects one after another within a time, then files and the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.accuracy import diagrams, overview
from bench.accuracy.cases import (
    QUICK_RESOLUTIONS,
    PairSubject,
    Subject,
    all_cases,
    chosen,
    round_robin,
)
from bench.accuracy.diagrams import draw_levels
from bench.accuracy.measuring import Measurement, Plan
from bench.accuracy.mesh_cases import QUICK_CASES, mesh_cases
from bench.accuracy.results import COLUMNS, OURS, Measured, Setting, write_csv
from bench.accuracy.scenes import SCENES
from bench.accuracy.tables import TITLE, Circumstances, microseconds, readme
from bench.pages import description, versions
from drake_geom_ros.common.whole_files import check_first_line
from truth.judging.asking import BodyScene

MINUTES, QUICK_MINUTES = 9.0, 0.8  # to measure in: the rest of 10 and of 1 is to begin and to end
# Of the share of a subject, for batches: turns, and what takes them to be made, come on top.
BATCHES_PART = 0.35
VIOLATED = 1  # the exit code


@dataclass(frozen=True)
class Request:
    """What was asked for; ``patterns`` of cases, all without any."""

    output: Path
    peers: Sequence[str]
    patterns: Sequence[str] = ()
    quick: bool = False
    minutes: float | None = None
    seed: int = 0
    samples: int | None = None  # of each configuration, at most


def run(request: Request, say: Callable[[str], None]) -> int:
    """Measure, write the files, and return the exit code: 1 where a certificate was wrong."""
    check_first_line(request.output / 'README.md', TITLE)
    check_first_line(request.output / 'measurements.csv', ','.join(COLUMNS))
    plan = Plan(seed=request.seed)
    if request.quick:
        plan = Plan(least_batches=1, turns=5, seed=request.seed, tolerances=False)
    if request.samples is not None:
        plan = replace(plan, least_batches=1, most_batches=request.samples)
    cases = cases_of(request)
    chosen_cases = chosen(cases, request.patterns)
    measurement, left_out = Measurement(plan, request.peers), []
    begun, compiling = time.monotonic(), 0.0
    minutes = request.minutes or (QUICK_MINUTES if request.quick else MINUTES)
    try:
        compiling = compile_kernels(chosen_cases)
        say(f'kernels ready after {compiling:.0f} s, which no figure contains')
        measurement.calibrate()
        subjects: list[Subject] = [make() for make in SCENES.values() if not request.patterns]
        subjects += round_robin(chosen_cases)
        left_out = measure(measurement, subjects, begun + compiling + 60.0 * minutes, say)
    except KeyboardInterrupt:
        say('interrupted: what was measured until now is written')
    finally:
        measurement.close()
    told = Circumstances(
        command=_command(request),
        machine=description(),
        versions=versions(request.peers),
        minutes=(time.monotonic() - begun - compiling) / 60.0,
        compiling=compiling,
        left_out=left_out,
        overheads=measurement.overheads,
    )
    order = {case.name: k for k, case in enumerate(cases)}
    records = sorted(measurement.records, key=lambda r: order.get(r.case, len(order)))
    write(records, told, request.output, say)
    return verdict(records, say)


def _command(request: Request) -> str:
    words = ['python -m bench.accuracy']
    words += ['--quick'] if request.quick else []
    words += [f'--minutes {request.minutes:g}'] if request.minutes else []
    words += [f'--samples {request.samples}'] if request.samples else []
    words += ['--cases', *request.patterns] if request.patterns else []
    return ' '.join(words)


def cases_of(request: Request) -> list[PairSubject]:
    """Return all cases that the request may choose from."""
    if request.quick:
        return [*all_cases(QUICK_RESOLUTIONS), *QUICK_CASES]
    return [*all_cases(), *mesh_cases()]


def compile_kernels(cases: Sequence[PairSubject]) -> float:
    """Compile or load all kernels that the cases need; return the seconds that this took."""
    start = time.perf_counter()
    rng = np.random.default_rng(0)
    for case in {(case.a, case.b): case for case in reversed(cases)}.values():
        bodies = [body for body in case.bodies(rng) if body.kind != 'Point']
        asked = BodyScene(bodies).asked()
        if case.a == 'Point':
            asked.ComputeSignedDistanceToPoint(np.zeros(3))
        else:
            asked.ComputeSignedDistancePairwiseClosestPoints()
    return time.perf_counter() - start


def measure(
    measurement: Measurement,
    subjects: Sequence[Subject],
    end: float,
    say: Callable[[str], None],
) -> list[str]:
    """Measure the subjects, each in its share of what is left until ``end`` (monotonic) [s].

    Returns the names of those for which no time was left.
    """
    left_out: list[str] = []
    for number, subject in enumerate(subjects):
        left = end - time.monotonic()
        if left < 0.0 and number:  # the first one always is
            left_out.append(subject.name)
            continue
        share = max(left, 0.0) / (len(subjects) - number)
        start = time.monotonic()
        records = measurement.measure(subject, BATCHES_PART * share)
        say(
            f'[{number + 1}/{len(subjects)}] {_summary(subject, records)} '
            f'({time.monotonic() - start:.1f} s)'
        )
    if left_out:
        say(f'no time was left for {", ".join(left_out)}: give more with --minutes')
    return left_out


def _summary(subject: Subject, records: Sequence[Measured]) -> str:
    words = []
    for r in records:
        if r.setting == Setting(OURS, 'exact') and r.answers:
            words.append(
                f'{r.query.replace("_", " ")} worst {r.error(1.0):.1e} m of {len(r.answers)}, '
                f'{microseconds(r.whole)} us'
            )
    return f'{subject.name}: {"; ".join(words)}'


def write(
    records: Sequence[Measured], told: Circumstances, folder: Path, say: Callable[[str], None]
) -> None:
    """Write measurements.csv, the diagrams and README.md into a folder, made where missing."""
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(records, folder / 'measurements.csv')
    pictures = draw_levels(records, folder) + diagrams.draw(records, folder)
    if (folder / overview.PICTURE).exists():  # drawn from other measurements
        pictures.append(overview.PICTURE)
    (folder / 'README.md').write_text(readme(records, told, pictures), encoding='utf-8')
    say(f'{folder}: README.md, measurements.csv, {", ".join(pictures)}')


def verdict(records: Sequence[Measured], say: Callable[[str], None]) -> int:
    """Say where certificates were wrong or wider than promised; return the exit code."""
    found = [each for r in records for each in r.violations()]
    for each in found:
        say(f'WRONG: {each}')
    if not found:
        count = sum(len(r.bounds) for r in records)
        say(f'all {count} certificates contain the truth and are as narrow as promised')
    return VIOLATED if found else 0
