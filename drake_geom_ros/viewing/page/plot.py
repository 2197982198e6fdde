"""A plot that is a slider: a click in it, or a drag, is one on the track of the slider.

Plots of viser tell nothing of clicks, but its sliders do. So the track of the slider that comes
right after this HTML is made as high as a plot, shows the plot as its background, and its thumb is
the line of the moment. It is a matter of looks only: what moves and tells is viser's own slider.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
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
_DIGITS = 6  # of a distance in metres, those of the texts: what is less is noise
_STRIP = 0.05  # of the height
_COLOURS = {'clear': '#2b8a3e', 'contact': '#e03131', 'unknown': '#f08c00'}
_MARGIN = 0.12  # of the height, above and below the line: there the texts are


def plot(
    times: Floats,
    least: Floats,
    start: float,
    end: float,
    outcomes: Sequence[str] = (),
    unproved: str = '',
) -> str:
    """Return the HTML that makes a plot of the slider after it, from ``start`` to ``end`` [s].

    ``least`` (n,) [m] are the least distances at ``times`` (n,) [s], NaN where none is known.
    ``outcomes`` (k,) are what is proved of the first pieces between these times, as of
    ``CheckMotion``: a strip at the bottom, in the colours of the words above it. ``unproved`` is
    why nothing is proved.
    """
    known, least = np.isfinite(least), np.round(least, _DIGITS)
    picture = ''
    if known.any():
        low, high = float(least[known].min()), float(least[known].max())
        xs = (times[known] - start) / max(end - start, np.finfo(float).tiny)
        points = zip(xs.tolist(), _heights(least[known], low, high).tolist(), strict=True)
        picture = _SVG.format(
            zero=f'{max(0.0, float(_heights(np.zeros(1), low, high)[0])):.4f}',
            points=' '.join(f'{x:.4f},{y:.4f}' for x, y in points),
            most=f'{1e3 * high:.3f} mm',
            least=f'{1e3 * low:.3f} mm',
            strip=_strip((times - start) / max(end - start, np.finfo(float).tiny), outcomes),
        )
    rules = _RULES.format(slider=_SLIDER, picture='data:image/svg+xml,' + quote(picture))
    said = 'least distance over time: click in it, or drag'
    if outcomes:
        words = (f'<b style="color:{colour}">{word}</b>' for word, colour in _COLOURS.items())
        said += f'<br>for all times of a piece, straight from pose to pose: {", ".join(words)}'
    if unproved:
        said += f'<br><b>nothing is proved between the moments: {escape(unproved)}</b>'
    return f'<div class="least-distances" style="padding:0 1em">{said}</div><style>{rules}</style>'


def _strip(xs: Floats, outcomes: Sequence[str]) -> str:
    """Return rectangles for pieces between xs (n,), one for neighbours of the same outcome."""
    found, first = '', 0
    for k, outcome in enumerate(outcomes):
        if k + 1 == len(outcomes) or outcomes[k + 1] != outcome:
            found += (
                f'<rect x="{xs[first]:.4f}" y="{1.0 - _STRIP}" height="{_STRIP}" '
                f'width="{xs[k + 1] - xs[first]:.4f}" fill="{_COLOURS[outcome]}"/>'
            )
            first = k + 1
    return found


def _heights(least: Floats, low: float, high: float) -> Floats:
    """Return where distances [m] are drawn: 0 at the top of the plot, 1 at its bottom."""
    span = max(high - low, np.finfo(float).tiny)
    return _MARGIN + (1.0 - 2.0 * _MARGIN) * (high - least) / span
