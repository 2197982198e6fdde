"""The house's rules that a parser can check: sizes, names in __all__, unnamed epsilons."""

import ast
import importlib
import io
import re
import tokenize

import pytest
from conventions.source_tree import PACKAGE, ROOT, SCRIPTS, SOURCES, TRUTH, module_of, name_of

# Epsilons by name, and worst errors that the accuracy tests keep true.
NUMBERS_ALLOWED = ('tolerances.py', 'pair_table.py')
NANOSECOND = '1e-9'  # a unit, where ROS counts time in it

MOST_LINES = 400
MOST_LINES_OF_A_FUNCTION = 60


def small_numbers(source):
    """Return the number literals with a negative exponent, or written as 0.001 and the like."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    numbers = [token.string for token in tokens if token.type == tokenize.NUMBER]
    return [text for text in numbers if re.search(r'e-|^0?\.00+1$', text, re.IGNORECASE)]


@pytest.mark.parametrize('path', SOURCES, ids=name_of)
def test_epsilons_stand_in_tolerances(path):
    allowed = {NANOSECOND} if path.relative_to(PACKAGE).parts[0] == 'ros' else set()
    if path.name not in NUMBERS_ALLOWED:
        assert [text for text in small_numbers(path.read_text()) if text not in allowed] == []


def test_an_unnamed_epsilon_is_seen():
    assert small_numbers('x = 1e-6 + 0.001 + 2E-3 + 0.1 + 1e6 + 10.001') == [
        '1e-6',
        '0.001',
        '2E-3',
    ]


@pytest.mark.parametrize('path', [*SOURCES, *SCRIPTS, *TRUTH, ROOT / 'run'], ids=name_of)
def test_a_file_is_short(path):
    assert len(path.read_text().splitlines()) <= MOST_LINES


@pytest.mark.parametrize('path', SOURCES, ids=name_of)
def test_functions_are_short(path):
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    functions = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, kinds)]
    lengths = {node.name: code_lines(node) for node in functions}
    assert {name: n for name, n in lengths.items() if n >= MOST_LINES_OF_A_FUNCTION} == {}


def code_lines(function):
    """Return the lines of a function below its docstring."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


@pytest.mark.parametrize('path', SOURCES, ids=name_of)
def test_names_in_all_exist(path):
    if '__all__' in path.read_text():
        module = importlib.import_module(module_of(path))
        assert [name for name in module.__all__ if not hasattr(module, name)] == []
        assert len(set(module.__all__)) == len(module.__all__)


def test_every_folder_with_modules_is_a_package():
    folders = {path.parent for path in SOURCES}
    assert [name_of(folder) for folder in folders if not (folder / '__init__.py').exists()] == []


def test_no_room_for_odds_and_ends():
    names = {'utils.py', 'util.py', 'helpers.py', 'common.py', 'misc.py'}
    assert [name_of(path) for path in SOURCES if path.name in names] == []
