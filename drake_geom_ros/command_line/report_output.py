"""Output of ``report``: results on standard output, progress on standard error."""

import math
from collections.abc import Sequence

import numpy as np

from drake_geom_ros.recordings import (
    Audit,
    IncompleteRecordingError,
    SetComparison,
)
from drake_geom_ros.recordings.results import RunAnalysis

_MOST_PAIRS = 5  # printed of a comparison


def print_comparison(compared: Sequence[SetComparison], other: str, by: str) -> None:
    """Print how much nearer the run comes than the other one, and the reservations."""
    unit = ' s' if by == 'time' else ' of the motion'
    for each in compared:
        much, where = each.nearer(allow_incomplete=True)
        print(
            f'{each.name}: {much:.6g} m nearer than in {other} at most, at '
            f'{where:.3f}{unit}; {int(np.count_nonzero(~each.is_whole))} of {len(each.run)} parts '
            'are not known of both'
        )
        for pair in each.pairs[:_MOST_PAIRS]:
            here, there = (_or_never(least) for least in (pair.run, pair.other))
            print(f'  {pair.name_A} and {pair.name_B}: {here}, there {there}')
    for reservation in compared[0].not_known_of_other:
        print(f'not known of {other}: {reservation}')


def _or_never(least: float) -> str:
    return 'never the nearest' if least == math.inf else f'{least:.6g} m'


def print_audit(audited: Audit) -> None:
    """Print the outcomes of an audit, and the reservations."""
    counts = audited.counts().items()
    print('audit: ' + ', '.join(f'{count} {outcome.value}' for outcome, count in counts))
    for topic, first, count in audited.by_reason():
        print(
            f'{first.outcome.value}: {count} of {topic}, the first at {first.time:.3f} s, '
            f'{first.what}: {first.because}'
        )
    for reservation in audited.reservations():
        print(f'not audited: {reservation}')


def print_results(run: RunAnalysis) -> None:
    """Print the minimum distances of a run, and the reservations."""
    print(f'states {run.count}, {run.duration:.3f} s')
    for name in run.moments:
        try:
            least = run.least(name, allow_incomplete=True)
            print(
                f'{name}: distance {least.distance:.9g} m within {least.error_bound:.2g} m at '
                f'{least.time:.3f} s between {least.name_A} {least.name_B}'
            )
        except IncompleteRecordingError as error:
            print(f'{name}: {error}')
        if run.is_certified:
            proved = run.certified(name)
            print(
                f'{name}: motions between states: certified {proved.lower_bound:.9g} m where '
                f'clear; {proved.clear} clear, {proved.contact} contact, {proved.unknown} unknown'
            )
    print(f'read in {run.seconds_reading:.2f} s, computed in {run.seconds_computing:.2f} s')
    for reservation in run.reservations():
        print(f'not known: {reservation}')
    for trouble in run.troubles:
        print(f'wrong: {trouble.words}')
