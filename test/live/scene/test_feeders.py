"""Who posed a frame last, and what two of them do by turns."""

import pytest

from drake_geom_ros.live.scene.feeders import MESSAGES, TF, Feeders


@pytest.fixture
def feeders(clock):
    return Feeders(clock)


def test_the_last_one_feeds_a_frame(feeders):
    feeders.note(TF, frozenset({1, 2}))
    feeders.note(MESSAGES, frozenset({2, 3}))
    assert [feeders.is_fed_by(TF, k) for k in (1, 2, 3)] == [True, False, False]
    assert [feeders.is_fed_by(MESSAGES, k) for k in (1, 2, 3)] == [False, True, True]


def test_a_frame_that_is_handed_over_is_not_contested(feeders, clock):
    for feeder in (TF, MESSAGES, TF, MESSAGES):
        feeders.note(feeder, frozenset({1}))
        feeders.note(feeder, frozenset({1}))
        clock.now += 2.0
    assert feeders.contested() == []


def test_a_frame_that_goes_to_and_fro_is_for_a_while(feeders, clock):
    for feeder in (TF, MESSAGES, TF):
        feeders.note(feeder, frozenset({1, 2} if feeder == TF else {1}))
        clock.now += 0.1
    assert feeders.contested() == [1]
    clock.now += 6.0
    assert feeders.contested() == []


def test_who_repeats_the_same_frames_gets_back_what_the_other_took(feeders):
    mine = frozenset({1, 2})
    feeders.note(MESSAGES, mine)
    feeders.note(TF, frozenset({2}))
    assert feeders.is_fed_by(TF, 2)
    feeders.note(MESSAGES, mine)
    assert feeders.is_fed_by(MESSAGES, 2)
    assert not feeders.is_fed_by(TF, 2)
