"""A short soak: no promise is broken but that rings of almost equal minima widen a bound."""

from bench.soak import soak


def test_a_short_soak_breaks_no_promise():
    answered, counts = soak(20_000, seed=1)
    assert answered >= 20_000
    assert set(counts) <= {'wide bound'}
    assert counts['wide bound'] <= answered / 1000
