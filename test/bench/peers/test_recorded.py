"""What has fallen behind the run that docs/peers.md records."""

import pytest

from bench.pages import table
from bench.peers import recorded, report
from bench.peers.report import Measurement
from bench.peers.timing import Taken


def measurement(query, ours, pydrake=100.0):
    taken = {
        name: Taken([1e-6 * us] * 5, [1e-6] * 5, [3] * 5)
        for name, us in (('ours', ours), ('pydrake', pydrake))
    }
    return Measurement('arms', 'robot', query, taken)


@pytest.fixture
def page():
    rows = [report.cells(measurement(query, 10.0)) for query in ('points', 'near')]
    return f'# A page\n\n{table(report.HEADINGS, rows, left=3)}\n\n- a line | of text\n'


def test_what_takes_longer_beside_pydrake_than_it_did_is_told_the_worst_first(page):
    now = [measurement('points', 20.0), measurement('near', 30.0)]
    near, points = recorded.fallen(now, page)
    assert near == 'fallen: arms robot near: 3.33x pydrake, 10x in peers.md (medians)'
    assert points.startswith('fallen: arms robot points: 5x pydrake')


def test_noise_a_slower_machine_and_what_was_not_recorded_are_not(page):
    slower = measurement('points', 30.0, pydrake=300.0)
    alone = Measurement('arms', 'robot', 'near', {'ours': slower.taken['ours']})
    assert recorded.fallen([slower, alone, measurement('near', 13.0)], page) == []
    assert recorded.fallen([measurement('penetration', 99.0)], page) == []


def test_all_rows_with_pydrake_of_the_page_in_docs_are_read():
    page = recorded.PAGE.read_text()
    column = 1 + report.HEADINGS.index('pydrake/ours')
    rows = [line.split('|') for line in page.splitlines() if line.count('|') > column]
    compared = [row for row in rows if row[column].strip().endswith('x')]
    assert len(compared) > 300
    assert len(dict(recorded.ratios_of(page))) == len(compared)
