"""A record judges its answers: errors, ratios, bounds below the error or too wide."""

import numpy as np
import pytest

from bench.accuracy.results import OURS, Measured, Setting
from bench.accuracy.samples import known
from bench.accuracy.tables import (
    by_family,
)
from drake_geom_ros.cross_check.bodies import Body

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


def test_families_merge_their_cases():
    records = [ours('exact', (0.1, 1e-15)), ours('exact', (0.2, 0.2), case='Sphere-Box')]
    records[1].whole = 3e-5
    ((key, (one,)),) = by_family(records).items()
    assert key == ('signed_distance', 'spheres')
    assert one.error(1.0) == pytest.approx(0.1)
    assert one.whole == pytest.approx(2e-5)
    # What is merged stays as it was.
    assert len(records[0].errors) == 1


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
