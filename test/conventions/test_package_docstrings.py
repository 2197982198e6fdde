"""The docstring of a package says what it is for; what it may import stands in ``layers.py``."""

import ast
import re

from conventions.layers import LAYERS
from conventions.source_tree import PACKAGE, name_of
from every import check, report

PACKAGES = sorted(PACKAGE.rglob('__init__.py'))
RIDDLE = re.compile(r'(What|Which|Who|Whoever|Whom|Whose|Whether|Of|Where|How)\b')
INTERNAL = re.compile(r'^(In|Out|May import): |\bno ROS import\b', re.MULTILINE | re.IGNORECASE)


def faults(docstring):
    """Return what a docstring lacks or says that is no business of users."""
    first, _, rest = docstring.partition('\n')
    wrong = []
    if not first.endswith('.') or (rest.strip() and not rest.startswith('\n')):
        wrong.append('the first line is no sentence of its own')
    if RIDDLE.match(first):
        wrong.append('begins with a question word')
    if INTERNAL.search(docstring):
        wrong.append('says what may be imported, or what enters and leaves')
    return wrong


def test_a_package_says_what_it_is_for():
    def judge(path):
        assert faults(ast.get_docstring(ast.parse(path.read_text())) or '') == []

    assert len(PACKAGES) > 50
    check(judge, PACKAGES, name_of)


def test_a_docstring_for_insiders_is_seen():
    assert faults('Queries about a posed scene.\n\nResults are arrays.') == []
    assert len(faults('Queries about a\nposed scene.')) == 1
    assert len(faults('What there is.')) == 1
    assert len(faults('A scene.\n\nIn: poses.\nOut: results.\nMay import: ``math``; numpy.')) == 1
    assert len(faults('The live scene. No ROS import.')) == 1


def test_every_row_of_the_layers_is_a_folder_or_a_file():
    report(
        room
        for room in LAYERS
        if not (PACKAGE / room).is_dir() and not (PACKAGE / f'{room}.py').is_file()
    )
