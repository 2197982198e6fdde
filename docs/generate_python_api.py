"""Writes docs/python_api.md and docs/api from docstrings: python docs/generate_python_api.py."""

from __future__ import annotations

import ast
import enum
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

FOLDER = Path(__file__).resolve().parent
INDEX = 'python_api.md'
MODULES = (
    *('geometry', 'geometry.render', 'sensors', 'math', 'autodiffutils'),
    *('scene_files', 'trajectories', 'batch', 'optimization'),
    *('proximity_rules', 'stopping', 'recordings'),
    *('client', 'common'),
    *(
        'common.value',
        'common.eigen_geometry',
        'viewing.notebook',
        'viewing.page.explore',
        'viewing.meshcat',
    ),
)
_SECTIONS = ('Args:', 'Returns:', 'Raises:', 'Yields:')
_INTRODUCTION = """# The Python API

Generated from the docstrings by `python docs/generate_python_api.py`; a test keeps it up to date.
Names are those of pydrake where it has them;
[differences from pydrake](differences_from_pydrake.md) lists what differs. Lengths are in metres,
angles in radians. A call that is refused raises a RuntimeError and changes nothing. Only `client`
needs ROS.

"""


def pages() -> dict[str, str]:
    """Return the texts of the pages by their paths below docs: an index, and one a module."""
    modules = {name: importlib.import_module(f'drake_geom_ros.{name}') for name in MODULES}
    rows = [
        f'| [{module.__name__}]({_path(name)}) | {_text(module, 1)} |\n'
        for name, module in modules.items()
    ]
    index = f'{_INTRODUCTION}| module | content |\n| --- | --- |\n{"".join(rows)}'
    return {INDEX: index, **{_path(name): _module(module) for name, module in modules.items()}}


def _path(name: str) -> str:
    return f'api/{name}.md'


def public(module: ModuleType) -> dict[str, Any]:
    """Return the public names of a module and what they are."""
    names = getattr(module, '__all__', None) or [
        name for name, thing in vars(module).items() if inspect.isclass(thing)
    ]
    return {name: getattr(module, name) for name in names}


def members(kind: type) -> dict[str, Any]:
    """Return the public methods and properties of a class, its bases' included."""
    found = {}
    for name, value in inspect.getmembers(kind):
        given = inspect.getattr_static(kind, name)
        function = isinstance(given, (staticmethod, classmethod, property)) or callable(value)
        if not name.startswith('_') and function and not isinstance(value, enum.Enum):
            found[name] = value
    for base in (tuple, enum.Enum, Exception):
        if issubclass(kind, base):
            found = {name: v for name, v in found.items() if not hasattr(base, name)}
    return found


def attributes(kind: type) -> dict[str, str]:
    """Return the public fields and attributes of a class, and what the comments at them say."""
    found: dict[str, str] = {}
    for each in reversed([c for c in kind.__mro__ if c.__module__.startswith('drake_geom_ros')]):
        lines = inspect.getsource(each).splitlines()
        (tree,) = ast.parse(textwrap.dedent('\n'.join(lines))).body
        assert isinstance(tree, ast.ClassDef)
        for node in _assigned(tree):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for one in target.elts if isinstance(target, ast.Tuple) else [target]:
                    name = one.attr if isinstance(one, ast.Attribute) else getattr(one, 'id', '_')
                    if not name.startswith('_'):
                        found.setdefault(name, _comment(lines, node.lineno, node.end_lineno))
    return {name: text for name, text in found.items() if name not in members(kind)}


def _assigned(tree: ast.ClassDef) -> Iterator[Any]:
    """Yield what declares a field of a class, or sets an attribute of a new object."""
    for node in tree.body:
        if isinstance(node, ast.AnnAssign):
            yield node
        if isinstance(node, ast.FunctionDef) and node.name == '__init__':
            for inner in ast.walk(node):
                targets = inner.targets if isinstance(inner, ast.Assign) else []
                targets = [inner.target] if isinstance(inner, ast.AnnAssign) else targets
                flat = [o for t in targets for o in (t.elts if isinstance(t, ast.Tuple) else [t])]
                if any(isinstance(o, ast.Attribute) and _is_self(o.value) for o in flat):
                    yield inner


