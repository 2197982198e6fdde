"""Twists of frames in a live scene without ROS: from messages, from poses, and never too old."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.live_scenes import live_scene

from drake_geom_ros.geometry import FramePoseVector, closing_speeds
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.feeders import TF
from drake_geom_ros.math import RigidTransform

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {}}
  - {name: tool, source: s, parent: a, pose: {position: [0, 0, 0.5]}}
  - {name: b, source: s, pose: {position: [2, 0, 0]}}
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: tool, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


class Scene:
    """A live scene that watches motion."""

    def __init__(self, clock):
        self.clock = clock
        self.live = live_scene(TEXT, now=clock)
        with self.live.editing() as scene:
            scene.poses.watch_motion(longest_gap=1.0)

    def message(self, stamp, frames, **fields):
        seconds = int(stamp)
        time = Plain(sec=seconds, nanosec=round((stamp - seconds) * 1e9))
        header = Plain(stamp=time, frame_id='')
        return Plain(header=header, source='s', frame_names=list(frames), frame_ids=[], **fields)

    def pose(self, stamp, **frames):
        rows = [(*pose, 0, 0, 0, 1)[:7] for pose in frames.values()]
        poses = [float(number) for row in rows for number in row]
        with self.live.editing() as scene:
            scene.poses.take(self.message(stamp, frames, poses=poses))

    def tell(self, stamp, **frames):
        twists = [float(number) for row in frames.values() for number in row]
        with self.live.editing() as scene:
            scene.poses.take_twists(self.message(stamp, frames, twists=twists))

    def jump(self, now):
        self.clock.now = now
        self.live.clocks.begin_anew()

    def troubles(self):
        with self.live.reading() as scene:
            return scene.troubles()

    def speeds(self):
        """Return the closing speeds of a and tool against b; None where nobody knows."""
        with self.live.editing() as scene:
            distances = scene.query.ComputeSignedDistancePairwiseClosestPoints()
            found = closing_speeds(distances, scene.poses.twists())
            name = scene.model.inspector.GetNameByFrameId
            frames = {f.get_value(): name(f) for f in scene.model.inspector.GetAllFrameIds()}
        pairs = zip(distances.frame_id_A.tolist(), distances.frame_id_B.tolist(), strict=True)
        return {
            frames[a]: round(float(speed), 9) if known else None
            for (a, b), known, speed in zip(pairs, found.known, found.speed, strict=True)
            if frames[b] == 'b'
        }


@pytest.fixture
def scene(clock):
    clock.now = 10.0
    return Scene(clock)


def test_where_poses_rest_nothing_closes(scene):
    assert scene.speeds() == {'a': 0.0, 'tool': 0.0}


def test_two_stamped_poses_tell_a_twist_and_one_does_not(scene):
    scene.pose(10.0, a=(0, 0, 0))
    assert scene.speeds() == {'a': None, 'tool': None}
    scene.pose(10.5, a=(0.1, 0, 0))
    # The tool hangs on a, and rests in it.
    assert scene.speeds()['a'] == pytest.approx(0.2)
    assert scene.speeds()['tool'] == pytest.approx(0.2 * 1.9 / np.hypot(1.9, 0.5))
    scene.pose(10.5, a=(0.1, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(0.2)


@pytest.mark.parametrize('stamp', [0.0, 9.0, 12.0])
def test_without_a_stamp_before_it_or_long_after_nobody_knows(scene, stamp):
    scene.pose(10.0, a=(0, 0, 0))
    scene.clock.now = max(10.0, stamp)
    scene.pose(stamp, a=(0.1, 0, 0))
    assert scene.speeds() == {'a': None, 'tool': None}


def test_a_twist_that_is_told_holds_until_a_later_pose_comes(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.tell(10.0, a=(0, 0, 0, 0.3, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(0.3)
    scene.pose(10.5, a=(0.1, 0, 0))  # tells its own
    assert scene.speeds()['a'] == pytest.approx(0.2)
    scene.pose(12.0, a=(0.1, 0, 0))
    assert scene.speeds()['a'] is None
    scene.tell(12.0, a=(0, 0, 0, 0.4, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(0.4)


def test_turning_carries_what_hangs_on_a_frame(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.tell(10.0, a=(0, 1.0, 0, 0, 0, 0))
    # About y at 1 rad/s the tool, 0.5 m above, goes along x.
    assert scene.speeds()['tool'] == pytest.approx(0.5 * 2.0 / np.hypot(2.0, 0.5))
    quarter = 0.05
    scene.pose(10.1, a=(0, 0, 0, 0, np.sin(quarter), 0, np.cos(quarter)))
    speed = scene.speeds()['tool']
    up = 0.5 * np.array([np.sin(0.1), np.cos(0.1)])
    gap = np.array([2.0, 0.0]) - up
    along = 0.5 * np.array([np.cos(0.1), -np.sin(0.1)])
    assert speed == pytest.approx(along @ gap / np.linalg.norm(gap))


STILL, APPROACHING = (0, 0, 0, 0, 0, 0), (0, 0, 0, 0.3, 0, 0)


@pytest.mark.parametrize(
    ('ahead', 'why'), [(2.0, 'stamped more than 1 s later'), (3600.0, 'stamped by another clock')]
)
def test_a_twist_that_is_ahead_of_its_pose_is_not_used_and_told(scene, ahead, why):
    scene.pose(10.0, a=(0, 0, 0))
    scene.tell(10.0 + ahead, a=STILL)
    assert scene.speeds() == {'a': None, 'tool': None}
    (told,) = scene.troubles()
    assert 'twists of 1 frame are not used' in told
    assert (why in told, told.endswith(': s::a')) == (True, True)
    scene.pose(10.5, a=(0.1, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(0.2)  # poses know it
    scene.tell(10.5, a=APPROACHING)  # nor does it stand before those that follow
    assert scene.speeds()['a'] == pytest.approx(0.3)
    assert scene.troubles() == []
    scene.tell(10.5 + ahead, a=STILL)
    scene.clock.now += 6.0
    assert scene.troubles() == []


def test_one_that_is_ahead_of_now_is_not_used_where_no_message_poses_the_frame(scene):
    scene.tell(3610.0, a=STILL)
    assert scene.speeds()['a'] is None
    assert len(scene.troubles()) == 1
    scene.tell(10.0, a=APPROACHING)
    assert scene.speeds()['a'] == pytest.approx(0.3)


@pytest.mark.parametrize('stamp', [3610.0, 1e9])
def test_twists_with_stamps_of_another_clock_are_not_used_and_told(scene, stamp):
    scene.pose(stamp, a=(0, 0, 0))
    scene.tell(stamp, a=APPROACHING)
    assert scene.speeds()['a'] is None
    told = '; '.join(scene.troubles())
    assert 'stamped by another clock than that of the node: s::a' in told
    assert 'the poses of 1 frame bear stamps of another clock' in told


def test_what_is_from_before_the_clock_jumped_is_not_used(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.tell(10.0, a=STILL, b=STILL)
    assert scene.speeds()['a'] == 0.0
    scene.jump(9.5)
    assert scene.speeds() == {'a': None, 'tool': None}
    scene.pose(9.5, a=(0.1, 0, 0), b=(2, 0, 0))
    assert scene.speeds() == {'a': None, 'tool': None}
    (told,) = scene.troubles()
    assert ('before the clock jumped' in told, told.endswith('s::a, s::b')) == (True, True)
    scene.clock.now = 10.0
    scene.pose(10.0, a=(0.2, 0, 0), b=(2, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(0.2)


def test_poses_on_both_sides_of_a_jump_tell_no_twist(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.jump(10.2)
    scene.pose(10.2, a=(0.1, 0, 0))
    assert scene.speeds()['a'] is None


def test_a_twist_grows_old(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.pose(10.5, a=(0.1, 0, 0))
    scene.clock.now = 10.5
    assert scene.speeds()['a'] == pytest.approx(0.2)
    scene.clock.now = 12.0
    assert scene.speeds() == {'a': None, 'tool': None}


def test_a_twist_whose_old_stamp_is_repeated_grows_old(scene):
    scene.clock.now = 10.9
    scene.tell(10.0, a=APPROACHING)
    assert scene.speeds()['a'] == pytest.approx(0.3)
    scene.clock.now += 1.5
    scene.tell(10.0, a=APPROACHING)
    assert scene.speeds() == {'a': None, 'tool': None}


def test_who_was_told_to_move_and_of_whom_no_more_is_heard_is_not_said_to_rest(scene):
    scene.tell(10.0, a=APPROACHING)
    assert scene.speeds()['a'] == pytest.approx(0.3)
    scene.clock.now = 11.5
    assert scene.speeds() == {'a': None, 'tool': None}
    (told,) = scene.troubles()
    assert 'older than 1 s: s::a' in told


def test_what_is_fixed_after_it_moved_rests(scene):
    scene.pose(10.0, a=(0, 0, 0))
    scene.pose(10.1, a=(0.1, 0, 0))
    assert scene.speeds()['a'] == pytest.approx(1.0)
    with scene.live.editing() as held:
        (a,) = held.model.names.frames_called('a')
        fixed = FramePoseVector({a: RigidTransform()})
        held.poses.pose(fixed, {frozenset([a.get_value()]): ALWAYS}, Plain(sec=0, nanosec=0), TF)
    assert scene.speeds() == {'a': 0.0, 'tool': 0.0}


@pytest.mark.parametrize(
    ('stamp', 'twist', 'why'),
    [
        (0.0, (0, 0, 0, 0, 0, 0), 'stamp is 0'),
        (1.0, (0, 0, 0, 0, 0), 'must hold 6 finite ones'),
        (1.0, (0, 0, 0, 0, 0, np.inf), 'must hold 6 finite ones'),
    ],
)
def test_what_is_no_twist_is_refused(scene, stamp, twist, why):
    with pytest.raises(RuntimeError, match=why):
        scene.tell(stamp, a=twist)
    with pytest.raises(RuntimeError, match='stranger'):
        scene.tell(1.0, stranger=(0, 0, 0, 0, 0, 0))


def test_a_scene_that_is_not_watched_says_nothing():
    with live_scene(TEXT).editing() as scene:
        assert scene.poses.twists() is None
        assert scene.view(moving=True).twists is None
