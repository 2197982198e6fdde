"""The files that compiled code depends on, found by their syntax.

A file counts where it has a compiled function, or a name that a compiled function uses: another
function, a constant, the class of a record among its arguments, and what these use in turn.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import drake_geom_ros

PACKAGE = Path(drake_geom_ros.__file__).parent
COMPILER = 'compiled.py'  # that of ``runtime``, and those of rooms with caches of their own
COMPILERS = {'compiled', 'inlined', 'allocating', 'view', 'made', 'Entry', 'address_of'}
NUMBA_DECORATORS = {
    'njit',
    'cfunc',
    'intrinsic',
    'overload',
    'overload_attribute',
    'overload_method',
}


class Imported(NamedTuple):
    """A name that comes from another file of ours; without ``name``: the file as a module."""

    file: Path
    name: str


def file_of(module: str) -> Path | None:
    """Return the file of a module of ours, or None."""
    place = PACKAGE.parent / module.replace('.', '/')
    files = (place.with_suffix('.py'), place / '__init__.py')
    return next((file for file in files if file.exists()), None)


def imports_of(node: ast.ImportFrom) -> Iterator[tuple[str, Imported]]:
    """Yield what an import from a module of ours binds."""
    module = file_of(node.module or '')
    for alias in node.names:
        submodule = file_of(f'{node.module}.{alias.name}')
        if module and node.module.startswith(PACKAGE.name):
            target = Imported(submodule, '') if submodule else Imported(module, alias.name)
            yield alias.asname or alias.name, target


def statements_of(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield the statements of a module, those below an ``if`` or a ``try`` too."""
    for statement in body:
        yield statement
        if isinstance(statement, ast.If | ast.Try):
            yield from statements_of([*statement.body, *statement.orelse])


def names_bound_by(statement: ast.stmt) -> Iterator[str]:
    """Yield the names that a definition or an assignment binds."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        yield statement.name
    elif isinstance(statement, ast.Assign | ast.AnnAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        for node in (each for target in targets for each in ast.walk(target)):
            if isinstance(node, ast.Name):
                yield node.id


@cache
def bindings(file: Path) -> dict[str, list[ast.AST | Imported]]:
    """Return what each name of a module is bound to; imports count wherever they stand."""
    bound: dict[str, list[ast.AST | Imported]] = {}
    tree = ast.parse(file.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for name, target in imports_of(node):
                bound.setdefault(name, []).append(target)
    for statement in statements_of(tree.body):
        for name in names_bound_by(statement):
            bound.setdefault(name, []).append(statement)
    return bound


def uses_compiler(file: Path, node: ast.AST) -> bool:
    """Return whether a decorator or a call is one of those that compile."""
    function = node.func if isinstance(node, ast.Call) else node
    name = getattr(function, 'attr', getattr(function, 'id', ''))
    if name in NUMBA_DECORATORS:
        return True
    origins = [each for each in bindings(file).get(name, []) if isinstance(each, Imported)]
    return name in COMPILERS and any(each.file.name == COMPILER for each in origins)


def compiled_parts(file: Path) -> Iterator[ast.AST]:
    """Yield compiled functions, and the outermost statements that have something compiled."""
    for statement in ast.parse(file.read_text()).body:
        calls = [node for node in ast.walk(statement) if isinstance(node, ast.Call)]
        decorators = [
            decorator
            for node in ast.walk(statement)
            if isinstance(node, ast.FunctionDef)
            for decorator in node.decorator_list
        ]
        if any(uses_compiler(file, node) for node in (*calls, *decorators)):
            yield statement


def used_by_compiled_code(folder: Path) -> set[Path]:
    """Return the files that the compiled code in a folder depends on, wherever they are."""
    seen: set[tuple[Path, str]] = set()
    files: set[Path] = set()
    waiting: list[tuple[Path, ast.AST | Imported]] = [
        (file, part) for file in folder.rglob('*.py') for part in compiled_parts(file)
    ]
    while waiting:
        file, part = waiting.pop()
        files.add(file)
        if isinstance(part, Imported):
            files.add(part.file)
            found = bindings(part.file).get(part.name, []) if part.name else []
            waiting += [(part.file, each) for each in found if (part.file, part.name) not in seen]
            seen.add((part.file, part.name))
            continue
        for used in names_in(file, part):
            if (file, used) not in seen:
                seen.add((file, used))
                waiting += [(file, each) for each in bindings(file)[used]]
        waiting += attributes_of_modules(file, part)
    return files


def names_in(file: Path, part: ast.AST) -> set[str]:
    """Return the names of a module that a part of it uses, annotations too."""
    names = {node.id for node in ast.walk(part) if isinstance(node, ast.Name)}
    return names & bindings(file).keys()


def attributes_of_modules(file: Path, part: ast.AST) -> Iterator[tuple[Path, Imported]]:
    """Yield what a part uses of modules that are imported whole."""
    for node in ast.walk(part):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            for target in bindings(file).get(node.value.id, []):
                if isinstance(target, Imported) and not target.name:
                    yield file, Imported(target.file, node.attr)
