"""Plot of distances over time for a report; unknown times are grey, and no line crosses them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.highlights import Highlights
from drake_geom_ros.recordings.results import RunAnalysis
from drake_geom_ros.recordings.set_clearance import SetClearance, Span

MOMENTS = 5  # marked in each set of pairs
# Colours of the commonest pairs, which colour-blind readers tell apart (Okabe and Ito 2008).
_PALETTE = ('#0072b2', '#e69f00', '#56b4e9', '#d55e00', '#cc79a7', '#8c6d31', '#17a2a2', '#404040')
_DOTS = 110  # an inch
_GREY, _OTHERS, _KNOWN = '0.85', '0.35', '0.55'
_MARGIN = 0.05  # above and below the data, as a fraction of their height
_BESIDE = 0.01  # beside the data, as a fraction of their width


def draw(
    run: RunAnalysis,
    highlights: Mapping[str, Highlights],
    thresholds: Sequence[float],
    title: str,
) -> bytes:
    """Return a PNG with axes for each set of pairs; RecordingError without matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise RecordingError(
            f"the plot takes matplotlib: pip install matplotlib, or the extra 'pictures' ({error})"
        ) from None
    rows = len(highlights)
    figure = Figure(figsize=(12.0, 1.0 + 3.4 * rows), dpi=_DOTS, layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
    for place, each in zip(axes, highlights.values(), strict=True):
        _draw_set(place, run, each, thresholds)
    axes[-1].set_xlabel('time since the recording began [s]')
    end = max(run.duration, run.stale_after / 2)
    axes[-1].set_xlim(-_BESIDE * end, (1.0 + _BESIDE) * end)  # shows marks at the ends whole
    figure.suptitle(plain(title))
    picture = BytesIO()
    figure.savefig(picture, format='png')
    return picture.getvalue()


def plain(name: str) -> str:
    """Return a name escaped so that matplotlib neither parses it as a formula nor hides it."""
    escaped = name.replace('$', r'\$')
    return f' {escaped}' if escaped.startswith('_') else escaped


def _draw_set(
    axes: Any, run: RunAnalysis, highlights: Highlights, thresholds: Sequence[float]
) -> None:
    pairs = highlights.shown
    _shade_thresholds(axes, thresholds)
    _shade_unknown(axes, [*run.gaps, *highlights.lost])
    whole, times, distances = pairs.is_whole, pairs.times, pairs.known_distance
    far = distances == np.inf
    top = _limits(axes, distances, thresholds, run.max_distance)
    line = np.where(whole & ~far, distances, np.nan)
    # The line is interrupted at gaps.
    breaks = np.flatnonzero(np.diff(times) > run.stale_after) + 1
    axes.plot(
        np.insert(times, breaks, np.nan), np.insert(line, breaks, np.nan), color='0.6', lw=0.8
    )
    if far.any():
        label = f'all farther than {run.max_distance:g} m'
        axes.plot(
            times[far & whole],
            np.full((far & whole).sum(), top),
            '|',
            color='0.6',
            label=label,
            ms=3,
            mew=0.5,
        )
    some = ~whole & np.isfinite(distances)
    axes.plot(
        times[some],
        distances[some],
        '.',
        color=_KNOWN,
        ms=3,
        alpha=0.7,
        label='what is known, where not all is' if some.any() else None,
    )
    _colour_pairs(axes, pairs, np.flatnonzero(whole & ~far))
    for number, close in enumerate(run.moments[pairs.name][:MOMENTS]):
        at = close.moment.time, close.moment.distance
        axes.plot(*at, 'v', color='black', ms=7, zorder=5)
        axes.annotate(f'{number + 1}', at, (9, -12), textcoords='offset points')
    axes.set_ylabel('least distance [m]')
    axes.set_title(plain(pairs.name), loc='left', fontsize='medium')
    axes.legend(fontsize='x-small', loc='upper left', bbox_to_anchor=(1.0, 1.0), frameon=False)


def _limits(
    axes: Any, distances: NDArray[np.float64], thresholds: Sequence[float], farthest: float
) -> float:
    """Set the limits of the distances; return the height for states beyond ``farthest``."""
    finite = distances[np.isfinite(distances)]
    top = farthest if np.isfinite(farthest) else float(finite.max(initial=0.0))
    ends = [*finite.tolist(), *thresholds, top]
    low, high = min(ends), max(ends)
    margin = _MARGIN * (high - low) or _MARGIN
    axes.set_ylim(low - margin, high + 2 * margin)
    return top


def _shade_thresholds(axes: Any, thresholds: Sequence[float]) -> None:
    for k, threshold in enumerate(sorted(thresholds, reverse=True)):
        colour = ('#f5a742', '#d95f02')[min(k, 1)] if threshold > 0.0 else '#7a3000'
        axes.axhspan(-1e9, threshold, color=colour, alpha=0.12, lw=0)
        label = (
            f'threshold {threshold:g} m'  # in the legend, since data would cover it at the line
        )
        axes.axhline(threshold, color=colour, lw=0.8, ls='--', zorder=1, label=label)


def _shade_unknown(axes: Any, spans: Sequence[Span]) -> None:
    """Shade gaps and times of incomplete states in grey."""
    for k, (begin, end) in enumerate(spans):
        label = None if k else 'not, or not all, known'
        axes.axvspan(begin, max(end, begin), color=_GREY, lw=0.5, zorder=0.5, label=label)


def _colour_pairs(axes: Any, pairs: SetClearance, states: NDArray[np.int64]) -> None:
    """Draw states in the colours of their pairs, with one colour for rare pairs."""
    a, b = pairs.geometry_A[states].tolist(), pairs.geometry_B[states].tolist()
    nearest = Counter(zip(a, b, strict=True)).most_common(len(_PALETTE))
    left = np.ones(len(states), dtype=np.bool_)
    for k, ((first, second), _) in enumerate(nearest):
        own = (pairs.geometry_A[states] == first) & (pairs.geometry_B[states] == second)
        left &= ~own
        both = f'{pairs.names[first]} and {pairs.names[second]}' if first >= 0 else 'no pair'
        label = plain(both)
        at = states[own]
        axes.plot(
            pairs.times[at],
            pairs.known_distance[at],
            '.',
            ms=3.5,
            color=_PALETTE[k],
            label=label,
        )
    if left.any():
        at = states[left]
        axes.plot(
            pairs.times[at],
            pairs.known_distance[at],
            '.',
            ms=3.5,
            color=_OTHERS,
            label='other pairs',
        )
