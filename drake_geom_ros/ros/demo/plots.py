"""distances.png: how close things came, how deep they touched, and when the filters changed."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from drake_geom_ros.ros.demo.recording import Recording

_MOST_LISTED = 12  # changes of filters that have a number and a line of text: the last ones
_MOST_LABELS = 12  # spells of contact that have a name; of more only the deepest one

# As the viewer has them.
_LEVELS = {'warn': '#e6be00', 'slow': '#ff7800', 'stop': '#ff0000', 'stoppable': '#c800a0'}
_BLUE, _ORANGE, _DEEP, _GREY = '#1f5fa8', '#d9822b', '#a63f00', '#555555'


def draw_distances(recording: Recording, path: Path) -> None:
    """Draw the smallest distances and the deepest penetration over time [mm, s]."""
    figure = Figure(figsize=(11.0, 6.4), layout='constrained')
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    _draw_smallest(upper, recording)
    _draw_deepest(lower, recording)
    # A long recording keeps its end: what changed before is not in the picture.
    first = recording.pairs[0].time if recording.pairs else recording.start
    changes = [each for each in enumerate(recording.changes, start=1) if each[1].time >= first]
    listed = changes[-_MOST_LISTED:]
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
        for number, change in changes:
            axes.axvline(change.time - recording.start, color=_GREY, lw=0.9, ls='--')
            if axes is upper and (number, change) in listed:
                axes.annotate(
                    str(number),
                    (change.time - recording.start, 1.0),
                    xycoords=('data', 'axes fraction'),
                    ha='center', va='bottom', fontsize=9, color='white',
                    bbox={'boxstyle': 'circle,pad=0.2', 'fc': _GREY, 'ec': 'none'},
                )  # fmt: skip
    lower.set_xlabel('time since the first result [s]')
    if listed:
        legend = '\n'.join(
            f'{number}  {change.time - recording.start:5.2f} s  {change.text}'
            for number, change in listed
        )
        which = '' if len(listed) == len(changes) else f', the last {len(listed)}'
        figure.supxlabel(
            f'Changes of the collision filters{which}\n{legend}', x=0.06, ha='left', fontsize=8.5,
            color=_GREY, family='monospace',
        )  # fmt: skip
    figure.savefig(path, dpi=130)


def _draw_smallest(axes: Any, recording: Recording) -> None:
    time = np.array([pairs.time for pairs in recording.pairs]) - recording.start
    smallest = [pairs.distance[0] if len(pairs.distance) else np.nan for pairs in recording.pairs]
    axes.plot(time, np.multiply(smallest, 1e3), color=_BLUE, lw=1.6, label='all pairs')
    if recording.between is not None:
        between = np.array([pairs.between for pairs in recording.pairs])
        between[np.isinf(between)] = np.nan
        label = f'{recording.between[0]} arm to {recording.between[1]} arm'
        axes.plot(time, between * 1e3, color=_ORANGE, lw=1.6, label=label)
    if recording.approach is not None:
        moment = recording.approach
        axes.plot(moment.time - recording.start, moment.distance * 1e3, 'o', color=_ORANGE, ms=7)
        axes.annotate(
            f'{moment.distance * 1e3:.1f} mm\n(closest.png)',
            (moment.time - recording.start, moment.distance * 1e3),
            xytext=(0, 34), textcoords='offset points', ha='center', fontsize=9, color=_ORANGE,
            arrowprops={'arrowstyle': '-', 'color': _ORANGE, 'lw': 0.8},
        )  # fmt: skip
    _mark_events(axes, recording)
    axes.axhline(0.0, color='black', lw=0.8)
    axes.set_ylabel('smallest signed distance [mm]')
    if np.isfinite(recording.max_distance):
        axes.set_title(
            f'Pairs farther apart than {recording.max_distance * 1e3:.0f} mm are not reported',
            fontsize=9, color=_GREY, loc='right', pad=14,
        )  # fmt: skip
    # Overlaps before the first filter was in place would hide the millimetres after it.
    shown = np.array([d for t, d in zip(time, smallest, strict=True) if t >= _settled(recording)])
    if np.isfinite(shown).any():
        axes.set_ylim(bottom=min(-15.0, 1.3e3 * np.nanmin(shown)))
    axes.legend(loc='lower left', bbox_to_anchor=(0.0, 1.05), ncols=4, frameon=False)


def _mark_events(axes: Any, recording: Recording) -> None:
    """Mark where proximity rules were entered (down) and left (up), in the colour of the level."""
    measured = [event for event in recording.events if np.isfinite(event.distance)]
    for level, colour in _LEVELS.items():
        for entered, marker in ((True, 'v'), (False, '^')):
            at = [
                (event.time - recording.start, event.distance * 1e3)
                for event in measured
                if event.level == level and event.entered == entered
            ]
            if at:
                axes.plot(
                    *np.transpose(at), marker, color=colour, ms=8, mec='black', mew=0.6, zorder=3,
                    label=f'{level} rule {"entered" if entered else "left"}',
                )  # fmt: skip


def _draw_deepest(axes: Any, recording: Recording) -> None:
    time = np.array([contact.time for contact in recording.contacts]) - recording.start
    depth = np.array([contact.depth for contact in recording.contacts]) * 1e3
    axes.fill_between(time, depth, color=_DEEP, alpha=0.25, lw=0)
    axes.plot(time, depth, color=_DEEP, lw=1.4)
    axes.set_ylabel('deepest penetration [mm]')
    top = depth[time >= _settled(recording)].max(initial=0.0)
    top = 1.7 * top if top > 0.0 else 1.0
    axes.set_ylim(0.0, top)
    # Labels of neighbours stand at two heights, so that they do not overlap.
    spells = _spells(recording)
    if len(spells) > _MOST_LABELS:
        spells = [max(spells, key=lambda spell: spell.depth)]
    for number, (name, begin, end, deepest) in enumerate(spells):
        middle = (begin + end) / 2 - recording.start
        label, height, align = name.replace(' - ', '\n'), deepest * 1e3, 'center'
        if height > top:
            label = f'{label}\n{height:.0f} mm, off the scale'
            middle, height, align = end - recording.start, 0.4 * top, 'left'
        axes.annotate(
            label, (middle, height), xytext=(0 if align == 'center' else 9, 4 + 22 * (number % 2)),
            textcoords='offset points', ha=align, va='bottom', fontsize=7.5, color=_DEEP,
            bbox={'facecolor': 'white', 'edgecolor': 'none', 'pad': 1.0},  # above other lines
        )  # fmt: skip


def _settled(recording: Recording) -> float:
    """Return the time [s] since the start from which on the scales count: the first filter's."""
    return recording.changes[0].time - recording.start if recording.changes else 0.0


class _Spell(NamedTuple):
    """An unbroken time of contact [s], with the deepest pair's name and depth [m]."""

    name: str
    begin: float
    end: float
    depth: float


def _spells(recording: Recording) -> list[_Spell]:
    """Return the unbroken times of contact."""
    spells = []
    run = []
    for contact in [*recording.contacts, None]:
        if contact is not None and contact.depth > 0.0:
            run.append(contact)
        elif run:
            deepest = max(run, key=lambda c: c.depth)
            name = recording.scene.pair_name(deepest.id_a, deepest.id_b)
            spells.append(_Spell(name, run[0].time, run[-1].time, deepest.depth))
            run = []
    return spells
