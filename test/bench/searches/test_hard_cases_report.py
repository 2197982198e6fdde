"""The page counts what was judged, and the file of failures leaves out what passed."""

import json
from dataclasses import replace

from oracles.hard_cases.construct import body, case

from bench.searches import hard_cases_report as report
from truth.hard_cases.cases import load
from truth.hard_cases.judge import CaseVerdict

ONE = replace(case('cubes', body('Box', (1, 1, 1)), body('Sphere', (1,), None, (3, 0, 0))),
              id='one', family='near', source='a thread')  # fmt: skip
TWO = replace(ONE, id='two', family='far')
RESULTS = {
    (name, query, one.id): CaseVerdict('pass')
    for name in ('ours', 'Peer')
    for query in ('signed_distance', 'penetration')
    for one in (ONE, TWO)
} | {
    ('Peer', 'signed_distance', 'two'): CaseVerdict('wrong', '4 for 2', 20.0),
    ('Peer', 'penetration', 'one'): CaseVerdict('unsupported', 'no spheres'),
}


def test_tables_count():
    text = report.tables([ONE, TWO], RESULTS)
    assert '| signed_distance | Peer | 1 | 1 | - | - | - | - | - |' in text
    assert '| penetration | Peer | 1 | - | - | - | - | - | 1 |' in text
    assert '| far | 1 | 1 | 0 |' in text


def test_examples_name_the_case_and_what_was_answered():
    text = report.examples('Peer', [ONE, TWO], RESULTS)
    assert '| two | a thread | Box, Sphere: cubes | signed_distance | wrong 4 for 2 |' in text
    assert 'one' not in text
    assert report.examples('ours', [ONE, TWO], RESULTS) == 'ours: none.\n'


def test_failures_are_kept_by_case():
    kept = json.loads(report.failures([ONE, TWO], RESULTS))
    assert kept == {'two': {'Peer': {'signed_distance': 'wrong 4 for 2'}}}


def test_the_page_begins_with_its_answer_and_says_what_each_family_is(monkeypatch):
    monkeypatch.setattr(report, 'version', lambda name: '1.0')
    usual = [replace(ONE, family='far'), replace(TWO, family='same')]
    text = report.page(usual, RESULTS)
    answer = 'Of 2 hard cases of usual size, this project solves 2 (signed distance)'
    assert text.startswith(f'# Hard cases\n\n{answer}; of the same cases, Peer 1.')
    assert '| `far` | 1 | bodies 1 km to 10 000 km from the origin |' in text
    assert {case.family for case in load()} == set(report.FAMILIES)