def _is_self(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id == 'self'


def _comment(lines: list[str], first: int, last: int | None) -> str:
    """Return the comment at the end of some lines, or that of its own above them."""
    beside = re.search(r'  # (.*)$', lines[(last or first) - 1])
    above = re.match(r' *# (.*)$', lines[first - 2]) if first > 1 else None
    return beside[1] if beside else above[1] if above else ''


def _module(module: ModuleType) -> str:
    parts = [f'# {module.__name__}\n\n{_text(module)}\n']
    for name, thing in public(module).items():
        parts.append(_class(name, thing) if inspect.isclass(thing) else _other(name, thing))
    return '\n'.join(parts)


def _class(name: str, kind: type) -> str:
    """Return the section of a class: what it is, and a line for each of its members."""
    lines = [_heading(name, '' if issubclass(kind, enum.Enum) else _signature(kind)), _text(kind)]
    if issubclass(kind, enum.Enum):
        lines.append('\n' + ', '.join(f'`{member.name}`' for member in kind))
    listed = [f'- `{m}{_signature(v)}`: {_text(v, 1)}' for m, v in members(kind).items()]
    if not issubclass(kind, enum.Enum):
        listed[:0] = [
            f'- `{a}`{": " if text else ""}{text}' for a, text in attributes(kind).items()
        ]
    return '\n'.join([*lines, *([''] if listed else []), *listed, ''])


def _heading(name: str, signature: str) -> str:
    """Return the heading of a class or function, and below it the call if it has arguments."""
    call = '' if signature in ('', '()') else f'`{name}{signature}`\n\n'
    return f'## {name}\n\n{call}'.rstrip('\n') + '\n'


def _other(name: str, thing: Any) -> str:
    """Return the section of a function or of a value."""
    if inspect.isfunction(thing):
        return f'{_heading(name, _signature(thing))}\n{_text(thing)}\n'
    if name.endswith('_') and hasattr(thing, '__getitem__'):
        return f'## {name}\n\n`{name}[float]` is `{name[:-1]}`.\n'
    return f'## {name}\n\n`{thing!r}`\n'


def _signature(thing: Any) -> str:
    """Return the names and defaults of the arguments; a property has none."""
    if not callable(thing) or (inspect.isclass(thing) and issubclass(thing, Exception)):
        return ''
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return '()'
    parameters = [
        p.replace(annotation=inspect.Parameter.empty)
        for name, p in signature.parameters.items()
        if name != 'self'
    ]
    shown = str(signature.replace(parameters=parameters, return_annotation=signature.empty))
    shown = re.sub(r'<(\w+\.\w+): [^>]*>', r'\1', shown)
    return re.sub(r'<(?:[^<>]|<[^<>]*>)*>', '...', shown)


def _text(thing: Any, paragraphs: int | None = None) -> str:
    """Return the docstring, examples as code; or its first paragraphs in a line."""
    text = (inspect.getdoc(thing) or '').replace('``', '`')
    if paragraphs:
        return ' '.join(text.split('\n\n')[0].split())
    return '\n\n'.join(_block(re.sub(r'::$', ':', block)) for block in text.split('\n\n'))


def _block(block: str) -> str:
    """Return a block of a docstring: examples become code, and sections such as Args lists."""
    if block.startswith(('>>>', '    >>>')):
        return f'```python\n{textwrap.dedent(block)}\n```'
    head, _, body = block.partition('\n')
    if head not in _SECTIONS:
        return block
    entries = re.sub(r'^(\w+): ', r'- `\1`: ', textwrap.dedent(body), flags=re.MULTILINE)
    return f'{head}\n\n{re.sub(r"^    ", "  ", entries, flags=re.MULTILINE)}'


if __name__ == '__main__':
    for path, text in pages().items():
        (FOLDER / path).parent.mkdir(exist_ok=True)
        (FOLDER / path).write_text(text)
