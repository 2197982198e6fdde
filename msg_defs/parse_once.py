"""Runs a generator of rosidl with definitions that are parsed once: GENERATOR [ARGUMENTS].

Each of the six generators parses every definition anew, which takes longer than what it writes.
The first one leaves what it parsed beside its file of arguments, where the others load it from.
"""

import hashlib
import os
import pickle
import runpy
import sys
from pathlib import Path

from rosidl_parser import definition, parser

parse = parser.parse_idl_string
sources = b''.join(Path(module.__file__).read_bytes() for module in (definition, parser))


def parse_once(text, png_file=None):
    """Return the content of a definition, as `parse_idl_string` does."""
    kept = folder / hashlib.sha256(sources + text.encode()).hexdigest()
    if kept.exists():
        return pickle.loads(kept.read_bytes())
    content = parse(text, png_file)
    folder.mkdir(exist_ok=True)
    unfinished = kept.with_suffix(f'.{os.getpid()}')
    unfinished.write_bytes(pickle.dumps(content))
    unfinished.replace(kept)
    return content


sys.argv = sys.argv[1:]
arguments_file = sys.argv[sys.argv.index('--generator-arguments-file') + 1]
folder = Path(arguments_file).parent / 'parsed'
parser.parse_idl_string = parse_once
runpy.run_path(sys.argv[0], run_name='__main__')
