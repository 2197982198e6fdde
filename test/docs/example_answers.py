"""What the examples of docs/differences.yaml answer, with either package.

``python example_answers.py pydrake`` prints the answers as a JSON list: in a process of its own,
for pydrake ends the process where it finds an argument impossible.
"""

import ast
import importlib
import json
import sys
from pathlib import Path

import numpy as np
import yaml

TABLE = yaml.safe_load(Path(__file__).parents[2].joinpath('docs/differences.yaml').read_text())


def answer(code, package):
    """Return the repr of the last expression of an example, or the name of its error."""
    names = {
        'g': importlib.import_module(f'{package}.geometry'),
        'm': importlib.import_module(f'{package}.math'),
        'np': np,
    }
    exec(TABLE['prelude'], names)
    *statements, last = ast.parse(code).body
    try:
        exec(compile(ast.Module(statements, []), '<example>', 'exec'), names)
        return repr(eval(compile(ast.Expression(last.value), '<example>', 'eval'), names))
    except Exception as error:
        return type(error).__name__


if __name__ == '__main__':
    print(json.dumps([answer(entry['code'], sys.argv[1]) for entry in TABLE['on_purpose']]))
