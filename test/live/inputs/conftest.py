"""A live scene that TF poses; files with another one make their own."""

import pytest
from live.inputs.tf_messages import TEXT
from live.live_scenes import Clock, live_scene

from drake_geom_ros.live.inputs.tf_input import TfInput


@pytest.fixture
def clock():
    return Clock(1000.0)


@pytest.fixture
def live(clock):
    return live_scene(TEXT, clock)


@pytest.fixture
def tf(live):
    return TfInput(live.clocks)
