"""README.md and measurements.csv hold what was measured."""

import csv

import pytest
from evidence.accuracy.records import ours, peer, some

from drake_geom_ros.evidence.accuracy.results import Setting
from drake_geom_ros.evidence.accuracy.tables import (
    COLUMNS,
    Circumstances,
    by_family,
    length,
    microseconds,
    readme,
    write_csv,
)

TOLD = Circumstances(
    command='python -m drake_geom_ros accuracy',
    machine='a processor, 2 cores',
    versions={'Python': '3.11'},
    minutes=1.5,
    compiling=20.0,
    left_out=['Box-Mesh500'],
    overheads={(Setting('Coal', 'own settings'), 'signed_distance'): 1e-5},
)


def test_a_row_a_record_with_all_digits(tmp_path):
    write_csv(some(), tmp_path / 'm.csv')
    with (tmp_path / 'm.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(COLUMNS)
    exact = next(row for row in rows if row['setting'] == 'exact')
    assert float(exact['error_worst']) == pytest.approx(1e-11)
    assert float(exact['ratio_worst']) == pytest.approx(3.0, rel=1e-4)
    assert float(exact['seconds_per_pair']) == 1e-5
    mujoco = next(row for row in rows if row['library'] == 'MuJoCo')
    assert (mujoco['answers'], mujoco['failures'], mujoco['error_worst']) == ('0', 'missed:1', '')


def test_families_merge_their_cases():
    records = [ours('exact', (0.1, 1e-15)), ours('exact', (0.2, 0.2), case='Sphere-Box')]
    records[1].whole = 3e-5
    ((key, (one,)),) = by_family(records).items()
    assert key == ('signed_distance', 'spheres')
    assert one.error(1.0) == pytest.approx(0.1)
    assert one.whole == pytest.approx(2e-5)
    # What is merged stays as it was.
    assert len(records[0].errors) == 1


def test_the_readme_can_be_read():
    text = readme(some(), TOLD, ['signed_distance.png'])
    for words in (
        'in 1.5 minutes, after 20 s',
        'a processor, 2 cores',
        'No time was left for Box-Mesh500.',
        'Coal 10.0 (signed distance)',
        '![Signed distance: error over time](signed_distance.png)',
        '# Accuracy, and what it costs\n\nChoose `exact`, the default, unless',
        '`exact` takes 1 to 1 times as long as `fast`',
        'smaller.\n\n| level | answers |',
        '| exact | 2 | 0 | 1 | 3.00 | 3 |',
        '| MuJoCo | own settings |  |  |  |  | 100 (0) | 1 missed of 1 |',
    ):
        assert words in text
    (bad,) = [
        line
        for line in readme([ours('exact', (0.2, 1e-9))], TOLD, []).splitlines()
        if line.startswith('| exact | 1')
    ]
    assert bad.startswith('| exact | 1 | 1 |')


def test_numbers_in_words():
    assert length(0.0, 2e-16) == '< 2e-16'
    assert length(1.24e-6, 2e-16) == '1.2e-06'
    assert length(peer('Coal').error(1.0), 1.0) == ''
    assert microseconds(None) == ''
    assert (microseconds(1.2345e-6), microseconds(1.2345e-3)) == ('1.23', '1234')
