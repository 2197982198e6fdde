"""Scenes that ship stand where somebody would want them: nothing in them overlaps."""

from pathlib import Path

import pytest

from drake_geom_ros.command_line.opened_scene import OpenedScene

ROOT = Path(__file__).parents[2]
SCENES = [
    path
    for path in (*ROOT.glob('scenes/*.yaml'), *ROOT.glob('examples/*/cell.yaml'))
    if not path.stem.endswith('_motion')
]


def test_there_are_some():
    assert {path.name for path in SCENES} >= {'minimal.yaml', 'two_pandas.yaml', 'cell.yaml'}


@pytest.mark.parametrize('path', SCENES, ids=lambda path: f'{path.parent.name}/{path.name}')
def test_nothing_overlaps_where_the_scene_stands(path):
    scene = OpenedScene(str(path))
    scene.check_whole()
    found = scene.query.ComputePointPairPenetration()
    overlaps = [(scene.names[each.id_A], scene.names[each.id_B], each.depth) for each in found]
    assert not overlaps
    # A robot without a configuration waits for its joint states.
    robots = scene.description.robots
    assert all(robot.configuration or robot.joint_states for robot in robots)
