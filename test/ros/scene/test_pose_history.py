"""Where frames were at a time between two messages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.ros.scene.clocks import ALWAYS, Since
from drake_geom_ros.ros.scene.pose_history import KEPT, LONGEST_GAP, PoseHistory


def row(x, yaw=0.0):
    return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), [x, 0.0, 0.0]).ToArray()


def noted(history, held, poses, epoch=0):
    ids = np.array(list(poses), dtype=np.int64)
    rows = np.array(list(poses.values()))
    history.note(ids, rows, {frozenset(poses): Since(epoch, held, held)})
    rows[:] = np.nan  # whoever filled it fills it anew


@given(st.floats(0.0, 1.0), st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_between_two_poses_it_goes_straight_and_by_the_shorter_arc(share, first, second):
    history = PoseHistory()
    noted(history, 10.0, {7: row(1.0, first)})
    noted(history, 10.25, {7: -row(-3.0, second) * [-1, -1, -1, 1, 1, 1, 1]})
    then = history.at(10.0 + 0.25 * share, [7])
    assert then.ids.tolist() == [7]
    assert then.rows[0, :3] == pytest.approx([1.0 - 4.0 * share, 0.0, 0.0], abs=1e-9)
    turn = (second - first + np.pi) % (2 * np.pi) - np.pi
    expected = row(0.0, first + share * turn)[3:]
    assert abs(then.rows[0, 3:] @ expected) == pytest.approx(1.0, abs=1e-9)


def test_at_the_time_of_a_pose_it_is_that_pose_to_the_bit():
    history = PoseHistory()
    for k in range(5):
        noted(history, 10.0 + 0.1 * k, {7: row(k, 0.3 * k), 8: row(-k)})
    assert history.at(10.0 + 0.1 * 2, [7]).rows.tobytes() == row(2, 0.6).tobytes()
    assert history.at(10.0 + 0.1 * 4, [8]).rows.tobytes() == row(-4).tobytes()


def test_what_is_not_known_is_told_and_not_guessed():
    history = PoseHistory()
    noted(history, 10.0, {7: row(0.0)})
    noted(history, 10.1, {7: row(1.0)})
    assert history.at(10.2, [7]).later == {7}
    assert history.at(9.9, [7]).lost == {7}
    assert history.at(10.05, [9]).lost == {9}
    assert history.at(10.05, [7, 9]).ids.tolist() == [7]
    noted(history, 10.1 + LONGEST_GAP + 0.01, {7: row(2.0)})
    assert history.at(10.2, [7]).lost == {7}


def test_messages_in_any_order_and_of_other_frames_are_sorted_out():
    history = PoseHistory()
    noted(history, 10.2, {7: row(2.0)})
    noted(history, 10.0, {7: row(0.0)})
    noted(history, 10.1, {8: row(9.0)})
    assert history.at(10.1, [7]).rows[0, 0] == pytest.approx(1.0)


def test_old_ones_go_and_a_jump_of_the_clock_forgets_all():
    history = PoseHistory()
    for k in range(100):
        noted(history, 10.0 + 0.1 * k, {7: row(k)})
    assert history.at(19.9 - KEPT - 0.3, [7]).lost == {7}
    assert len(history.at(19.9 - KEPT + 0.05, [7]).rows) == 1
    noted(history, 19.95, {7: row(0.0)}, epoch=1)
    assert history.at(19.9, [7]).lost == {7}


def test_what_holds_for_good_is_not_kept():
    history = PoseHistory()
    history.note(np.array([7]), row(0.0)[np.newaxis], {frozenset([7]): ALWAYS})
    assert history.at(10.0, [7]).lost == {7}
