"""Plot that acts as a slider: a click or drag in it is one on the slider's track.

viser's plots report no clicks, but its sliders do. Therefore this HTML styles the slider right
after it: the track is as high as a plot and has the plot as background, and the thumb is the line
of the current moment. Only the style changes; events are those of viser's own slider.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from urllib.parse import quote

import numpy as np

from drake_geom_ros.math.array_types import Floats

_SLIDER = 'div:has(> .least-distances) + div .mantine-Slider-'
# mantine-Slider-* are the public names by which Mantine, which draws viser's panels, is styled.
_RULES = """
{slider}trackContainer, {slider}track, {slider}thumb {{height: 9rem !important}}
{slider}track::before {{inset: 0; border-radius: 0; background: #f4f4f4 url("{picture}")}}
{slider}bar, {slider}mark {{display: none}}
{slider}root {{height: 10.5rem}}
{slider}markLabel {{margin-top: 8.7rem}}
{slider}thumb {{width: 2px !important; min-width: 0; border: 0; border-radius: 0;
 background: #e03131 !important}}
"""
_SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="100%" height="100%">
<svg viewBox="0 0 1 1" preserveAspectRatio="none" width="100%" height="100%">
<rect y="{zero}" width="1" height="1" fill="#ffe3e3"/>{strip}
<polyline points="{points}" fill="none" stroke="#2b8a3e" stroke-width="1.5"
 vector-effect="non-scaling-stroke"/></svg>
<g font-family="sans-serif" font-size="10" fill="#495057">
<text x="3" y="11">{most}</text><text x="3" y="100%" dy="-3">{least}</text></g></svg>"""
_DIGITS = 6  # decimals of a distance [m], as many as in texts; the others are noise
_STRIP = 0.05  # of the height
_COLOURS = {'clear': '#2b8a3e', 'contact': '#e03131', 'unknown': '#f08c00'}
_MARGIN = 0.12  # of the height, for texts above and below the line


def plot(
    times: Floats,
    least: Floats,
    start: float,
    end: float,
    outcomes: Sequence[str] = (),
    unproved: str = '',
) -> str:
    """Return HTML that turns the next slider into a plot, from ``start`` to ``end`` [s].

    ``least`` (n,) [m] are the minimum distances at ``times`` (n,) [s], NaN where unknown.
    ``outcomes`` (k,) are those of ``CheckMotion`` for the first pieces between these times, drawn
    as a coloured strip at the bottom. ``unproved`` is the reason why nothing is proved.
    """
    is_known, least = np.isfinite(least), np.round(least, _DIGITS)
    picture = ''
    if is_known.any():
        low, high = float(least[is_known].min()), float(least[is_known].max())
        xs = (times[is_known] - start) / max(end - start, np.finfo(float).tiny)
        points = zip(xs.tolist(), _heights(least[is_known], low, high).tolist(), strict=True)
        picture = _SVG.format(
            zero=f'{max(0.0, float(_heights(np.zeros(1), low, high)[0])):.4f}',
            points=' '.join(f'{x:.4f},{y:.4f}' for x, y in points),
            most=f'{1e3 * high:.3f} mm',
            least=f'{1e3 * low:.3f} mm',
            strip=_strip((times - start) / max(end - start, np.finfo(float).tiny), outcomes),
        )
    rules = _RULES.format(slider=_SLIDER, picture='data:image/svg+xml,' + quote(picture))
    caption = 'least distance over time: click in it, or drag'
    if outcomes:
        words = (f'<b style="color:{colour}">{word}</b>' for word, colour in _COLOURS.items())
        caption += f'<br>for all times of a piece, straight from pose to pose: {", ".join(words)}'
    if unproved:
        caption += f'<br><b>nothing is proved between the moments: {escape(unproved)}</b>'
    return (
        f'<div class="least-distances" style="padding:0 1em">{caption}</div><style>{rules}</style>'
    )


def _strip(xs: Floats, outcomes: Sequence[str]) -> str:
    """Return rectangles for pieces between xs (n,), one for each run of equal outcomes."""
    rectangles, first = '', 0
    for k, outcome in enumerate(outcomes):
        if k + 1 == len(outcomes) or outcomes[k + 1] != outcome:
            rectangles += (
                f'<rect x="{xs[first]:.4f}" y="{1.0 - _STRIP}" height="{_STRIP}" '
                f'width="{xs[k + 1] - xs[first]:.4f}" fill="{_COLOURS[outcome]}"/>'
            )
            first = k + 1
    return rectangles


def _heights(least: Floats, low: float, high: float) -> Floats:
    """Return heights of distances [m] in the plot: 0 at its top, 1 at its bottom."""
    span = max(high - low, np.finfo(float).tiny)
    return _MARGIN + (1.0 - 2.0 * _MARGIN) * (high - least) / span
