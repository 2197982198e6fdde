"""docs/troubleshooting.md: what it quotes is what the code says."""

import re

from conventions.source_tree import PACKAGE, ROOT

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
