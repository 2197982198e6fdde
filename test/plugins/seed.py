"""The seed of tests that draw by chance: each run has another one, which its header shows.

``TEST_SEED=123456 ./run test ...`` repeats what a run with that seed in its header drew.
"""

from __future__ import annotations

import os
import random

VARIABLE = 'TEST_SEED'


def seed() -> str:
    """Return the seed of this run; processes that it starts, as pytest-xdist's, inherit it."""
    return os.environ.setdefault(VARIABLE, str(random.SystemRandom().randrange(10**6)))


def note() -> str:
    """Return how to repeat this run, for the messages of tests that draw."""
    return f'{VARIABLE}={seed()} repeats it'


def pytest_configure() -> None:
    """Draw the seed before any process is started that has to share it."""
    seed()


def pytest_report_header() -> str:
    """Return the line of the header."""
    return f'{VARIABLE}={seed()}'
