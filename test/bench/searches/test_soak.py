"""A short soak: no promise is broken but that rings of almost equal minima widen a bound."""

from numba import config

from bench.searches.soak import soak


def test_a_short_soak_breaks_no_promise():
    asked = 300 if config.DISABLE_JIT else 20_000
    answered, counts = soak(asked, seed=1)
    assert answered >= asked
    assert set(counts) <= {'wider than promised'}
    assert counts['wider than promised'] <= answered / 50
