"""How old the poses of frames are."""

import math
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.ros.scene.pose_ages import PoseAges

WORLD, A, B = (FrameId.get_new_id() for _ in range(3))
STAMP = Plain(sec=1, nanosec=0)
NAMES = Plain(world=WORLD, frame_names={WORLD: 'world', A: 's::a', B: 's::b'})


@pytest.fixture
def clock():
    return [100.0]


@pytest.fixture
def ages(clock):
    return PoseAges(lambda: clock[0])


def test_ages_count_from_the_last_pose(ages, clock):
    ages.note({A.get_value(): 99.0, B.get_value(): 100.0}, STAMP)
    clock[0] += 2.0
    assert ages.by_name(NAMES) == {'s::a': 3.0, 's::b': 2.0}
    assert ages.oldest(NAMES) == 3.0
    ages.note({A.get_value(): 102.0}, STAMP)
    assert ages.oldest(NAMES) == 2.0


def test_a_frame_that_was_never_posed_is_infinitely_old(ages):
    ages.note({A.get_value(): 100.0}, STAMP)
    assert ages.by_name(NAMES) == {'s::a': 0.0, 's::b': math.inf}
    assert ages.oldest(NAMES) == math.inf


def test_what_holds_for_ever_and_what_is_of_the_future_is_new(ages):
    ages.note({A.get_value(): math.inf, B.get_value(): 100.5}, STAMP)
    assert ages.by_name(NAMES) == {'s::a': 0.0, 's::b': 0.0}
    assert ages.oldest(NAMES) == 0.0


def test_without_frames_nothing_is_old(ages):
    assert ages.oldest(Plain(world=WORLD, frame_names={WORLD: 'world'})) == 0.0


def test_the_newest_stamp_is_that_of_the_newest_pose_whoever_came_last(ages):
    def note(frame, sec, nanosec=0):
        ages.note({frame.get_value(): 100.0}, Plain(sec=sec, nanosec=nanosec))
        return ages.newest_stamp.sec, ages.newest_stamp.nanosec

    assert ages.newest_stamp is None
    assert note(A, 7, 5) == (7, 5)
    assert note(B, 3) == (7, 5)
    assert note(B, 7, 6) == (7, 6)
    assert note(A, 9) == (9, 0)
    # The sender's time has gone back: the pose of 9 s is not there any more.
    assert note(A, 2) == (7, 6)
    assert note(B, 1) == (2, 0)
