"""The pace of a time budget, on a clock that the test moves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry._proximity.pairs import budget
from drake_geom_ros.geometry._proximity.pairs.budget import LONGEST_BLOCK, SHORTEST_BLOCK, Pace


class Clock:
    """A clock on which each pair takes what the test says."""

    def __init__(self, seconds):
        self.now = 100.0
        self.looks = 0
        self.blocks = []
        self.seconds = seconds

    def perf_counter(self):
        self.looks += 1
        return self.now

    def compute(self, block):
        self.blocks.append(block)
        self.now += self.seconds[block].sum()


def spend(pace, seconds, budget_seconds, distances=None, reserve=0.0):
    """Spend a budget on pairs of these costs; return the clock and the pairs left."""
    clock = Clock(np.asarray(seconds, dtype=float))
    distances = np.arange(len(seconds), dtype=float) if distances is None else distances
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(budget, 'time', clock)
        left = pace.spend(distances, clock.compute, clock.now + budget_seconds, reserve)
    return clock, left


def test_the_nearest_come_first():
    distances = np.random.default_rng(0).normal(size=400)
    clock, left = spend(Pace(), np.full(400, 1e-6), 100e-6, distances)
    done = np.concatenate(clock.blocks)
    assert SHORTEST_BLOCK < len(done) < 150
    assert (np.diff(distances[done]) >= 0.0).all()
    assert distances[done].max() < distances[left].min()


def test_what_costs_the_same_is_done_to_the_end_of_the_budget():
    pace = Pace()
    for _ in range(3):
        clock, left = spend(pace, np.full(10_000, 1e-6), 1e-3)
        assert 1000 - SHORTEST_BLOCK <= 10_000 - len(left) <= 1000 + SHORTEST_BLOCK
        # A look at the clock costs as much as many pairs, so there are few.
        assert clock.looks < 20


def test_enough_time_leaves_nothing():
    clock, left = spend(Pace(), np.full(1000, 1e-6), 1.0)
    assert len(left) == 0
    assert sorted(np.concatenate(clock.blocks)) == list(range(1000))
    assert max(map(len, clock.blocks)) <= LONGEST_BLOCK


def test_a_spent_budget_still_makes_the_nearest_sharp():
    clock, left = spend(Pace(), np.full(100, 1e-6), -1.0)
    assert [len(block) for block in clock.blocks] == [SHORTEST_BLOCK]
    assert len(left) == 100 - SHORTEST_BLOCK


def test_what_is_left_costs_too():
    _, left = spend(Pace(), np.full(10_000, 1e-6), 2e-3, reserve=1e-7)
    # 1000 us are reserved for the 10 000 at first, and less with each that is done.
    assert 8_800 < len(left) < 9_000


def test_dear_pairs_make_blocks_short():
    pace = Pace()
    spend(pace, np.full(500, 50e-6), 1.0)
    _, left = spend(pace, np.full(500, 50e-6), 1e-3)
    done = 500 - len(left)
    assert 20 <= done <= 20 + SHORTEST_BLOCK
    # And cheap ones make them long again, after a while.
    for _ in range(40):
        spend(pace, np.full(500, 1e-7), 1e-3)
    assert pace.seconds_a_pair < 1e-6


def test_what_fits_by_the_cost_of_lately():
    pace = Pace()
    assert not pace.fits(1, 1e6)  # nothing is known yet
    pace.learn(100, 100e-6)
    assert pace.fits(1000, 1.01e-3)
    assert not pace.fits(1000, 0.99e-3)
    # A few pairs tell little, no pairs nothing.
    pace.learn(1, 1.0)
    pace.learn(0, 1.0)
    assert pace.fits(1000, 1.01e-3)
    # Dear ones are believed at once, cheap ones by and by.
    pace.learn(100, 1.0)
    assert not pace.fits(1000, 1.0)
    pace.learn(100, 0.0)
    assert pace.fits(1000, 7.6)
    assert not pace.fits(1000, 7.4)


@given(
    st.lists(st.sampled_from([1e-7, 1e-6, 1e-5, 1e-4]), max_size=600),
    st.floats(0.0, 1e-2),
    st.floats(0.0, 1e-6),
)
def test_every_pair_is_done_once_or_left(seconds, budget_seconds, reserve):
    clock, left = spend(Pace(), seconds, budget_seconds, reserve=reserve)
    done = np.concatenate([np.zeros(0, dtype=int), *clock.blocks])
    assert sorted([*done, *left]) == list(range(len(seconds)))
    # No longer over the budget than the last block took.
    before_last = sum(np.asarray(seconds)[block].sum() for block in clock.blocks[:-1])
    assert before_last <= budget_seconds + 1e-9
