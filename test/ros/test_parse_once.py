"""Definitions that the generators of messages parse once are those that each would parse."""

import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes

# Prints all that was parsed, and whether the grammar was needed for it.
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

for name in sys.argv[3:]:
    path = Path(name)
    file = parser.parse_idl_file(definition.IdlLocator(path.parent, path.name))
    print(shown(file.content))
print(parser._parser is None)
"""


def test_the_second_generator_gets_what_it_would_have_parsed(tmp_path):
    share = ROOT / 'install/drake_geom_msgs/share/drake_geom_msgs'
    names = [share / 'msg/SignedDistancePairs.idl', share / 'srv/GetPose.idl']
    if not all(name.exists() for name in names):
        pytest.skip('the messages were not built in this folder')
    generator = tmp_path / 'generator.py'
    generator.write_text(GENERATOR)
    arguments = [generator, '--generator-arguments-file', tmp_path / 'arguments.json', *names]
    launched = [ROOT / 'msg_defs/parse_once.py', *arguments]
    plain, first, second = (
        subprocess.run(
            [sys.executable, *command], capture_output=True, text=True, check=True
        ).stdout.splitlines()
        for command in (arguments, launched, launched)
    )
    assert 'error_bound' in plain[0]
    assert plain[:2] == first[:2] == second[:2]
    assert [lines[2] for lines in (plain, first, second)] == ['False', 'False', 'True']
