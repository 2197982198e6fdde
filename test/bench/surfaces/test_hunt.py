"""The search for broken laws of contact surfaces finds none between flush bodies."""

from collections import Counter

import numpy as np

from bench.surfaces.hunt import searched


def test_flush_bodies_break_no_law():
    random, found, broken = np.random.default_rng(7), Counter(), []
    for _ in range(16):
        searched(random, found, broken)
    assert broken == []
    assert found['surfaces'] > 100
    assert found['jumps'] > 0  # of which it is asked what they are close by
