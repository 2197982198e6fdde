"""``report.html``: one file that opens anywhere without a network."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from html import escape
from typing import Any

import numpy as np

from drake_geom_ros.recordings.audit import Audit
from drake_geom_ros.recordings.comparing import SetComparison
from drake_geom_ros.recordings.highlights import below, closest, contacts, held
from drake_geom_ros.recordings.results import Clearances, Moment, SetClearance
from drake_geom_ros.recordings.storages import NANOSECONDS

Pictures = Mapping[tuple[str, int], bytes]  # PNGs by the set and the number of a moment
MOMENTS = 10  # in the table of each set of pairs
_MOST_CONTACTS = 100
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
    found: Clearances,
    thresholds: Sequence[float],
    title: str,
    files: Iterable[str],
    plot: bytes,
    audited: Audit | None = None,
    pictures: Pictures | None = None,
    compared: Sequence[SetComparison] | None = None,
) -> str:
    """Return the report as HTML, the plot (a PNG) in it."""
    begin = datetime.fromtimestamp(found.begin / NANOSECONDS, timezone.utc)
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<p>{begin:%Y-%m-%d %H:%M:%S} UTC, {found.duration:.3f} s, {len(found.times)} states. '
        f'Files: {escape(", ".join(files))}.</p>',
        _reservations(found.reservations()),
        f'<img alt="least distances over time" src="{_data(plot)}">',
    ]
    for pairs in found.sets.values():
        parts += _of_set(found, pairs, thresholds, pictures or {})
    parts += _troubles(found)
    parts += [] if audited is None else _audited(audited)
    parts += [] if compared is None else _compared(compared)
    parts.append(
        f'<p>Read and played in {found.seconds_reading:.2f} s, computed in '
        f'{found.seconds_computing:.2f} s.</p>'
    )
    body = '\n'.join(parts)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
        f'</title><style>{_STYLE}</style></head><body>\n{body}\n</body></html>\n'
    )


def _data(picture: bytes) -> str:
    """Return a PNG as the address of an image."""
    return f'data:image/png;base64,{b64encode(picture).decode()}'


def _reservations(told: Sequence[str], of: str = '') -> str:
    if not told:
        return f'<p class="good">{of}Every state tells of all pairs, by fresh poses.</p>'
    return _warning(f'{of}Not all is known:', told)


def _warning(head: str, told: Sequence[str]) -> str:
    listed = ''.join(f'<li>{escape(each)}</li>' for each in told)
    return f'<div class="warn">{head}<ul>{listed}</ul></div>'


def _of_set(
    found: Clearances, pairs: SetClearance, thresholds: Sequence[float], pictures: Pictures
) -> list[str]:
    time = held(found, pairs)
    ages = pairs.age[np.isfinite(pairs.age)]
    oldest = f'{ages.max():.3f} s, median {np.median(ages):.3f} s' if len(ages) else 'unknown'
    unknown = len(pairs.age) - len(ages)
    lows = [below(found, pairs, threshold) for threshold in thresholds]
    touching = contacts(pairs)
    return [
        f'<h2>{escape(pairs.name)}</h2>',
        '<h3>Closest moments</h3>',
        _table(
            ('', 'time [s]', 'distance [m]', 'error bound [m]', 'between', 'and', 'state'),
            (
                (k + 1, *_moment(pairs.at(state)), _state(pairs, state))
                for k, state in enumerate(closest(found, pairs, MOMENTS))
            ),
        ),
        *(
            f'<figure><img alt="moment {number}" src="{_data(picture)}">'
            f'<figcaption>{number}</figcaption></figure>'
            for (name, number), picture in sorted(pictures.items())
            if name == pairs.name
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
                for c in touching[:_MOST_CONTACTS]
            ),
        )
        + (
            f'<p>and {len(touching) - _MOST_CONTACTS} more, see clearance.csv.</p>'
            if len(touching) > _MOST_CONTACTS
            else ''
        ),
        '<h3>Time not certified to be above a threshold</h3>',
        _table(
            ('threshold [m]', 'time [s]', 'and where not all is known, by what is [s]'),
            ((f'{low.threshold:g}', f'{low.seconds:.3f}', f'{low.at_known:.3f}') for low in lows),
        ),
        *_motion(pairs),
        '<h3>What is known</h3>',
        _table(
            ('all pairs [s]', 'stale [s]', 'pairs left out [s]', 'nothing recorded [s]'),
            [[f'{seconds:.3f}' for seconds in time]],
        ),
        f'<p>Oldest pose that mattered: {oldest}; in {unknown} states its age is unknown. A pose '
        f'is stale after {found.stale_after:g} s.</p>',
    ]


def _motion(pairs: SetClearance) -> list[str]:
    if pairs.motion is None:
        return []
    told = pairs.certified()
    where = 'nowhere' if told.span is None else f'{told.span.begin:.3f} to {told.span.end:.3f}'
    heads = 'least certified [m]', 'at [s]', 'clear', 'contact', 'unknown'
    return [
        '<h3>Motions between states</h3>',
        _table(heads, [(f'{told.lower_bound:.9g}', where, *told[2:])]),
    ]


def _state(pairs: SetClearance, state: int) -> str:
    words = []
    if pairs.is_waiting[state]:
        words.append(f'{int(pairs.left_out[state])} pairs left out')
    if pairs.is_stale[state]:
        words.append(f'poses {pairs.age[state]:.3f} s old')
    return ', '.join(words) or 'all known'


def _moment(moment: Moment) -> tuple[str, ...]:
    numbers = f'{moment.time:.3f}', f'{moment.distance:.9g}', f'{moment.error_bound:.2g}'
    return (*numbers, moment.name_A, moment.name_B)


def _audited(audited: Audit) -> list[str]:
    counts = audited.counts().items()
    heads = 'topic', 'outcome', 'how many', 'the first at [s]', 'what', 'because'
    return [
        '<h2>What the node said, computed again</h2>',
        *([_warning('Not audited:', told)] if (told := audited.reservations()) else []),
        _table(('', 'results and events'), [(outcome.value, n) for outcome, n in counts]),
        _table(
            heads,
            (
                (topic, e.outcome.value, count, f'{e.time:.3f}', e.what, e.because)
                for topic, e, count in audited.by_reason()
            ),
        ),
    ]


def _compared(compared: Sequence[SetComparison]) -> list[str]:
    """Return how much nearer the run comes than another one, and what is not known of that."""
    rows = []
    for each in compared:
        much, where = each.nearer(allow_incomplete=True)
        unknown = int(np.count_nonzero(~each.is_whole))
        rows.append((each.name, f'{much:.9g}', f'{where:.3f}', f'{unknown} of {len(each.run)}'))
    return [
        '<h2>Beside the other run</h2>',
        _reservations(compared[0].not_known_of_other, 'The other run: '),
        _table(('pairs', 'nearer by [m]', 'at', 'parts not known of both'), rows),
    ]


def _troubles(found: Clearances) -> list[str]:
    if not found.troubles:
        return []
    return [
        '<h2>What was wrong</h2>',
        _table(
            ('from [s]', 'to [s]', 'seen', ''),
            (
                (
                    *(f'{(t - found.begin) / NANOSECONDS:.3f}' for t in (each.first, each.last)),
                    each.seen,
                    each.words,
                )
                for each in found.troubles
            ),
        ),
    ]


def _table(heads: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table; none where there are no rows."""
    lines = [''.join(_cell(value) for value in row) for row in rows]
    if not lines:
        return '<p>None.</p>'
    head = ''.join(f'<th>{escape(text)}</th>' for text in heads)
    return f'<table><tr>{head}</tr>' + ''.join(f'<tr>{line}</tr>' for line in lines) + '</table>'


def _cell(value: Any) -> str:
    text = str(value)
    is_number = text[:1].isdigit() or text[:1] == '-'
    return f'<td{" class=n" if is_number else ""}>{escape(text)}</td>'
