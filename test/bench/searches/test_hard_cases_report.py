"""The page counts what was judged, and knows every family."""

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


def test_every_family_is_described():
    assert {case.family for case in load()} == set(report.FAMILIES)
