"""What tests of the scene model share."""

import pytest
from oracles.small_scene import SmallScene


@pytest.fixture
def scene():
    """Return a scene of two sources with names and ids to hand."""
    return SmallScene()
