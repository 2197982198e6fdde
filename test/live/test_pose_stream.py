"""The stream of poses: whether a cycle comes soon, which tracked bodies share."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import TWO_BALLS, Clock, live_scene
from ros.scene_calls import poses

from drake_geom_ros.live import pose_stream
from drake_geom_ros.live.pose_stream import PoseStream


class Stream:
    """A stream of poses whose cycles are counted."""

    def __init__(self, clock):
        self.clock, self.cycles = clock, 0
        values = Plain(stale_after=1.0, rate=0.0, max_distance=0.1, time_budget=0.0)
        counts = Plain(take=lambda *_: None, answer=lambda *_: None)
        cycle = Plain(run=self.count, rehearse=lambda *_: None)
        self.stream = PoseStream(live_scene(TWO_BALLS), Plain(values=values), counts, cycle)
        self.stream.active = True

    def count(self, *_):
        self.cycles += 1

    def pose(self, times, period):
        for k in range(times):
            self.clock.now += period
            self.stream.take_poses(poses(['a'], [(0.0, 0.0, float(k))], source='s'), 0.0)


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(pose_stream, 'time', Plain(perf_counter=clock))
    return clock


@pytest.mark.parametrize(
    ('times', 'period', 'later', 'is_soon'),
    [
        (0, 0.01, 0.0, False),  # no poses
        (1, 0.01, 0.0, False),  # once, as at the start
        (5, 0.01, 0.005, True),  # a robot at 100 Hz
        (5, 0.01, 0.03, False),  # which fell silent
        (5, 0.1, 0.005, False),  # poses at 10 Hz
    ],
)
def test_poses_that_come_fast_have_a_cycle_soon(clock, times, period, later, is_soon):
    stream = Stream(clock)
    stream.pose(times, period)
    clock.now += later
    assert stream.stream.has_cycle_soon() == is_soon
    assert stream.cycles == times


def test_what_comes_with_poses_is_taken_before_their_cycle(clock):
    stream, cycles = Stream(clock), []
    stream.stream.with_poses = lambda scene: cycles.append((scene, stream.cycles))
    stream.pose(2, 0.01)
    assert [count for _, count in cycles] == [0, 1]
    assert stream.cycles == 2
