"""The repository as the convention tests see it: its folders, files and imports."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / 'drake_geom_ros'

SOURCES = sorted(PACKAGE.rglob('*.py'))
SCRIPTS = sorted(path for room in ('bench', 'examples') for path in (ROOT / room).rglob('*.py'))
TRUTH = sorted(
    path for path in (ROOT / 'test/truth').rglob('*.py') if not path.name.startswith('test_')
)


def name_of(path):
    """Return a path as it is shown: relative to the repository."""
    return str(path.relative_to(ROOT))


def module_of(path):
    """Return the dotted name of a module of the package."""
    parts = path.relative_to(ROOT).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


@cache  # seven rules ask for those of every file
def imports_of(source):
    """Return the dotted names that a source imports, wherever in it, in order.

    ``from a import b`` counts as ``a.b``, for b may be a module.
    """
    names = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = '.' * node.level + (node.module or '')
            names += [f'{start}.{alias.name}' for alias in node.names]
    return tuple(names)
