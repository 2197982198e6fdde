"""Runs a generator of rosidl with definitions that are parsed once: GENERATOR [ARGUMENTS].

Each of the six generators parses every definition anew, which takes longer than what it writes.
The first one leaves what it parsed beside its file of arguments, where the others load it from.

rosidl parses by Earley's algorithm, which takes 21 s for our definitions, and LALR 1 s. LALR
needs each token to be of one kind, so a decimal number is one here, and there are no octal
numbers, nor fixed-point numbers without a point. rosidl's own parser is asked about what LALR
cannot parse, and says what is wrong.
"""

import functools
import hashlib
import os
import pickle
import runpy
import sys
from pathlib import Path

from lark import Lark
from lark.exceptions import LarkError
from rosidl_parser import definition, parser

parse = parser.parse_idl_string
sources = b''.join(Path(module.__file__).read_bytes() for module in (definition, parser))
BY_LALR = {
    'decimal_literal: DIGIT\n': 'decimal_literal: /0(?![0-7])|[1-9][0-9]*/\n',
    '  | "1".."9" DIGIT+\n': '',
    '  | octal_literal\n': '',
    '  | INT "d"i\n': '',
}


@functools.cache
def quick_parser():
    """Return the parser by LALR, or None for another grammar than the one that was tried."""
    grammar = parser.grammar
    for rule, by_lalr in BY_LALR.items():
        if grammar.count(rule) != 1:
            return None
        grammar = grammar.replace(rule, by_lalr)
    try:
        return Lark(grammar, start='specification', maybe_placeholders=False, parser='lalr')
    except LarkError:
        return None


def parse_soon(text, png_file):
    """Return the content of a definition, by LALR where that parses it."""
    if quick_parser() is None:
        return parse(text, png_file)
    own, parser._parser = parser._parser, quick_parser()
    try:
        return parse(text, png_file)
    except LarkError:
        pass
    finally:
        parser._parser = own
    return parse(text, png_file)


def parse_once(text, png_file=None):
    """Return the content of a definition, as `parse_idl_string` does."""
    kept = folder / hashlib.sha256(sources + text.encode()).hexdigest()
    if kept.exists():
        return pickle.loads(kept.read_bytes())
    content = parse_soon(text, png_file)
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
