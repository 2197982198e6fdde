"""Writes docs/parameters.md from config/scene_graph.yaml: python docs/generate_parameters.py.

Parameters of the programs around the node are read from their sources, which may need ROS.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / 'docs/parameters.md'
SETTINGS = ROOT / 'config/scene_graph.yaml'
PROGRAMS = {
    'pose_player': 'drake_geom_ros/ros/pose_player.py',
    'scene_viewer': 'drake_geom_ros/ros/viewer/scene_viewer.py',
}
# Sections by the beginnings of names; a parameter belongs to the first that fits.
SECTIONS = {
    'Maps of sensors': ('obstacle',),
    'Bodies that trackers report': ('tracked_',),
    'Inputs': (
        *('scene_file', 'world_frame', 'use_', 'robot_description', 'filter_self', 'frame_prefix'),
        *('solid_meshes', 'paddings', 'stale_after'),
    ),
    'Files': ('mesh_roots', 'package_roots', 'allow_writes'),
    'Evidence and safeguards': ('replay_', 'cross_check', 'watchdog', 'filters_per_owner'),
    'Node': ('autostart', 'service_depth', 'max_answer_size', 'lcm_url'),
    'Cycle and results': ('',),
}
_ROW = re.compile(r' {4}(?P<name>\w+): (?P<default>.*?) +# (?P<live>live; )?(?P<text>.*)')
_INTRODUCTION = """# Parameters

Generated from [config/scene_graph.yaml](../config/scene_graph.yaml) by
`python docs/generate_parameters.py`; a test keeps it up to date. Start from a copy of that file,
or give single ones: `./run node --ros-args -p max_distance:=0.3`. `ros2 param set` changes those
that are marked *live* while the node runs; all others are read when it starts. An unknown
name and a value that cannot be are refused with the reason.

"""


def page() -> str:
    """Return the text of the page."""
    by_section: dict[str, list[str]] = {title: [] for title in SECTIONS}
    for match in _rows():
        title = next(t for t, begins in SECTIONS.items() if match['name'].startswith(begins))
        live = 'live' if match['live'] else ''
        by_section[title].append(_row(match['name'], match['default'], live, match['text']))
    heading = (
        _row('parameter', 'default', 'change', 'meaning', plain=True)
        + '| --- | --- | --- | --- |\n'
    )
    order = ['Inputs', 'Cycle and results', *SECTIONS]
    parts = [
        f'## {title}\n\n{heading}{"".join(by_section[title])}' for title in dict.fromkeys(order)
    ]
    programs = [_program(name, ROOT / path) for name, path in PROGRAMS.items()]
    return _INTRODUCTION + '\n'.join([*parts, *programs])


def _rows() -> Iterator[re.Match[str]]:
    """Yield the lines of the settings that have a parameter."""
    lines = SETTINGS.read_text().partition('  ros__parameters:\n')[2].splitlines()
    for line in lines:
        match = _ROW.fullmatch(line)
        if match is None:
            raise ValueError(f'{line!r} is no parameter with a comment in {SETTINGS.name}')
        yield match


def _row(name: str, default: str, live: str, text: str, *, plain: bool = False) -> str:
    cells = (name, default) if plain else (f'`{name}`', f'`{default}`')
    return f'| {" | ".join([*cells, live, text.replace("|", chr(92) + "|")])} |\n'


def _program(name: str, path: Path) -> str:
    """Return the section of a program: its ``_TEXTS``, and the defaults that it declares."""
    tree = ast.parse(path.read_text())
    texts: dict[str, str] = {}
    defaults: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == '_TEXTS':
            texts = ast.literal_eval(node.value)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == 'self._declare':
            defaults[ast.literal_eval(node.args[0])] = _default(node.args[1])
    if texts.keys() != defaults.keys():
        raise ValueError(f'{path.name} describes {sorted(texts)} and declares {sorted(defaults)}')
    rows = [f'| `{each}` | `{defaults[each]}` | {text} |\n' for each, text in texts.items()]
    return (
        f'## The program `{name}`\n\n| parameter | default | meaning |\n| --- | --- | --- |\n'
        + ''.join(rows)
    )


def _default(node: ast.expr) -> str:
    """Return a default as a parameter file writes it; names stand for constants of the page."""
    value: Any = ast.literal_eval(node) if not isinstance(node, ast.Name) else _constant(node.id)
    if isinstance(value, bool):
        return str(value).lower()
    return '[]' if value == () else "''" if value == '' else str(value)


def _constant(name: str) -> object:
    """Return a constant of the page in the browser."""
    from drake_geom_ros.viewing.page import serving

    return getattr(serving, name)


if __name__ == '__main__':
    TARGET.write_text(page())
