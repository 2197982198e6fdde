"""Ages by two clocks: stamps, senders with other clocks, jumps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.live_scenes import Clock

from drake_geom_ros.live.scene.clocks import (
    ALWAYS,
    UNKNOWN,
    Clocks,
    Since,
    oldest,
    oldest_moments,
)


@pytest.fixture
def node():
    return Clock(1000.0)


@pytest.fixture
def steady():
    return Clock(5.0)


@pytest.fixture
def clocks(node, steady):
    return Clocks(node, steady)


def age(clocks, stamp, waited=0.0):
    return clocks.age(clocks.arrival(waited).since(stamp))


def test_an_age_counts_from_the_stamp(clocks, node, steady):
    since = clocks.arrival().since(999.5)
    assert clocks.age(since) == 0.5
    node.now, steady.now = 1002.0, 7.0
    assert clocks.age(since) == 2.5


@pytest.mark.parametrize(
    'stamp',
    [
        0.0,  # none
        1000.3,  # dated ahead, or a clock that is not quite ours
    ],
)
def test_without_a_stamp_of_ours_it_counts_from_when_the_message_came(clocks, steady, stamp):
    assert age(clocks, stamp) == 0.0
    assert age(clocks, stamp, waited=0.5) == 0.5
    since = clocks.arrival(0.5).since(stamp)
    steady.now += 1.0
    assert clocks.age(since) == 1.5


def test_a_stamp_of_a_minute_ago_and_more_makes_a_pose_that_old(clocks, steady):
    for behind in (59.0, 61.0, 987.5):
        assert age(clocks, 1000.0 - behind) == behind
    since = clocks.arrival(0.5).since(12.5)
    steady.now += 1.0
    assert clocks.age(since) == 1.5 + 987.5
    assert since.offset == 987.5


def test_a_stamp_that_lies_far_ahead_makes_an_age_unknown(clocks):
    since = clocks.arrival().since(1.7e9)
    assert since.offset == 1000.0 - 1.7e9
    assert clocks.age(since) == math.inf
    assert clocks.arrival().since(1001.9).offset == 0.0


def test_what_hangs_on_several_poses_is_of_another_clock_where_one_is(clocks):
    ours, behind, ahead = (clocks.arrival().since(stamp) for stamp in (999.0, 12.5, 1e6))
    assert clocks.age(oldest(ours, behind, ALWAYS)) >= 987.5
    assert clocks.age(oldest(ours, behind, ahead)) == math.inf
    assert oldest(ours, behind, UNKNOWN) == UNKNOWN


def test_a_pose_that_is_heard_before_its_time_is_not_old_when_the_clock_catches_up(
    clocks, node, steady
):
    since = clocks.arrival().since(1001.5)
    steady.now += 0.1
    node.now = 1001.6
    assert clocks.age(since) == pytest.approx(0.1)
    steady.now += 3.0
    assert clocks.age(since) == pytest.approx(3.1)
    node.now = 1010.0
    assert clocks.age(since) == pytest.approx(8.5)


def test_silence_counts_while_the_nodes_time_rests_and_its_time_while_it_runs_fast(
    clocks, node, steady
):
    since = clocks.arrival().since(1000.0)
    steady.now += 7.0
    assert clocks.age(since) == 7.0
    node.now += 70.0
    assert clocks.age(since) == 70.0


def test_ages_are_unknown_after_a_jump_until_poses_come_anew(clocks, node, steady):
    before = clocks.arrival().since(999.0)
    node.now -= 900.0
    clocks.begin_anew()
    assert clocks.age(before) == math.inf
    assert age(clocks, 99.5) == 0.5
    assert age(clocks, 0.0) == 0.0
    assert clocks.age(ALWAYS) == 0.0


def test_a_step_of_the_time_of_day_is_seen_once(clocks, node, steady):
    assert clocks.step() == 0.0
    node.now, steady.now = 1010.0, 15.1
    assert clocks.step() == 0.0  # its rate is corrected
    node.now -= 900.0
    assert clocks.step() == -900.0
    assert clocks.step() == 0.0
    node.now += 60.0
    clocks.forget_steps()
    assert clocks.step() == 0.0


def test_a_look_that_was_interrupted_is_none(clocks, node, steady, monkeypatch):
    clocks.step()

    def late():
        steady.now += 3.0
        return node.now

    monkeypatch.setattr(clocks, 'node', late)
    assert clocks.step() == 0.0


_times = st.integers(0, 3).map(float)
_moments = st.one_of(
    st.sampled_from([ALWAYS, UNKNOWN]),
    st.builds(Since, _times, _times, _times, st.integers(-2, 2).map(float)),
)


@given(st.lists(_moments, min_size=1, max_size=6))
def test_the_oldest_moment_of_a_chain_is_the_same_step_by_step(moments):
    rows = np.array(moments)[:, np.newaxis]
    last = rows[0]
    for row in rows[1:]:
        last = oldest_moments(last, row)
    assert Since(*last[0].tolist()) == oldest(*moments)
