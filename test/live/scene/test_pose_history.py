"""Where frames were at a time between two messages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.feeders import MESSAGES, TF
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.live.scene.tracks import KEPT, LONGEST_GAP, UnknownThenError
from drake_geom_ros.math import RigidTransform, RollPitchYaw


def row(x, yaw=0.0):
    return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), [x, 0.0, 0.0]).ToArray()


def noted(history, held, poses, epoch=0, feeder=MESSAGES, now=0.0):
    ids = np.array(list(poses), dtype=np.int64)
    rows = np.array(list(poses.values()))
    history.note((ids, rows), {frozenset(poses): Since(epoch, held, held)}, feeder, now)
    rows[:] = np.nan  # whoever filled it fills it anew


def row_at(history, time, frame):
    """Return the pose of a frame at a time; 'later' or 'lost': it is not known."""
    try:
        return history.around(time).row(frame, None)
    except UnknownThenError as unknown:
        return 'later' if unknown.is_later else 'lost'


@given(st.floats(0.0, 1.0), st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_between_two_poses_it_goes_straight_and_by_the_shorter_arc(share, first, second):
    history = PoseHistory()
    noted(history, 10.0, {7: row(1.0, first)})
    noted(history, 10.25, {7: -row(-3.0, second) * [-1, -1, -1, 1, 1, 1, 1]})
    found = row_at(history, 10.0 + 0.25 * share, 7)
    assert found[:3] == pytest.approx([1.0 - 4.0 * share, 0.0, 0.0], abs=1e-9)
    turn = (second - first + np.pi) % (2 * np.pi) - np.pi
    expected = row(0.0, first + share * turn)[3:]
    assert abs(found[3:] @ expected) == pytest.approx(1.0, abs=1e-9)


def test_at_the_time_of_a_pose_it_is_that_pose_to_the_bit():
    history = PoseHistory()
    for k in range(5):
        noted(history, 10.0 + 0.1 * k, {7: row(k, 0.3 * k), 8: row(-k)})
    assert row_at(history, 10.0 + 0.1 * 2, 7).tobytes() == row(2, 0.6).tobytes()
    assert row_at(history, 10.0 + 0.1 * 4, 8).tobytes() == row(-4).tobytes()


def test_what_is_not_known_is_told_and_not_guessed():
    history = PoseHistory()
    noted(history, 10.0, {7: row(0.0)})
    noted(history, 10.1, {7: row(1.0)})
    assert row_at(history, 10.2, 7) == 'later'
    assert row_at(history, 9.9, 7) == 'lost'
    assert row_at(history, 10.05, 9) == 'lost'
    noted(history, 10.1 + LONGEST_GAP + 0.01, {7: row(2.0)})
    assert row_at(history, 10.2, 7) == 'lost'


def test_messages_in_any_order_and_of_other_frames_are_sorted_out():
    history = PoseHistory()
    noted(history, 10.2, {7: row(2.0)})
    noted(history, 10.0, {7: row(0.0)})
    noted(history, 10.1, {8: row(9.0)})
    assert row_at(history, 10.1, 7)[0] == pytest.approx(1.0)


def test_old_ones_go_and_a_jump_of_the_clock_forgets_all():
    history = PoseHistory()
    for k in range(100):
        noted(history, 10.0 + 0.1 * k, {7: row(k)})
    assert row_at(history, 19.9 - KEPT - 0.3, 7) == 'lost'
    assert row_at(history, 19.9 - KEPT + 0.05, 7)[0] == pytest.approx(99 - 10 * KEPT + 0.5)
    noted(history, 19.95, {7: row(0.0)}, epoch=1)
    assert row_at(history, 19.9, 7) == 'lost'


def test_what_holds_for_good_is_not_kept():
    history = PoseHistory()
    rows = np.array([7]), row(0.0)[np.newaxis]
    history.note(rows, {frozenset([7]): ALWAYS}, MESSAGES, 0.0)
    assert row_at(history, 10.0, 7) == 'lost'


def test_poses_of_another_sender_and_of_another_parent_are_not_those_of_before():
    history = PoseHistory()
    for k in range(3):
        noted(history, 10.0 + 0.1 * k, {7: row(k), 8: row(k)})
    noted(history, 10.25, {7: row(9.0)}, feeder=TF, now=10.27)
    noted(history, 10.35, {7: row(10.0)}, feeder=TF, now=10.36)
    assert row_at(history, 10.15, 7) == 'lost'
    assert row_at(history, 10.3, 7)[0] == pytest.approx(9.5)
    assert row_at(history, 10.15, 8)[0] == pytest.approx(1.5)
    history.begin_anew([8], 10.3)
    noted(history, 10.4, {8: row(5.0)})
    assert row_at(history, 10.15, 8) == 'lost'
    assert row_at(history, 10.35, 8) == 'lost'  # it was in another parent before
    noted(history, 10.5, {8: row(6.0)})
    assert row_at(history, 10.45, 8)[0] == pytest.approx(5.5)


def test_many_sets_of_frames_do_not_pile_up():
    history = PoseHistory()
    for k in range(1000):
        noted(history, 10.0 + 0.1 * k, {k: row(k), 5000: row(k)})
    assert len(history._tracks) < 100
    assert row_at(history, 109.85, 5000)[0] == pytest.approx(998.5)
