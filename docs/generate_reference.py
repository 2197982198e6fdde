"""Writes docs/reference.md from the definitions in msg_defs: python docs/generate_reference.py."""

from __future__ import annotations

import re
from pathlib import Path

from bench.pages import table

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / 'docs/reference.md'
_FIELD = re.compile(
    r'(?P<type>[\w/\[\]<=]+) +(?P<name>\w+)(?P<value>=\S+)?(?: +(?P<default>[^#\s]+))?'
    r'(?: +# (?P<text>.*))?'
)
# Every answer begins with these two, described once.
_OUTCOME = ('success', 'message')
_INTRODUCTION = """# Messages and services

Generated from the definitions by `python docs/generate_reference.py`; a test keeps it up to date.
Units are SI, quaternions are `x y z w`, and quantities have Drake's names: `X_PF` is the pose of F
in its parent P, `p_WCa` the point Ca in the world, `nhat_BA_W` the unit normal out of B into A.
Arrays are flat: k vectors are 3 k numbers. [Topics](topics.md) lists the topics,
[outputs](outputs.md) and [services](services.md) explain how to use them.
"""
_SERVICES = """## Services

All are in `drake_geom_msgs/srv`, on `~/name`. Every response begins with `bool success`
(false: refused, and nothing changed) and `string message` (what was asked, what is allowed, where
to look), which are left out below. For an answer about all pairs or geometries, the message says
how many pairs are left out because frames never had a pose, and names these frames.
`flatten_filters` is a `std_srvs/Trigger` and has no definition of its own: it makes the present
filters the persistent ones.
"""


def reference() -> str:
    """Return the text of the reference."""
    parts = [_INTRODUCTION, '## Messages\n\nAll of `drake_geom_msgs/msg`.\n']
    parts += [_section(path, path.stem) for path in sorted(ROOT.glob('msg_defs/msg/*.msg'))]
    parts += [_SERVICES]
    parts += [
        _section(path, _snake(path.stem)) for path in sorted(ROOT.glob('msg_defs/srv/*.srv'))
    ]
    return '\n'.join(parts)


def _snake(name: str) -> str:
    return re.sub(r'(?<!^)(?=[A-Z])', '_', name).lower()


def _section(path: Path, title: str) -> str:
    """Return the section of one definition."""
    parts = path.read_text().split('\n---\n')
    description, tables = '', []
    for label, part in zip(('Request', 'Answer'), parts, strict=False):
        lines = part.strip('\n').splitlines()
        if not description:
            head = next(
                (k for k, line in enumerate(lines) if not line.startswith('#')), len(lines)
            )
            description = ' '.join(line.lstrip('# ') for line in lines[:head])
            lines = lines[head:]
        rows = _rows(lines)
        if rows:
            tables.append(f'{label}:\n\n{_table(rows)}' if len(parts) > 1 else _table(rows))
    kind = f' (`{path.stem}`)' if title != path.stem else ''
    return '\n\n'.join([f'### {title}{kind}', description, *tables]) + '\n'


def _rows(lines: list[str]) -> list[tuple[str, str, str]]:
    """Return (field, type, text) of a definition's lines; a comment of its own is a row too."""
    rows = []
    for line in filter(None, map(str.strip, lines)):
        if line.startswith('#'):
            rows.append(('', '', f'*{line.lstrip("# ")}*'))
            continue
        match = _FIELD.fullmatch(line)
        if match is None:
            raise ValueError(f'{line!r} is no field of a definition')
        if match['name'] not in _OUTCOME:
            name = f'{match["name"]}{match["value"] or ""}'
            default = f' (default: {match["default"]})' if match['default'] else ''
            text = f'{match["text"] or ""}{default}'
            rows.append((f'`{name}`', f'`{match["type"]}`', text))
    return rows


def _table(rows: list[tuple[str, str, str]]) -> str:
    cells = [tuple(cell.replace('|', '\\|') for cell in row) for row in rows]
    return table(('field', 'type', ''), cells).rstrip()


if __name__ == '__main__':
    TARGET.write_text(reference())
