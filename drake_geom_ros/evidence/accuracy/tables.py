"""README.md and measurements.csv: the figures, for people and for programs."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drake_geom_ros.evidence.accuracy.results import OURS, Measured, Setting
from drake_geom_ros.evidence.asking import LEVELS, QUERIES
from drake_geom_ros.evidence.pages import table, three

COLUMNS = (
    'case', 'family', 'query', 'library', 'setting', 'answers', 'failures', 'error_median',
    'error_p99', 'error_worst', 'worst_configuration', 'error_bound_worst', 'ratio_median',
    'ratio_worst', 'seconds_per_pair', 'seconds_computing',
)  # fmt: skip
LEVELS_PICTURE = 'levels.png'
QUERY_TITLES = {
    'signed_distance': 'Signed distance',
    'penetration': 'Penetration',
    'points': 'Signed distance to points',
}


@dataclass(frozen=True)
class Circumstances:
    """How, where and with what the figures were taken."""

    command: str
    machine: str
    versions: dict[str, str]
    minutes: float
    compiling: float
    left_out: Sequence[str]
    overheads: dict[tuple[Setting, str], float]


def write_csv(records: Sequence[Measured], path: Path) -> None:
    """Write one row a record, lengths in metres and times in seconds, all digits."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(COLUMNS)
        for r in records:
            failures = ' '.join(f'{name}:{n}' for name, n in sorted(r.failures.items()))
            ratios = r.ratios()
            numbers = (
                *(r.error(q) for q in (0.5, 0.99, 1.0)),
                r.worst_configuration(),
                r.worst_bound(),
                float(np.median(ratios)) if ratios else math.nan,
                max(ratios, default=math.nan),
                math.nan if r.whole is None else r.whole,
                math.nan if r.inside is None else r.inside,
            )
            cells = ['' if isinstance(x, float) and math.isnan(x) else x for x in numbers]
            writer.writerow(
                [
                    *(r.case, r.family, r.query, r.setting.library, r.setting.label),
                    *(len(r.answers), failures, *cells),
                ]
            )


def merged(records: Sequence[Measured]) -> Measured:
    """Return the records of one setting on a family as one: all errors, the median times."""
    first = records[0]
    one = Measured(first.family, first.family, first.query, first.setting)
    for r in records:
        one.answers += r.answers
        one.verdicts += r.verdicts
    for name in ('whole', 'inside'):
        times = [t for r in records if (t := getattr(r, name)) is not None]
        setattr(one, name, float(np.median(times)) if times else None)
    return one


def by_family(records: Sequence[Measured]) -> dict[tuple[str, str], list[Measured]]:
    """Return one merged record a setting, for each query and family, in the order measured."""
    groups: dict[tuple[str, str], dict[Setting, list[Measured]]] = {}
    for r in records:
        groups.setdefault((r.query, r.family), {}).setdefault(r.setting, []).append(r)
    order = {query: k for k, query in enumerate(QUERIES)}
    keys = sorted(groups, key=lambda key: order[key[0]])
    return {key: [merged(rs) for rs in groups[key].values()] for key in keys}


def readme(records: Sequence[Measured], told: Circumstances, pictures: Sequence[str]) -> str:
    """Return the text of README.md."""
    families = by_family(records)
    parts = [f'# Accuracy, and what it costs\n\n{choice(families)}\n']
    if LEVELS_PICTURE in pictures:
        parts.append(f'![Time and error of each accuracy level]({LEVELS_PICTURE})\n')
    parts += [_certificates(records), _beginning(told)]
    for query in QUERIES:
        if f'{query}.png' in pictures:
            parts.append(f'![{QUERY_TITLES[query]}: error over time]({query}.png)\n')
    for query in QUERIES:
        groups = {family: rs for (q, family), rs in families.items() if q == query}
        if groups:
            parts.append(f'## {QUERY_TITLES[query]}\n')
        parts += [f'### {family}\n\n{_family(rs)}' for family, rs in groups.items()]
    parts.append(_each_case(records))
    return '\n'.join(parts)


def choice(families: dict[tuple[str, str], list[Measured]]) -> str:
    """Return which level to choose, by what the levels took on each family."""
    ratios = []
    for settings in families.values():
        times = {r.setting.label: r.whole for r in settings if r.setting.library == OURS}
        exact, fast = times.get('exact'), times.get('fast')
        if exact and fast:
            ratios.append(exact / fast)
    advice = (
        'Choose `exact`, the default, unless a scene of yours is shown to gain from another '
        'level: `~/cycle_report` tells what each level would cost for what the node is asked now.'
    )
    if not ratios:
        return advice
    return (
        f'{advice} On the families of shapes below, `exact` takes {min(ratios):.2g} to '
        f'{max(ratios):.2g} times as long as `fast`, {np.median(ratios):.2g} times in the median. '
        '`bound` answers from bounding volumes alone: it tells what is far apart, and little '
        'else. The certificate holds at every level.'
    )


