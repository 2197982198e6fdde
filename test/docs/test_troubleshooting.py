"""docs/troubleshooting.md: what it quotes is what the code says, and its commands print that."""

import os
import re

from conventions.source_tree import PACKAGE, ROOT
from docs.console import blocks, run, words_and_numbers

TEXT = (ROOT / 'docs/troubleshooting.md').read_text()
# Parts of the quoted messages that the code puts in.
COUNTED = r'\b2 (TF frame|frame|pair|transform message|service call)s( are| were)?\b'
FILLED_IN = re.compile(rf"'map'|\b13\b|{COUNTED}|1\.1|0\.001")


def test_quotes_are_what_the_code_says():
    sources = ' '.join(path.read_text() for path in PACKAGE.rglob('*.py'))
    # A message is written over several literals, with values in braces.
    said = re.sub(r"'\n\s*f?'", '', sources)
    quotes = re.findall(r'^\| "([^"]+)"', TEXT, re.M)
    assert len(quotes) > 5
    for quote in quotes:
        for part in filter(None, map(str.strip, FILLED_IN.sub('\n', quote).split('\n'))):
            assert part in said, quote


def test_commands_print_what_is_shown(tmp_path, monkeypatch):
    paths = [str(ROOT), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    for command, shown in blocks(TEXT)[0]:
        assert words_and_numbers(run(command, tmp_path)) == words_and_numbers(shown)
