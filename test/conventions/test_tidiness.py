"""The house's rules that a parser can check: sizes, names in __all__, unnamed epsilons."""

import ast
import importlib
import io
import re
import tokenize
import warnings
from types import SimpleNamespace

from conventions.source_tree import PACKAGE, ROOT, SCRIPTS, SOURCES, TRUTH, module_of, name_of
from every import report

# Epsilons by name, and worst errors that the accuracy tests keep true.
NUMBERS_ALLOWED = ('tolerances.py', 'pair_table.py')
NANOSECOND = '1e-9'  # a unit, where ROS counts time in it

ADVISED_LINES = 400  # a longer file is only listed: no class is cut in pieces to stay under it
MOST_LINES = 600
MOST_LINES_OF_A_FUNCTION = 60


def small_numbers(source):
    """Return (line, literal) of numbers with a negative exponent, or like 0.001."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    numbers = [(token.start[0], token.string) for token in tokens if token.type == tokenize.NUMBER]
    small = re.compile(r'e-|^0?\.00+1$', re.IGNORECASE)
    return [(line, text) for line, text in numbers if small.search(text)]


def is_allowed(path, number):
    """Return whether a file may hold a small number."""
    nanosecond = number == NANOSECOND and path.relative_to(PACKAGE).parts[0] in ('live', 'ros')
    return nanosecond or path.name in NUMBERS_ALLOWED


def test_epsilons_stand_in_tolerances():
    report(
        f'{name_of(path)}:{line}: {text}'
        for path in SOURCES
        for line, text in small_numbers(path.read_text())
        if not is_allowed(path, text)
    )


def test_an_unnamed_epsilon_is_seen():
    assert small_numbers('x = 1e-6 + 0.001\ny = 2E-3 + 0.1 + 1e6 + 10.001') == [
        (1, '1e-6'),
        (1, '0.001'),
        (2, '2E-3'),
    ]
    assert not is_allowed(PACKAGE / 'ros/cycle.py', '1e-6')
    assert not is_allowed(PACKAGE / 'geometry/ids.py', NANOSECOND)


def lengths_beyond(lines):
    """Return ``path: n lines`` of the files of the project that have more than that many."""
    paths = [*SOURCES, *SCRIPTS, *TRUTH, ROOT / 'run']
    counts = {name_of(path): len(path.read_text().splitlines()) for path in paths}
    return [f'{name}: {count} lines' for name, count in counts.items() if count > lines]


def test_a_file_is_short():
    if long := lengths_beyond(ADVISED_LINES):
        listed = ', '.join(long)
        warnings.warn(f'more than the advised {ADVISED_LINES} lines: {listed}', stacklevel=1)
    report(lengths_beyond(MOST_LINES))


def test_functions_are_short():
    report(
        f'{name_of(path)}:{node.lineno}: {node.name}: {code_lines(node)} lines'
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and code_lines(node) >= MOST_LINES_OF_A_FUNCTION
    )


def code_lines(function):
    """Return the lines of a function below its docstring."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


def wrong_in_all(module):
    """Return the entries of ``__all__`` that a module lacks or that stand there twice."""
    names = module.__all__
    return [name for name in names if not hasattr(module, name) or names.count(name) > 1]


def test_names_in_all_exist():
    paths = [path for path in SOURCES if '__all__' in path.read_text()]
    modules = {name_of(path): importlib.import_module(module_of(path)) for path in paths}
    assert len(modules) >= 10
    report(f'{file}: {name}' for file, module in modules.items() for name in wrong_in_all(module))


def test_a_name_that_is_missing_or_there_twice_is_seen():
    module = SimpleNamespace(__all__=['a', 'b', 'c', 'c'], a=1, c=2)
    assert wrong_in_all(module) == ['b', 'c', 'c']


def test_every_folder_with_modules_is_a_package():
    folders = {path.parent for path in SOURCES}
    assert [name_of(folder) for folder in folders if not (folder / '__init__.py').exists()] == []


def test_no_room_for_odds_and_ends():
    names = {'utils.py', 'util.py', 'helpers.py', 'common.py', 'misc.py'}
    assert [name_of(path) for path in SOURCES if path.name in names] == []
