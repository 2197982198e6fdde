"""Trajectory files: what they hold, and what is refused with file, line and key."""

import numpy as np
import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.trajectories import read_trajectory

TEXT = """
header: {stamp: {sec: 0, nanosec: 0}, frame_id: ''}
joint_names: [a, b]
points:
- {time_from_start: 0.5, positions: [0.0, 1]}
- positions: [2.0, 3.0]
  velocities: [0.1, 0.2]
  accelerations: []
  effort: []
  time_from_start: {sec: 2, nanosec: 500000000}
"""


def test_a_message_as_yaml_is_read(tmp_path):
    file = tmp_path / 'way.yaml'
    file.write_text(TEXT)
    names, trajectory = read_trajectory(file)
    assert names == ('a', 'b')
    assert trajectory.times.tolist() == [0.5, 2.5]
    assert trajectory.positions.tolist() == [[0.0, 1.0], [2.0, 3.0]]
    assert np.isnan(trajectory.velocities[0]).all()
    assert trajectory.velocities[1].tolist() == [0.1, 0.2]
    assert np.isnan(trajectory.accelerations).all()


@pytest.mark.parametrize(
    ('before', 'after', 'words'),
    [
        ('[0.0, 1]', '[0.0]', r'way.yaml:5.*it has 1 numbers for 2 joints'),
        ('[0.0, 1]', '[]', r'way.yaml:5.*it has no positions'),
        ('[0.1, 0.2]', '[0.1, 0.2, 0.3]', r'way.yaml:7.*it has 3 numbers'),
        ('[0.1, 0.2]', '[0.1, high]', r'way.yaml:7'),
        ('time_from_start: 0.5, ', '', r'way.yaml:5.*time_from_start'),
        ('nanosec: 500000000', 'nanosec: 5000000000', r'way.yaml:10'),
        ('velocities', 'velocity', r'way.yaml:.*velocity'),
        ('joint_names: [a, b]', 'joint_names: []', r'way.yaml:3'),
    ],
)
def test_what_is_no_trajectory_is_refused(tmp_path, before, after, words):
    file = tmp_path / 'way.yaml'
    file.write_text(TEXT.replace(before, after))
    with pytest.raises(SceneFileError, match=words):
        read_trajectory(file)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(SceneFileError, match='nowhere'):
        read_trajectory(tmp_path / 'nowhere.yaml')


def test_the_file_that_the_page_shows_is_one(tmp_path):
    page = (ROOT / 'docs/motion_checks.md').read_text()
    block = page.split('```yaml\njoint_names', 1)[1].split('```', 1)[0]
    file = tmp_path / 'way.yaml'
    file.write_text('joint_names' + block)
    names, trajectory = read_trajectory(file)
    assert names == ('left::panda_joint1',)
    assert trajectory.times.tolist() == [0.0, 2.0]
