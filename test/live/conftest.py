"""A clock and a scene that tests of what a node keeps share."""

import pytest
from live.live_scenes import Clock


@pytest.fixture
def clock():
    """Return a clock that the test sets."""
    return Clock()


@pytest.fixture
def scene(live):
    """Return the scene of a test's ``live``, held by the test's thread as long as it runs."""
    with live.editing() as scene:
        yield scene
