"""Page ``report.html`` of a report, one self-contained file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from html import escape
from typing import Any

import numpy as np

from drake_geom_ros.recordings.audit import Audit
from drake_geom_ros.recordings.close_moments import CloseMoment
from drake_geom_ros.recordings.comparing import PairDifference, SetComparison
from drake_geom_ros.recordings.highlights import AGES, Ages, Highlights
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.results import RunAnalysis
from drake_geom_ros.recordings.set_clearance import Moment

Pictures = Mapping[tuple[str, int], bytes]  # PNGs by the set and the number of a moment
MOMENTS = 10  # in the table of each set of pairs
PAIRS = 20  # of two runs
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 76em; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0 1.4em; }
th, td { border-bottom: 1px solid #ccc; padding: 0.25em 0.8em; text-align: left; }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
img { max-width: 100%; }
figure { display: inline-block; margin: 0 1em 1em 0; width: 23em; }
.warn { background: #fff3d6; border-left: 4px solid #d98e00; padding: 0.6em 1em; }
.good { background: #e8f5e9; border-left: 4px solid #388e3c; padding: 0.6em 1em; }
"""


def page(
    run: RunAnalysis,
    highlights: Mapping[str, Highlights],
    title: str,
    files: Iterable[str],
    plot: bytes,
    audited: Audit | None = None,
    pictures: Pictures | None = None,
    compared: Sequence[SetComparison] | None = None,
    beside: bytes = b'',
) -> str:
    """Return the report as HTML, with the PNG ``plot``, and ``beside`` if runs are compared."""
    begin = datetime.fromtimestamp(run.begin / NANOSECONDS, timezone.utc)
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<p>{begin:%Y-%m-%d %H:%M:%S} UTC, {run.duration:.3f} s, {run.count} states. '
        f'Files: {escape(", ".join(files))}.</p>',
        _reservations(run.reservations()),
        f'<img alt="least distances over time" src="{_data(plot)}">',
    ]
    for name, each in highlights.items():
        parts += _of_set(run, name, each, pictures or {})
    parts += _troubles(run)
    parts += [] if audited is None else _audited(audited)
    parts += [] if compared is None else _compared(compared, beside)
    parts.append(
        f'<p>Read and played in {run.seconds_reading:.2f} s, computed in '
        f'{run.seconds_computing:.2f} s.</p>'
    )
    body = '\n'.join(parts)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
        f'</title><style>{_STYLE}</style></head><body>\n{body}\n</body></html>\n'
    )


def _data(picture: bytes) -> str:
    """Return a PNG as a data URL."""
    return f'data:image/png;base64,{b64encode(picture).decode()}'


def _reservations(reservations: Sequence[str], of: str = '') -> str:
    if not reservations:
        return f'<p class="good">{of}Every state tells of all pairs, by fresh poses.</p>'
    return _warning(f'{of}Not all is known:', reservations)


def _warning(head: str, items: Sequence[str]) -> str:
    listed = ''.join(f'<li>{escape(each)}</li>' for each in items)
    return f'<div class="warn">{head}<ul>{listed}</ul></div>'


def _caption(number: int, moment: Moment) -> str:
    """Return which moment a picture shows: its pair, distance and time."""
    pair = f'{moment.name_A} and {moment.name_B}'
    return escape(f'{number}: {pair}, {1e3 * moment.distance:.1f} mm at {moment.time:.3f} s')


def _of_set(run: RunAnalysis, name: str, highlights: Highlights, pictures: Pictures) -> list[str]:
    more = highlights.contact_count - len(highlights.contacts)
    return [
        f'<h2>{escape(name)}</h2>',
        '<h3>Closest moments</h3>',
        _table(
            ('', 'time [s]', 'distance [m]', 'error bound [m]', 'between', 'and', 'state'),
            (
                (k, *_moment(close.moment), _state(close))
                for k, close in enumerate(run.moments[name][:MOMENTS], 1)
            ),
        ),
        *(
            f'<figure><img alt="moment {number}" src="{_data(picture)}">'
            f'<figcaption>{_caption(number, run.moments[name][number - 1].moment)}</figcaption>'
            '</figure>'
            for (of, number), picture in sorted(pictures.items())
            if of == name
        ),
        '<h3>Contacts, or not certified to be apart</h3>',
        _table(
            (
                'from [s]',
                'to [s]',
                'states',
                'deepest at [s]',
                'distance [m]',
                'error bound [m]',
                'between',
                'and',
            ),
            (
                (f'{c.begin:.3f}', f'{c.end:.3f}', c.states, *_moment(c.deepest))
                for c in highlights.contacts
            ),
        )
        + (f'<p>and {more} more, see clearance.csv.</p>' if more else ''),
        '<h3>Time not certified to be above a threshold</h3>',
        _table(
            ('threshold [m]', 'time [s]', 'and where not all is known, by what is [s]'),
            (
                (f'{low.threshold:g}', f'{low.seconds:.3f}', f'{low.at_known:.3f}')
                for low in highlights.below
            ),
        ),
        *_motion(run, name),
        '<h3>What is known</h3>',
        _table(
            ('all pairs [s]', 'stale [s]', 'pairs left out [s]', 'nothing recorded [s]'),
            [[f'{seconds:.3f}' for seconds in highlights.held]],
        ),
        '<h3>How old data were</h3>',
        *_how_old(highlights.ages),
        f'<p>A pose is stale after {run.stale_after:g} s. The longest time without a state is '
        f'{run.silence.end - run.silence.begin:.3f} s, from {run.silence.begin:.3f} s.</p>',
    ]


