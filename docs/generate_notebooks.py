"""Writes examples/tutorials/*.ipynb, the tutorials as notebooks, from their pages.

    python docs/generate_notebooks.py

Blocks of Python become cells, files are written by a cell, and shell commands are run by one.
What a page shows as output is left to the reader's own run.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = ROOT / 'docs/tutorials'
TARGET = ROOT / 'examples/tutorials'
TUTORIALS = ('first_scene', 'planner_in_python', 'port_a_pydrake_script')
# Cells that follow the section with a title: the page shows a terminal there.
VIEWS = {
    ('first_scene', 'Look at it'): """
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.viewing.page.explore import explore

scene_graph = SceneGraph()
load_scene('first_scene.yaml', scene_graph)
page = explore(scene_graph, max_distance=1.0)
page
""",
    ('first_scene', 'What you have learned'): 'page.close()',
    ('planner_in_python', 'Prove the result'): """
from drake_geom_ros.viewing.notebook import show

show(scene_graph, joints, path[len(path) // 2], max_distance=0.2)
""",
}
_FENCE = re.compile(r'^```(\w*)(?: title="([^"]+)")?\n(.*?)^```$', re.DOTALL | re.MULTILINE)
_LINK = re.compile(r'\]\((?!https?:|#)([^)#]+)(#[^)]*)?\)')
_OUTPUT = re.compile(r'(?:^# .*\n?)+\Z', re.MULTILINE)
_RUN = '''import os
import subprocess
import tempfile


def run(command):
    """Run a command of the shell and print what it prints."""
    print(subprocess.run(command, shell=True, check=True, capture_output=True, text=True).stdout)
'''
_APART = '\n\nos.chdir(tempfile.mkdtemp())  # files of this tutorial are written there'


def notebook(name: str) -> str:
    """Return a tutorial as the text of a notebook."""
    page = (PAGES / f'{name}.md').read_text(encoding='utf-8')
    cells = [cell for cell in _cells(name, page) if cell[1].strip()]
    if any('run(' in source for kind, source in cells if kind == 'code'):
        writes = any('.write_text(' in source for _, source in cells)
        cells.insert(1, ('code', _RUN + (_APART if writes else '')))
    content = {
        'cells': [_plain(name, number, *cell) for number, cell in enumerate(cells)],
        'metadata': {
            'kernelspec': {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'},
            'language_info': {'name': 'python'},
        },
        'nbformat': 4,
        'nbformat_minor': 5,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + '\n'


def _cells(name: str, page: str) -> Iterator[tuple[str, str]]:
    """Yield the kind and the text of each cell of a page."""
    for section in re.split(r'(?=^## )', page, flags=re.MULTILINE):
        end = 0
        for fence in _FENCE.finditer(section):
            language, title, text = fence.groups()
            source = _code(language, title, text)
            if source:
                yield 'markdown', _linked(section[end : fence.start()])
                yield 'code', source
                end = fence.end()
        yield 'markdown', _linked(section[end:])
        title = section.splitlines()[0].removeprefix('## ')
        yield 'code', VIEWS.get((name, title), '')


def _code(language: str, title: str | None, text: str) -> str:
    """Return a block as Python; empty for one that only the page can show."""
    if language == 'python':
        return _OUTPUT.sub('', text) if not title else text
    if title:
        return f'from pathlib import Path\n\n_ = Path({title!r}).write_text("""\\\n{text}""")'
    commands = [line[2:] for line in text.splitlines() if line.startswith('$ ')]
    # A script whose text is a cell has run already.
    return '\n'.join(f'run({each!r})' for each in commands if each != 'python balls.py')


def _linked(text: str) -> str:
    """Return text with links that are right in the folder of the notebooks."""

    def moved(link: re.Match[str]) -> str:
        path = os.path.relpath((PAGES / link[1]).resolve(), TARGET)
        return f']({Path(path).as_posix()}{link[2] or ""})'

    return _LINK.sub(moved, text)


def _plain(name: str, number: int, kind: str, source: str) -> dict[str, object]:
    lines = source.strip('\n').splitlines(keepends=True)
    id = hashlib.sha256(f'{name} {number}'.encode()).hexdigest()[:16]
    cell: dict[str, object] = {'cell_type': kind, 'id': id, 'metadata': {}, 'source': lines}
    return cell | ({'execution_count': None, 'outputs': []} if kind == 'code' else {})


def main() -> None:
    """Write the notebooks."""
    TARGET.mkdir(exist_ok=True)
    for name in TUTORIALS:
        (TARGET / f'{name}.ipynb').write_text(notebook(name), encoding='utf-8')


if __name__ == '__main__':
    main()
