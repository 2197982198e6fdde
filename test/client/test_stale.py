"""Planners' answers that rest on stale poses are not taken for answers of now."""

import math
from types import SimpleNamespace as Plain

import pytest

pytest.importorskip('rclpy')
from drake_geom_msgs import srv

from drake_geom_ros.client import SceneGraphClient, StaleError


class Asked(SceneGraphClient):
    """A client of a node that gives one answer."""

    def __init__(self, answer):
        self.answer = answer

    def ask(self, name, /, **fields):
        return self.answer

    def _table(self, version):
        return Plain(version=version)


def answers(stale_frames):
    """Return both calls, with answers that rest on stale poses of frames."""
    states = srv.EvaluateStates.Response(count=1, free=[True], reason=[0], first_not_free=-1)
    motion = srv.CheckMotion.Response(outcome=srv.CheckMotion.Response.CLEAR)
    for each in (states, motion):
        each.stale_frames, each.oldest_pose_age = stale_frames, math.inf
    return (
        lambda **more: Asked(states).evaluate_states(['a'], [0.0], **more),
        lambda **more: Asked(motion).check_motion(path=[[0.0]], joint_names=['a'], **more),
    )


@pytest.mark.parametrize('which', [0, 1])
def test_an_answer_that_rests_on_stale_poses_is_raised_unless_that_is_allowed(which):
    call = answers(['arm::hand', 'cell::cart'])[which]
    with pytest.raises(StaleError, match='stale poses of 2 frames: arm::hand, cell::cart'):
        call()
    assert call(allow_stale=True).stale_frames == ('arm::hand', 'cell::cart')
    assert answers([])[which]().stale_frames == ()
