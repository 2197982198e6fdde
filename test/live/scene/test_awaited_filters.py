"""Filters of a scene file for a robot that comes later; without ROS."""

import pytest
from live.live_scenes import live_scene

from drake_geom_ros.geometry import CollisionFilterDeclaration, GeometrySet
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.scene_files import SceneFileError, read_scene, to_yaml

CELL = """
awaits: [arm]
sources: [cell]
geometries:
- {name: table, source: cell, shape: {type: box, size: [1, 1, 0.1]}}
- {name: wall, source: cell, shape: {type: half_space}}
filters:
- exclude_between: [[world/table], ['arm::base']]
- group: {name: g, members: [{source: arm, frame: hand}], ignores: [g]}
- exclude_between: [[world/wall], ['arm::hand/ball']]
"""
BALL = '<collision name="ball"><geometry><sphere radius="0.1"/></geometry></collision>'
ROBOT = f"""<robot name="arm"><link name="base">{BALL}</link>
<link name="hand">{BALL}</link>
<joint name="j" type="revolute"><parent link="base"/><child link="hand"/></joint></robot>"""


@pytest.fixture
def live():
    return live_scene(CELL)


def reasons(live, a, b):
    with live.reading() as scene:
        manager = scene.view().filters
        return manager.explain(scene.model.names.geometry(a), scene.model.names.geometry(b))


def troubles(live):
    with live.reading() as scene:
        return [told for told in scene.troubles() if 'filter' in told]


def test_they_wait_told_and_hold_when_the_robot_comes(live):
    told = troubles(live)
    assert len(told) == 3
    assert "<text>:8: filters[0]: it waits for 'arm'" in told[0]
    with live.reading() as scene:
        assert any("waits for 'arm'" in warning for warning in scene.log.warnings)
    RobotInput(live).take(ROBOT)
    assert troubles(live) == []
    assert reasons(live, 'world/table', 'base/ball') == ['persistent declaration 0']
    assert reasons(live, 'world/wall', 'hand/ball') == ['persistent declaration 1']
    assert reasons(live, 'world/table', 'hand/ball') == []
    with live.reading() as scene:
        assert any("holds now that 'arm' is there" in told for told in scene.log.notes)


def test_they_hold_for_the_robot_that_takes_its_place(live):
    robot = RobotInput(live)
    robot.take(ROBOT)
    robot.take(ROBOT.replace('0.1', '0.2'))
    assert troubles(live) == []
    assert reasons(live, 'world/table', 'base/ball')


def test_a_link_that_the_robot_does_not_have_is_told(live):
    RobotInput(live).take(ROBOT.replace('"hand"', '"tool"'))
    told = troubles(live)
    assert len(told) == 2
    assert "'arm::hand' is not in this scene" in told[0]
    assert reasons(live, 'world/table', 'base/ball')


def test_while_transient_filters_are_active_they_wait(live):
    with live.editing() as scene:
        manager = scene.model.scene_graph.collision_filter_manager()
        geometries = GeometrySet([scene.model.names.geometry('world/table')])
        filter_id = manager.ApplyTransient(CollisionFilterDeclaration().ExcludeWithin(geometries))
        scene.make(
            addition(
                read_scene(
                    'frames: [{name: base, source: arm}, {name: hand, source: arm}]\n'
                    'geometries:\n'
                    '- {name: ball, source: arm, frame: base, shape: {type: sphere, radius: 1}}\n'
                    '- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 1}}\n'
                )
            )
        )
    assert any('transient' in told for told in troubles(live))
    with live.editing() as scene:
        manager.RemoveDeclaration(filter_id)
        scene.filters.bind()
    assert troubles(live) == []


def test_a_saved_scene_goes_on_waiting(live):
    with live.reading() as scene:
        text = to_yaml(scene.description())
    again = live_scene(text)
    assert len(troubles(again)) == 3
    RobotInput(again).take(ROBOT)
    assert troubles(again) == []


def test_a_name_that_nobody_awaits_is_refused_as_ever():
    with pytest.raises(SceneFileError, match=r"filters\[0\].*'arm::base' is neither"):
        read_scene(CELL.replace('awaits: [arm]', 'awaits: [leg]'))