def _how_old(ages: Ages) -> list[str]:
    """Return the maximum age of used poses, and a table of states by it."""
    oldest = 'unknown' if np.isnan(ages.oldest) else f'{ages.oldest:.3f} s'
    steps = [*(f'up to {age:g} s' for age in AGES), f'more than {AGES[-1]:g} s', 'unknown']
    rows = zip(steps, (*ages.counts, ages.unknown), strict=True)
    return [
        f'<p>The oldest pose that mattered at a state was {oldest} old at most.</p>',
        _table(('oldest pose', 'states'), ((step, count) for step, count in rows if count)),
    ]


def _motion(run: RunAnalysis, name: str) -> list[str]:
    if not run.is_certified:
        return []
    certified = run.certified(name)
    where = (
        'nowhere'
        if certified.span is None
        else f'{certified.span.begin:.3f} to {certified.span.end:.3f}'
    )
    heads = 'least certified [m]', 'at [s]', 'clear', 'contact', 'unknown'
    return [
        '<h3>Motions between states</h3>',
        _table(heads, [(f'{certified.lower_bound:.9g}', where, *certified[2:])]),
    ]


def _state(close: CloseMoment) -> str:
    words = []
    if close.left_out:
        words.append(f'{close.left_out} pairs left out')
    if close.is_stale:
        words.append(f'poses {close.age:.3f} s old')
    return ', '.join(words) or 'all known'


def _moment(moment: Moment) -> tuple[str, ...]:
    numbers = f'{moment.time:.3f}', f'{moment.distance:.9g}', f'{moment.error_bound:.2g}'
    return (*numbers, moment.name_A, moment.name_B)


def _audited(audited: Audit) -> list[str]:
    counts = audited.counts().items()
    heads = 'topic', 'outcome', 'how many', 'the first at [s]', 'what', 'because'
    return [
        '<h2>What the node said, computed again</h2>',
        *([_warning('Not audited:', items)] if (items := audited.reservations()) else []),
        _table(('', 'results and events'), [(outcome.value, n) for outcome, n in counts]),
        '<h3>What was not confirmed, and why</h3>',
        _table(
            heads,
            (
                (topic, e.outcome.value, count, f'{e.time:.3f}', e.what, e.because)
                for topic, e, count in audited.by_reason()
            ),
        ),
    ]


def _compared(compared: Sequence[SetComparison], beside: bytes) -> list[str]:
    """Return the comparison with another run, and the reservations about it."""
    rows = []
    for each in compared:
        much, where = each.nearer(allow_incomplete=True)
        unknown = int(np.count_nonzero(~each.is_whole))
        unit = 's' if each.by == 'time' else 'of the motion'
        parts = f'{unknown} of {len(each.run)}'
        rows.append((each.name, f'{much:.9g}', f'{where:.3f} {unit}', parts))
    heads = 'between', 'and', 'least distance [m]', 'in the other run [m]', 'difference [m]'
    return [
        '<h2>Beside the other run</h2>',
        _reservations(compared[0].not_known_of_other, 'The other run: '),
        _table(('pairs', 'nearer by [m]', 'at', 'parts not known of both'), rows),
        f'<img alt="least distances of both runs" src="{_data(beside)}">',
        *(
            f'<h3>{escape(each.name)}: pairs where they were the nearest</h3>'
            + _table(heads, map(_pair, each.pairs[:PAIRS]))
            + (f'<p>and {more} more.</p>' if (more := len(each.pairs) - PAIRS) > 0 else '')
            for each in compared
        ),
    ]


def _pair(pair: PairDifference) -> tuple[str, ...]:
    """Return the cells of a pair in two runs; without a distance where it never was nearest."""
    both = tuple(
        'never the nearest' if least == np.inf else f'{least:.9g}'
        for least in (pair.run, pair.other)
    )
    is_known = np.isfinite([pair.run, pair.other]).all()
    return pair.name_A, pair.name_B, *both, f'{pair.run - pair.other:.6g}' if is_known else ''


def _troubles(run: RunAnalysis) -> list[str]:
    if not run.troubles:
        return []
    return [
        '<h2>What was wrong</h2>',
        _table(
            ('from [s]', 'to [s]', 'seen', ''),
            (
                (
                    *(f'{(t - run.begin) / NANOSECONDS:.3f}' for t in (each.first, each.last)),
                    each.seen,
                    each.words,
                )
                for each in run.troubles
            ),
        ),
    ]


def _table(heads: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table, or 'None.' without rows."""
    lines = [''.join(_cell(value) for value in row) for row in rows]
    if not lines:
        return '<p>None.</p>'
    head = ''.join(f'<th>{escape(text)}</th>' for text in heads)
    return f'<table><tr>{head}</tr>' + ''.join(f'<tr>{line}</tr>' for line in lines) + '</table>'


def _cell(value: Any) -> str:
    text = str(value)
    try:
        float(text)
    except ValueError:
        return f'<td>{escape(text)}</td>'
    return f'<td class=n>{text}</td>'
