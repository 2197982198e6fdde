"""Motion over time: the pose that holds, and the least distance, equal to a plain query's."""

import itertools

import numpy as np
import pytest
from viewing.scenes import local_scene

from drake_geom_ros.geometry import FramePoseVector, QueryObject
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.viewing.timeline import (
    Timeline,
    checks_between,
    least_distance,
    least_distances,
    leaves_pieces_by,
)

TEXT = """
frames:
  - {name: a, pose: {position: [3, 0, 0]}}
geometries:
  - {name: post, shape: {type: sphere, radius: 0.5}}
  - {name: ball, frame: a, shape: {type: sphere, radius: 0.5}}
"""


@pytest.fixture
def shown():
    return local_scene(TEXT)


def moments(shown, *xs):
    frame = shown.frames['scene', 'a']
    return [FramePoseVector({frame: RigidTransform([x, 0.0, 0.0])}) for x in xs]


def test_a_moment_holds_until_the_next(shown):
    vectors = moments(shown, 1.0, 2.0, 3.0)
    timeline = Timeline.of_moments([0.0, 1.0, 2.5], vectors)
    found = [timeline.poses(t) for t in (-1.0, 0.0, 0.9, 1.0, 2.4, 2.5, 9.0)]
    assert found == [vectors[k] for k in (0, 0, 0, 1, 1, 2, 2)]
    assert (timeline.start, timeline.end) == (0.0, 2.5)


@pytest.mark.parametrize('times', [[], [1.0, 1.0], [2.0, 1.0]])
def test_times_must_ascend(shown, times):
    with pytest.raises(ValueError, match='ascend'):
        Timeline.of_moments(times, moments(shown, *times))


def test_least_distances_are_the_plain_ones(shown):
    xs = [1.05, 40.0, 0.6, 5000.0, 1.5]
    timeline = Timeline.of_moments(range(len(xs)), moments(shown, *xs))
    found = list(least_distances(timeline, shown.snapshot()))
    assert found == pytest.approx([x - 1.0 for x in xs], rel=1e-12)
    # The scene itself has not been moved.
    assert shown.X_WF(('scene', 'a')).translation()[0] == 3.0


def test_without_a_pair_there_is_no_least_distance(shown):
    shown.exclude(tuple(shown.moment(1.0, 'exact').geometries.ids.tolist()))
    assert least_distance(QueryObject(shown.snapshot()), 0.1) == np.inf


def test_a_motion_file_is_played(tmp_path):
    motion = tmp_path / 'motion.yaml'
    motion.write_text(
        'frames:\n  scene::a:\n  - {at: 0.0, pose: [3, 0, 0, 0, 0, 0, 1]}\n'
        '  - {at: 4.0, pose: [1, 0, 0, 0, 0, 0, 1]}\n'
    )
    shown = local_scene(TEXT)
    timeline = Timeline.of_motion(load_motion(motion, read_scene(TEXT)), shown.frames)
    shown.pose(timeline.poses(4.0))
    assert shown.X_WF(('scene', 'a')).translation()[0] == pytest.approx(1.0)
    assert (timeline.start, timeline.end) == (0.0, 4.0)


PASSING = """
frames:
  "scene::a":
  - {at: 0.0, pose: [3, 0.9, 0, 0, 0, 0, 1]}
  - {at: 2.0, pose: [-3, 0.9, 0, 0, 0, 1, 0]}
"""


def motion_of(text, tmp_path, count):
    (tmp_path / 'motion.yaml').write_text(text)
    shown, motion = local_scene(TEXT), load_motion(tmp_path / 'motion.yaml', read_scene(TEXT))
    return shown, Timeline.of_motion(motion, shown.frames, count + 1)


def test_pieces_of_a_motion_are_proved_or_touch(tmp_path):
    shown, timeline = motion_of(PASSING, tmp_path, 40)
    outcomes = [check.outcome for check in checks_between(timeline, shown.snapshot())]
    xs = np.array(
        [
            timeline.poses(t).value(shown.frames['scene', 'a']).translation()[0]
            for t in timeline.times
        ]
    )
    touching = np.hypot(xs, 0.9) < 1.0
    assert outcomes == ['contact' if a or b else 'clear' for a, b in itertools.pairwise(touching)]
    assert set(outcomes) == {'clear', 'contact'}


def test_how_far_a_motion_is_from_its_pieces(tmp_path):
    far, turned = zip(
        *(leaves_pieces_by(motion_of(PASSING, tmp_path, n)[1]) for n in (20, 40)), strict=True
    )
    # A smooth curve leaves its chords by the square of their length.
    assert 0.0 < far[1] < 0.35 * far[0]
    assert max(turned) < 1e-6  # it turns at one rate


def test_a_motion_that_crosses_its_pieces_halfway_leaves_them(shown):
    frame = shown.frames['scene', 'a']

    def poses(t):
        pose = RigidTransform(
            RotationMatrix.MakeZRotation(0.3 * t), [t * (t - 0.5) * (t - 1), 0, 0]
        )
        return FramePoseVector({frame: pose})

    far, turned = leaves_pieces_by(Timeline(np.array([0.0, 1.0]), poses, is_continuous=True))
    assert far == pytest.approx(0.25 * 0.25 * 0.75)
    assert turned < 1e-15


def test_moments_that_hold_have_nothing_between_them(shown):
    timeline = Timeline.of_moments([0.0, 1.0], moments(shown, 1.0, 2.0))
    with pytest.raises(ValueError, match='jump'):
        next(checks_between(timeline, shown.snapshot()))
