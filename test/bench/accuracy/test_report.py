"""Records, README.md, measurements.csv and pictures hold what was measured."""

import csv

import numpy as np
import pytest
from matplotlib import image

from bench.accuracy.diagrams import draw, draw_levels, drawn, level_names
from bench.accuracy.results import COLUMNS, OURS, Measured, Setting, write_csv
from bench.accuracy.samples import known
from bench.accuracy.tables import (
    Circumstances,
    by_family,
    length,
    microseconds,
    readme,
)
from drake_geom_ros.cross_check.bodies import Body

TOLD = Circumstances(
    command='python -m bench.accuracy',
    machine='a processor, 2 cores',
    versions={'Python': '3.11'},
    minutes=1.5,
    compiling=20.0,
    left_out=['Box-Mesh500'],
    overheads={(Setting('Coal', 'own settings'), 'signed_distance'): 1e-5},
)
BALL = Body('Sphere', (0.1,))
PAIR = known(BALL, BALL.at(np.array([0.3, 0.0, 0.0])), 0.1, 'apart')


def ours(level, *answers, case='Sphere-Sphere', family='spheres'):
    """Return a record of our answers, pairs of distance and bound [m], to PAIR."""
    made = Measured(case, family, 'signed_distance', Setting(OURS, level), whole=1e-5, inside=1e-6)
    for distance, bound in answers:
        made.add(PAIR, distance, bound)
    return made


def peer(name, *distances):
    """Return a record of a peer's distances [m] to PAIR, and one more that it missed."""
    setting = Setting(name, 'own settings')
    names = 'Sphere-Sphere', 'spheres', 'signed_distance'
    made = Measured(*names, setting, whole=1e-4, inside=0.0)
    for distance in distances:
        made.add(PAIR, distance)
    made.verdicts['missed'] += 1
    return made


def some():
    """Return records of four levels and two peers."""
    return [
        ours('bound', (0.15, 0.1)),
        ours('fast', (0.1 + 1e-4, 2e-4)),
        ours('balanced', (0.1 + 1e-7, 2e-7)),
        ours('exact', (0.1, 1e-15), (0.1 + 1e-11, 3e-11)),
        peer('Coal', 0.1 + 1e-6),
        peer('MuJoCo'),
    ]


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


def test_errors_and_ratios():
    made = ours('exact', (0.1, 1e-10), (0.1 + 1e-10, 3e-10), (0.1 - 2e-10, 1e-9))
    assert made.error(0.5) == pytest.approx(1e-10)
    assert made.error(1.0) == pytest.approx(2e-10)
    assert made.ratios() == pytest.approx([3.0, 5.0], rel=1e-5)
    assert made.worst_bound() == 1e-9
    assert made.violations() == []
    assert made.rounding() == pytest.approx(0.5 * 2.0**-52)


def test_a_bound_below_the_error_is_a_violation():
    (told,) = ours('exact', (0.1, 1e-10), (0.1 + 2e-10, 1e-10)).violations()
    assert 'Sphere-Sphere, signed_distance, exact, apart: error 2e-10 m' in told


def test_rounding_of_the_truth_is_none():
    assert ours('exact', (np.nextafter(0.1, 1), 0.0)).violations() == []


def test_a_bound_wider_than_promised_is_one_too():
    made = ours('exact')
    made.add(PAIR, 0.1, 2e-9, is_wide=True)
    (told,) = made.violations()
    assert told.endswith('error_bound 2e-09 m, wider than promised')
    assert ours('exact', (0.1, 2e-9)).violations() == []


def test_without_an_answer_there_is_no_error():
    made = ours('exact')
    made.verdicts['missed'] += 2
    assert np.isnan(made.error(1.0))
    assert made.failures == {'missed': 2}
    assert made.worst_configuration() == ''


def test_a_picture_is_written_for_each_query(tmp_path):
    assert draw(some(), tmp_path) == ['signed_distance.png']
    picture = image.imread(tmp_path / 'signed_distance.png')
    assert picture.shape[0] > 400
    assert picture.shape[1] > 800
    # Not a blank sheet.
    assert picture[..., :3].std() > 0.05


def test_a_peer_that_answered_nothing_is_left_out(tmp_path):
    assert draw([ours('exact', (0.1, 1e-15)), peer('Coal')], tmp_path) == ['signed_distance.png']


def test_no_error_is_drawn_as_the_spacing_of_floats():
    record = ours('exact', (0.1, 1e-15))
    assert drawn(0.0, record) == record.rounding() > 0.0
    assert drawn(1e-3, record) == 1e-3
    assert drawn(1.8e308, record) == 10.0


def test_names_of_points_that_lie_close_are_one():
    points = [(1.0, 0.1, 'bound'), (9.0, 1e-15, 'fast'), (10.0, 2e-15, 'exact')]
    assert level_names(points) == [(1.0, 0.1, 'bound'), (9.0, 1e-15, 'fast to exact')]


def test_the_summary_shows_our_levels(tmp_path):
    assert draw_levels(some(), tmp_path) == ['levels.png']
    assert image.imread(tmp_path / 'levels.png')[..., :3].std() > 0.05
    assert draw_levels([peer('Coal', 0.1)], tmp_path) == []
