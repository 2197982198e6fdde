"""docs/scene_file.md is what the schema says, and names every key of it."""

import json
import runpy

from conventions.source_tree import ROOT

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_scene_file.py'))
SCHEMA = json.loads(GENERATOR['SCHEMA'].read_text())
PAGE = (ROOT / 'docs/scene_file.md').read_text()


def keys(node):
    """Yield every key that the schema describes."""
    for name, given in node.items() if isinstance(node, dict) else ():
        # A definition is called properties, too.
        if name == 'properties' and 'description' not in given:
            yield from given
        yield from keys(given)
    for given in node if isinstance(node, list) else ():
        yield from keys(given)


def test_the_page_is_current():
    assert GENERATOR['page']() == PAGE, 'run: python docs/generate_scene_file.py'


def test_every_key_is_named():
    names = {*keys(SCHEMA)}
    assert {'name', 'urdf', 'rpy', 'semi_axes', 'allow_between'} <= names
    # The forms of a value, and the parts of a set's member, are described in a sentence.
    in_words = {'rgba', 'set', 'array', 'geometry', 'thickness'}
    assert [name for name in sorted(names - in_words) if f'`{name}`' not in PAGE] == []
    assert [name for name in sorted(in_words) if f'{name}: ' not in PAGE] == []


def test_every_key_in_a_table_says_what_it_means():
    assert [line for line in PAGE.splitlines() if line.endswith('|  |')] == []
