"""Twists of frames in a live scene without ROS: from messages, from poses, and never too old."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from ros.live_scenes import live_scene

from drake_geom_ros.geometry import closing_speeds

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

    def __init__(self):
        self.live = live_scene(TEXT)
        with self.live.editing() as scene:
            scene.watch_motion(longest_gap=1.0)

    def message(self, stamp, frames, **fields):
        seconds = int(stamp)
        time = Plain(sec=seconds, nanosec=round((stamp - seconds) * 1e9))
        header = Plain(stamp=time, frame_id='')
        return Plain(header=header, source='s', frame_names=list(frames), frame_ids=[], **fields)

    def pose(self, stamp, **frames):
        rows = [(*pose, 0, 0, 0, 1)[:7] for pose in frames.values()]
        poses = [float(number) for row in rows for number in row]
        with self.live.editing() as scene:
            scene.take_poses(self.message(stamp, frames, poses=poses))

    def tell(self, stamp, **frames):
        twists = [float(number) for row in frames.values() for number in row]
        with self.live.editing() as scene:
            scene.take_twists(self.message(stamp, frames, twists=twists))

    def speeds(self):
        """Return the closing speeds of a and tool against b; None where nobody knows."""
        with self.live.editing() as scene:
            distances = scene.query.ComputeSignedDistancePairwiseClosestPoints()
            found = closing_speeds(distances, scene.twists())
            name = scene.inspector.GetNameByFrameId
            frames = {f.get_value(): name(f) for f in scene.inspector.GetAllFrameIds()}
        pairs = zip(distances.frame_id_A.tolist(), distances.frame_id_B.tolist(), strict=True)
        return {
            frames[a]: round(float(speed), 9) if known else None
            for (a, b), known, speed in zip(pairs, found.known, found.speed, strict=True)
            if frames[b] == 'b'
        }


@pytest.fixture
def scene():
    return Scene()


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
        assert scene.twists() is None
        assert scene.view(moving=True).twists is None
