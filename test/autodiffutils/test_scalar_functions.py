"""Functions of floats and AutoDiffXd by name, and the methods that pydrake's numbers have."""

import copy
import importlib.util
import math
import pickle

import numpy as np
import pytest

from drake_geom_ros import math as ours
from drake_geom_ros.autodiffutils import AutoDiffXd, autodiff_equal_to

OF_ONE = {
    **{name: getattr(math, name) for name in ('sqrt', 'exp', 'log', 'sin', 'cos', 'tan')},
    **{name: getattr(math, name) for name in ('asin', 'acos', 'atan', 'sinh', 'cosh', 'tanh')},
    'arcsin': math.asin,
    'arccos': math.acos,
    'arctan': math.atan,
    'abs': abs,
}
HALF, OTHER, NUMBER = AutoDiffXd(0.5, [1, 2]), AutoDiffXd(0.5, [3, 4]), AutoDiffXd(0.5)


def told(number):
    """Return a number's value and derivatives."""
    if isinstance(number, (bool, float)):
        return number, None
    return number.value(), number.derivatives().tolist()


@pytest.mark.parametrize('name', OF_ONE)
def test_of_floats_they_are_those_of_math_and_of_others_their_own(name):
    function = getattr(ours, name)
    assert function(0.5) == function(np.float64(0.5)) == OF_ONE[name](0.5)
    found, step = function(HALF), 1e-6
    slope = (OF_ONE[name](0.5 + step) - OF_ONE[name](0.5 - step)) / (2.0 * step)
    assert found.value() == OF_ONE[name](0.5)
    np.testing.assert_allclose(found.derivatives(), [slope, 2.0 * slope], rtol=1e-8)
    assert told(getattr(HALF, name)()) == told(found)


def test_whole_numbers_are_floats_without_derivatives():
    for low, high in ((ours.floor, ours.ceil), (math.floor, math.ceil), (np.floor, np.ceil)):
        for x in (AutoDiffXd(-1.5, [1.0]), *([-1.5] if low is not math.floor else [])):
            assert (low(x), high(x)) == (-2.0, -1.0)
            assert isinstance(low(x), float)
    assert (HALF.floor(), HALF.ceil()) == (0.0, 1.0)
    assert ours.isnan(AutoDiffXd(math.nan))
    assert not ours.isnan(1.0)
    assert not ours.isnan(HALF)


def test_of_equal_numbers_the_first_that_varies_is_chosen():
    for name in ('max', 'min'):
        function = getattr(ours, name)
        for x, y, chosen in (
            *((HALF, OTHER, HALF), (OTHER, HALF, OTHER), (NUMBER, HALF, HALF)),
            *((HALF, NUMBER, HALF), (HALF, 0.5, HALF), (0.5, HALF, HALF)),
        ):
            assert told(function(x, y)) == told(chosen)
    assert told(ours.max(HALF, 2.0)) == told(HALF.max(2.0)) == (2.0, [])
    assert told(ours.min(2.0, HALF)) == told(HALF.min(2)) == told(HALF)
    assert (ours.max(1, 2.0), ours.min(1, 2.0)) == (2.0, 1.0)
    with pytest.raises(TypeError):
        ours.max(HALF, 'a')


def test_powers_and_angles():
    assert told(ours.pow(HALF, 2)) == told(HALF.pow(2)) == (0.25, [1.0, 2.0])
    assert ours.pow(2.0, 3) == 8.0
    assert ours.atan2(1.0, 2.0) == math.atan2(1.0, 2.0)
    both = told(ours.atan2(HALF, 2.0)), told(ours.atan2(2.0, HALF))
    assert both == (told(HALF.atan2(2.0)), told(AutoDiffXd(2.0).arctan2(HALF)))


def test_the_slope_of_the_size_of_0_is_that_from_above():
    for zero in (0.0, -0.0):
        assert told(abs(AutoDiffXd(zero, [1, 2]))) == (0.0, [1.0, 2.0])


def test_they_are_written_copied_and_made_by_keywords():
    assert str(HALF) == 'AD{0.5, nderiv=2}'
    for same in (copy.copy(HALF), copy.deepcopy(HALF), pickle.loads(pickle.dumps(HALF))):
        assert told(same) == told(HALF)
    assert told(AutoDiffXd(value=1.0, size=2, offset=1)) == (1.0, [0.0, 1.0])
    assert told(AutoDiffXd(value=1.0, derivatives=[1, 2])) == (1.0, [1.0, 2.0])


def test_they_are_compared_whole():
    still = AutoDiffXd(0.5, [0, 0])
    assert autodiff_equal_to([HALF, HALF], [HALF, OTHER]).tolist() == [True, False]
    assert not autodiff_equal_to(still, NUMBER)
    assert autodiff_equal_to(still, NUMBER, semantic=True)
    assert not autodiff_equal_to(HALF, NUMBER, semantic=True)
    assert not autodiff_equal_to(AutoDiffXd(1.0), NUMBER, semantic=True)


@pytest.mark.skipif(importlib.util.find_spec('pydrake') is None, reason='no pydrake')
def test_nothing_that_pydrakes_number_has_is_missing_and_it_says_the_same():
    from pydrake import autodiffutils
    from pydrake import math as theirs

    its = autodiffutils.AutoDiffXd
    missing = {name for name in dir(its) if not name.startswith('_')} - set(dir(AutoDiffXd))
    assert not missing
    assert autodiffutils.autodiff_equal_to(its(1.0, [0]), its(1.0), semantic=True)
    values = (its(0.5, [1, 2]), its(0.5, [3, 4]), its(-0.5, [1, 0]), its(0.5))
    mine = [AutoDiffXd(x.value(), x.derivatives()) for x in values]
    for name in ('max', 'min', 'atan2'):
        for i in range(4):
            for k in range(4):
                expected = told(getattr(theirs, name)(values[i], values[k]))
                assert told(getattr(ours, name)(mine[i], mine[k])) == expected
                # Numbers of pydrake are taken, too.
                assert told(getattr(ours, name)(values[i], values[k])) == expected
    for name in (*OF_ONE, 'ceil', 'floor', 'isnan'):
        for x, y in zip(mine[:2], values[:2], strict=True):
            found, expected = told(getattr(ours, name)(x)), told(getattr(theirs, name)(y))
            assert found[0] == expected[0]
            np.testing.assert_allclose(found[1] or 0, expected[1] or 0, rtol=1e-14)
    assert [str(x) for x in mine] == [str(y) for y in values]
