"""Each room says at its door what enters, what leaves, and what it may import."""

import ast
import re

from conventions.layers import LAYERS, room_of
from conventions.source_tree import PACKAGE, name_of
from every import check

DOORS = sorted(PACKAGE.rglob('__init__.py'))
ENTRY = re.compile(r'^(In|Out|May import): ((?:.|\n(?=    ))+)', re.MULTILINE)


def may_import(room):
    """Return what a room may import, ours by the part of the path that tells it from the room's.

    So ``world`` is next door, and ``_proximity`` stands for the files of that floor.
    """
    own = tuple(room.split('/')) if room else ()
    ours, libraries = LAYERS[room_of(f'{room}/any' if room else 'any')]
    names = []
    for other in (tuple(each.split('/')) for each in ours):
        common = 0
        while common < min(len(own), len(other)) and own[common] == other[common]:
            common += 1
        if other != own:
            names.append(other[min(common, len(other) - 1)])
    return set(names), set(libraries)


def told(docstring):
    return {label: ' '.join(text.split()) for label, text in ENTRY.findall(docstring or '')}


def opens_a_room(path):
    """Assert that a file describes its room as the table of layers does."""
    room = path.parent.relative_to(PACKAGE).as_posix().removeprefix('.')
    door = told(ast.get_docstring(ast.parse(path.read_text())))
    assert set(door) == {'In', 'Out', 'May import'}
    assert all(text.endswith('.') for text in door.values())
    ours, _, libraries = door['May import'].removesuffix('.').partition('; ')
    said = set(re.findall(r'``(\w+)``', ours)), set(filter(None, libraries.split(', ')))
    assert said == may_import(room)


def test_a_room_says_what_enters_what_leaves_and_what_it_may_import():
    assert len(DOORS) > 50
    check(opens_a_room, DOORS, name_of)


def test_entries_go_on_where_they_are_indented():
    text = 'A room.\n\nIn: this\n    and that.\nOut: nothing.\n\nMay import: ``math``; numpy.'
    entries = {'In': 'this and that.', 'Out': 'nothing.', 'May import': '``math``; numpy.'}
    assert told(text) == entries
    assert told('Nothing is said.') == {}


def test_a_neighbour_is_told_by_the_end_of_its_path():
    ours, libraries = may_import('geometry/_proximity/near')
    assert ours == {'math', '_proximity', 'runtime', 'kernels', 'world', 'filters'}
    assert libraries == {'numpy', 'numba', 'llvmlite'}
