"""docs/reliability.md: every sentence of its lists names a test that is there."""

import re

from conventions.source_tree import ROOT
from every import check

TEXT = (ROOT / 'docs/reliability.md').read_text()
ENTRIES = re.findall(r'^- (.*(?:\n  .*)*)', TEXT, re.M)
NAMED = re.compile(r'^(?P<sentence>.+\.)\s\[`(?P<test>\w+)`\]\(\.\./(?P<file>[\w/]+\.py)\)$', re.S)


def test_there_are_entries():
    assert len(ENTRIES) > 20


def names_its_test(entry):
    """Assert that an entry of a list is one sentence and a link to a test that is there."""
    found = NAMED.match(entry)
    assert found, 'no sentence with a link to a test'
    assert '. ' not in found['sentence'].replace('\n', ' '), 'more than one sentence'
    assert f'def {found["test"]}(' in (ROOT / found['file']).read_text()


def test_an_entry_is_one_sentence_with_its_test():
    check(names_its_test, ENTRIES)


def test_parameters_and_figures_are_those_of_the_node():
    config = (ROOT / 'config/scene_graph.yaml').read_text()
    for name in ('service_depth', 'max_answer_size', 'watchdog', 'watchdog_exits'):
        assert f'`{name}`' in TEXT
        assert f'    {name}: ' in config
    assert 'service_depth: 1000 ' in config
