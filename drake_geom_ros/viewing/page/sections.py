"""Sections of the board: a moment of a scene as browsers get it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from drake_geom_ros.geometry import HalfSpace
from drake_geom_ros.viewing.cell_layers import CELL_LAYERS, CellLayer
from drake_geom_ros.viewing.looks import PAIR_COLOURS, Colour
from drake_geom_ros.viewing.page.motion_control import MotionControl, plain_joint
from drake_geom_ros.viewing.rules import COLOURS
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownMoment

MOST_ROWS = 1000  # pairs of the table, the nearest ones
_DIGITS = 9  # of distances [m] in the table


def scene_section(geometries: ShownGeometries, title: str) -> dict[str, Any]:
    """Return names of all bodies, and the sources with their colours."""
    sources: dict[str, list[int]] = {}
    # Half spaces are grey, whatever the colour of their source.
    for look in sorted(geometries.looks, key=lambda look: isinstance(look.shape, HalfSpace)):
        sources.setdefault(look.name.partition('::')[0], _bytes(look.colour))
    shown = set(geometries.ids.tolist())
    return {
        'title': title,
        'bodies': [
            [value, name, geometries.short_names[value], value in shown]
            for value, name in geometries.names.items()
        ],
        'sources': sorted(sources.items()),
        'legend': {
            **{name: _bytes(colour) for name, colour in PAIR_COLOURS.items()},
            **{f'rule {level.name.lower()}': list(colour) for level, colour in COLOURS.items()},
        },
    }


def pairs_section(moment: ShownMoment) -> dict[str, Any]:
    """Return the nearest pairs, and how many there are."""
    pairs = moment.pairs.rows(slice(MOST_ROWS))
    columns = (
        *(pairs.ids[:, 0].tolist(), pairs.ids[:, 1].tolist()),
        *(np.round(pairs.distance, _DIGITS).tolist(), pairs.error_bound.tolist()),
    )
    return {
        'rows': list(zip(*columns, strict=True)),
        'count': len(moment.pairs),
        'overlaps': int((moment.pairs.distance < 0.0).sum()),
    }


def rules_section(moment: ShownMoment) -> list[dict[str, Any]]:
    """Return the rules with their states, entered ones first."""
    rows = []
    for rule in sorted(moment.rules, key=lambda rule: not rule.is_entered):
        row = None if rule.pair is None else moment.pairs.find(rule.pair)
        rows.append(
            {
                'name': rule.name,
                'level': rule.level.name.lower(),
                'entered': rule.is_entered,
                'said': rule.said,
                'pair': rule.pair,
                'distance': None if row is None else float(moment.pairs.distance[row]),
                'colour': list(COLOURS[rule.level]),
            }
        )
    return rows


def sensors_section(moment: ShownMoment) -> dict[str, Any]:
    """Return the sensed maps: a row for each source, with its cells by kind."""
    sources: dict[str, dict[str, int]] = {}
    for layer in moment.cells:
        sources.setdefault(layer.source, {})[layer.kind] = len(layer.centres)
    return {
        'kinds': list(CELL_LAYERS.items()),
        'rows': [[source, counts] for source, counts in sorted(sources.items())],
        'colours': sorted(
            {(_in_legend(layer), *_bytes(layer.colour)) for layer in moment.cells if layer.is_seen}
        ),
    }


def _in_legend(layer: CellLayer) -> str:
    """Return what a layer is called in the legend: cells have a colour by the age of the map."""
    label = CELL_LAYERS[layer.kind]
    return f'{layer.source}, {label}' if layer.kind == 'obstacles' else label


def tables_section(moment: ShownMoment) -> list[dict[str, Any]]:
    """Return the tables of a running node."""
    return [
        {
            'title': table.title,
            'columns': list(table.columns),
            'rows': [[list(row.cells), row.warns, row.pair] for row in table.rows],
            'empty': table.empty,
        }
        for table in moment.tables
    ]


def timeline_section(motion: MotionControl) -> dict[str, Any] | None:
    """Return the minimum distances over time as known so far; None without a motion."""
    if motion.timeline is None:
        return None
    return {
        'start': motion.timeline.start,
        'end': motion.timeline.end,
        'times': np.round(motion.timeline.times, 6).tolist(),
        'least': np.round(motion.least, _DIGITS).tolist(),
        'outcomes': list(motion.proved),
        'unproved': motion.unproved,
        'about': '' if motion.plotted is None else motion.plotted.name,
    }


def joints_section(motion: MotionControl) -> dict[str, Any]:
    """Return the joints that can be moved, and the frames that a gizmo can move."""
    joints = [plain_joint(name, joint) for name, joint in motion.joints.items()]
    return {'joints': joints, 'frames': motion.frames}


def values_section(motion: MotionControl) -> dict[str, Any]:
    """Return the values of the joints, and the frame with the gizmo."""
    values = {name: round(value, 6) for name, value in motion.joint_values().items()}
    return {'joints': values, 'frame': motion.frame}


def clock_section(motion: MotionControl) -> dict[str, Any] | None:
    """Return the time of a motion, and whether it is played; None without one."""
    if motion.timeline is None:
        return None
    return {'time': round(motion.time, 6), 'playing': motion.playing, 'speed': motion.speed}


def status_section(lines: Sequence[str], troubles: Sequence[str]) -> dict[str, Any]:
    """Return remarks about the moment, and what went wrong."""
    return {'lines': list(lines), 'troubles': list(troubles)}


def _bytes(colour: Colour) -> list[int]:
    return [round(255.0 * part) for part in colour[:3]]
