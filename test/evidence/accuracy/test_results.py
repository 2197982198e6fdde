"""Records: quantiles, ratios, and certificates that are wrong or too wide."""

import numpy as np
import pytest
from evidence.accuracy.records import PAIR, ours


def record(*answers):
    return ours('exact', *answers)


def test_errors_and_ratios():
    made = record((0.1, 1e-10), (0.1 + 1e-10, 3e-10), (0.1 - 2e-10, 1e-9))
    assert made.error(0.5) == pytest.approx(1e-10)
    assert made.error(1.0) == pytest.approx(2e-10)
    assert made.ratios() == pytest.approx([3.0, 5.0], rel=1e-5)
    assert made.worst_bound() == 1e-9
    assert made.violations() == []
    assert made.rounding() == pytest.approx(0.5 * 2.0**-52)


def test_a_bound_below_the_error_is_a_violation():
    (told,) = record((0.1, 1e-10), (0.1 + 2e-10, 1e-10)).violations()
    assert 'Sphere-Sphere, signed_distance, exact, apart: error 2e-10 m' in told


def test_rounding_of_the_truth_is_none():
    assert record((np.nextafter(0.1, 1), 0.0)).violations() == []


def test_a_bound_wider_than_promised_is_one_too():
    made = record()
    made.add(PAIR, 0.1, 2e-9, is_wide=True)
    (told,) = made.violations()
    assert told.endswith('error_bound 2e-09 m, wider than promised')
    assert record((0.1, 2e-9)).violations() == []


def test_without_an_answer_there_is_no_error():
    made = record()
    made.verdicts['missed'] += 2
    assert np.isnan(made.error(1.0))
    assert made.failures == {'missed': 2}
    assert made.worst_configuration() == ''