def _beginning(told: Circumstances) -> str:
    versions = ', '.join(f'{name} {version}' for name, version in told.versions.items())
    lines = [
        '## How it was measured',
        '',
        f'Generated by `{told.command}` in {told.minutes:.1f} minutes, after '
        f'{told.compiling:.0f} s of compiling or loading kernels, which no figure here contains.',
        '',
        f'Machine: {told.machine}. Versions: {versions}.',
        '',
        *_left_out(told.left_out),
        '- **Error** [m]: the difference from a truth with 40 digits, known from how the pair was '
        'placed or from a maximum over all directions (`drake_geom_ros/evidence/truth`). Bodies '
        'of about 0.2 m, in equal parts 20 cm apart, 2 mm apart, touching, 2 mm deep, 2 cm deep '
        'and one inside the other, at vertices, along edges and on faces. An error below the '
        'spacing of floats at that size (shown as `<`) is drawn there, one above 10 m at 10 m.',
        '- **Time** [us per pair]: medians of turns that the libraries take one after another, on '
        'pairs that are turned anew each time, so that none gains from its last answer; '
        'processor time of one thread. Ours: 120 pairs posed, asked and read in one query, '
        'broad phase and Python included; in brackets the kernels alone. Peers: one call per pair '
        'from Python; in brackets without the smallest cost of such a call, measured on two '
        'spheres (below).',
        '- **Bound** [m]: our certificate, `error_bound`. It must never be below the error.',
        '- **No answer**: how often, and why. `missed` is an overlap that was not reported; at '
        'level `bound`, every pair that may overlap is reported.',
        '- **Solid meshes**: an L of two boxes and a ball with dents, as the bodies that their '
        'triangles enclose; the truth is that of the boxes, or of the nearest triangle. '
        'Deep in a solid, our certificate may stay an open interval: it holds, but need not '
        'be narrow. python-fcl and Coal are given the triangles, a surface without an inside; '
        'pydrake and MuJoCo use the convex hull. Ours: 12 pairs in one query.',
        '- **Whole scenes**: errors on pairs of the scene; ours is timed as one query on all '
        'bodies, divided by the number of pairs that it reports (within 0.1 m; in contact), peers '
        'pair by pair, without a broad phase.',
        '',
        'Smallest cost of a call [us]: '
        + ('; '.join(_overheads(told.overheads)) or 'no peer was asked')
        + '.',
        '',
    ]
    return '\n'.join(lines)


def _left_out(names: Sequence[str]) -> list[str]:
    return [f'No time was left for {", ".join(names)}.', ''] if names else []


def _overheads(overheads: dict[tuple[Setting, str], float]) -> list[str]:
    """Return the cost of a call of each peer at its own settings, in words."""
    return [
        f'{setting.library} {seconds * 1e6:.1f} ({QUERY_TITLES[query].lower()})'
        for (setting, query), seconds in overheads.items()
        if not setting.label[0].isdigit()
    ]


def _certificates(records: Sequence[Measured]) -> str:
    """Return the table of bounds against errors."""
    lines = [
        '## The certificate',
        '',
        'How often a bound was below the error (never, if the certificate holds), and how tight '
        'bounds are: the ratio of bound to error, where the error is more than rounding (16 times '
        "the spacing of floats at the pair's size). A ratio of 1 is a bound that could not be "
        'smaller.',
        '',
    ]
    headings = 'level', 'answers', 'bound below error', 'above rounding', 'ratio: median', 'worst'
    rows = []
    for level in LEVELS:
        mine = [r for r in records if r.setting == Setting(OURS, level)]
        ratios = [ratio for r in mine for ratio in r.ratios()]
        cells = (
            level,
            sum(len(r.answers) for r in mine),
            sum(len(r.violations()) for r in mine),
            len(ratios),
            f'{np.median(ratios):.2f}' if ratios else '',
            f'{max(ratios):.3g}' if ratios else '',
        )
        rows.append(cells)
    return '\n'.join([*lines, table(headings, rows)])


def _family(records: Sequence[Measured]) -> str:
    """Return a family's table, a row a setting."""
    headings = 'library', 'setting', 'median', '99 %', 'worst', 'bound', 'us per pair', 'no answer'
    rows = []
    for r in records:
        errors = [length(r.error(q), r.rounding()) for q in (0.5, 0.99, 1.0)]
        why = ', '.join(f'{n} {name}' for name, n in r.failures.items())
        asked = sum(r.verdicts.values())
        cells = [
            *(r.setting.library, r.setting.label, *errors),
            length(r.worst_bound(), 0.0),
            microseconds(r.whole) + (f' ({microseconds(r.inside)})' if r.whole else ''),
            f'{why} of {asked}' if why else '',
        ]
        rows.append(cells)
    return table(headings, rows)


def _each_case(records: Sequence[Measured]) -> str:
    """Return the table of our level exact, a row a case."""
    headings = 'case', 'query', 'median', 'worst', 'worst bound', 'us per pair', 'answers'
    rows = []
    for r in records:
        if r.setting == Setting(OURS, 'exact'):
            errors = [length(r.error(q), r.rounding()) for q in (0.5, 1.0)]
            cells = [r.case, r.query.replace('_', ' '), *errors, length(r.worst_bound(), 0.0)]
            cells += [f'{microseconds(r.whole)} ({microseconds(r.inside)})', str(len(r.answers))]
            rows.append(cells)
    return '## Level exact, case by case\n\n' + table(headings, rows)


def length(value: float, rounding: float) -> str:
    """Return a length [m] in two digits; what is less than the rounding as that."""
    if math.isnan(value):
        return ''
    return f'< {rounding:.0e}' if value < rounding else f'{value:.1e}'


def microseconds(seconds: float | None) -> str:
    """Return a time in microseconds."""
    return '' if seconds is None else three(1e6 * seconds)
