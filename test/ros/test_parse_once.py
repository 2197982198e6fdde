"""Definitions that the generators of messages parse once are those that each would parse."""

import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes

# Prints all that was parsed, and by which parsers.
GENERATOR = """
import sys
from pathlib import Path
from rosidl_parser import definition, parser

def shown(value):
    if isinstance(value, (list, tuple)):
        return [shown(item) for item in value]
    if isinstance(value, dict):
        return {key: shown(item) for key, item in value.items()}
    if type(value).__module__ != definition.__name__:
        return value
    slots = [name for kind in type(value).__mro__ for name in getattr(kind, '__slots__', ())]
    held = {name: getattr(value, name) for name in slots} | getattr(value, '__dict__', {})
    return type(value).__name__, shown(held)

used, tree_of = [], parser.get_ast_from_idl_string

def noted(text):
    quick = parser._parser is not None and parser._parser.options.parser == 'lalr'
    used.append('lalr' if quick else 'earley')
    return tree_of(text)

parser.get_ast_from_idl_string = noted
for name in sys.argv[3:]:
    path = Path(name)
    file = parser.parse_idl_file(definition.IdlLocator(path.parent, path.name))
    print(shown(file.content))
print(used)
"""


@pytest.fixture
def share():
    folder = ROOT / 'install/drake_geom_msgs/share/drake_geom_msgs'
    if not folder.exists():
        pytest.skip('the messages were not built in this folder')
    return folder


# Starts what parses once beside a rosidl whose grammar is written in another way.
OTHER_GRAMMAR = """
import runpy, sys
from rosidl_parser import parser
parser.grammar = parser.grammar.replace('decimal_literal: DIGIT', 'decimal_literal:  DIGIT')
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name='__main__')
"""


def run(folder, names, *, once, before=()):
    """Return the lines that a generator prints, started plainly or with parsing once."""
    generator = folder / 'generator.py'
    generator.write_text(GENERATOR)
    arguments = [generator, '--generator-arguments-file', folder / 'arguments.json', *names]
    launcher = [ROOT / 'msg_defs/parse_once.py'] if once else []
    command = [sys.executable, *before, *launcher, *arguments]
    return subprocess.run(command, capture_output=True, text=True)


def test_the_second_generator_gets_what_it_would_have_parsed(tmp_path, share):
    # Both have constants, with values of one digit.
    names = [share / 'msg/SignedDistancePairs.idl', share / 'srv/GetPose.idl']
    plain, first, second = (
        run(tmp_path, names, once=once).stdout.splitlines() for once in (False, True, True)
    )
    assert 'error_bound' in plain[0]
    assert plain[:2] == first[:2] == second[:2]
    used = [lines[2] for lines in (plain, first, second)]
    assert used == ["['earley', 'earley']", "['lalr', 'lalr']", '[]']


def test_another_grammar_is_parsed_by_rosidl_itself(tmp_path, share):
    names = [share / 'srv/GetPose.idl']
    other = tmp_path / 'other_grammar.py'
    other.write_text(OTHER_GRAMMAR)
    plain = run(tmp_path, names, once=False).stdout.splitlines()
    launched = run(tmp_path, names, once=True, before=[other]).stdout.splitlines()
    assert launched == plain
    assert launched[1] == "['earley']"


def test_of_a_wrong_definition_is_said_what_rosidl_says(tmp_path, share):
    text = (share / 'srv/GetPose.idl').read_text()
    wrong = tmp_path / 'GetPose.idl'
    wrong.write_text(text.replace('struct', 'strict', 1))
    plain, launched = (run(tmp_path, [wrong], once=once) for once in (False, True))
    assert plain.returncode == launched.returncode == 1
    said = [each.stderr.partition('\n\n')[0] for each in (plain, launched)]
    assert 'No terminal matches' in said[0]
    assert said[0] == said[1]
