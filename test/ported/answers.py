"""What examples answer, with either package.

``python answers.py FILE KEY pydrake`` prints the answers to the examples of a YAML file as a JSON
list: in a process of its own, for pydrake ends the process where it finds an argument impossible.
"""

import ast
import importlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import yaml

DIFFERENCES = Path(__file__).resolve().parents[2] / 'docs/differences.yaml'


def examples(path, key):
    """Return the examples of a file."""
    return yaml.safe_load(Path(path).read_text())[key]


def answer(code, package):
    """Return the repr of the last expression of an example, or the name of its error."""
    modules = {'g': 'geometry', 'm': 'math', 'common': 'common'}
    names = {n: importlib.import_module(f'{package}.{module}') for n, module in modules.items()}
    names['np'] = np
    exec(examples(DIFFERENCES, 'prelude'), names)
    *statements, last = ast.parse(code).body
    try:
        exec(compile(ast.Module(statements, []), '<example>', 'exec'), names)
        return repr(eval(compile(ast.Expression(last.value), '<example>', 'eval'), names))
    except Exception as error:
        return type(error).__name__


def of_pydrake(path, key):
    """Return the answers of pydrake to all examples, by their code."""
    command = [sys.executable, __file__, str(path), key, 'pydrake']
    done = subprocess.run(command, capture_output=True, text=True, timeout=800)
    assert done.returncode == 0, done.stderr
    codes = [entry['code'] for entry in examples(path, key)]
    return dict(zip(codes, json.loads(done.stdout), strict=True))


if __name__ == '__main__':
    path, key, package = sys.argv[1:]
    print(json.dumps([answer(entry['code'], package) for entry in examples(path, key)]))
