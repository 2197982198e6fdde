"""The configuration of a robot in a scene file: listed, or of an SRDF's group states."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import SceneFileError, describe, load_scene, read_scene, to_yaml
from drake_geom_ros.trajectories import Kinematics

SRDF = """<robot name="arm">
<virtual_joint name="fixed_base" type="fixed" parent_frame="world" child_link="base"/>
<group name="arm"/><group name="hand"/>
<group_state name="ready" group="arm">
  <joint name="shoulder" value="0.5"/><joint name="wrist" value="-0.3"/>
  <joint name="fixed_base" value="0"/></group_state>
<group_state name="ready" group="hand"><joint name="finger" value="0.02"/></group_state>
<group_state name="open" group="hand">
  <joint name="finger" value="0.1"/><joint name="other" value="-0.19"/></group_state>
<group_state name="bent" group="arm"><joint name="shoulder" value="3"/></group_state>
<group_state name="lost" group="arm"><joint name="sholder" value="0"/></group_state>
<group_state name="words" group="arm"><joint name="wrist" value="up"/></group_state>
</robot>"""
FLOATING = """<robot name="boat"><link name="sea"/><link name="hull"/><link name="deck"/>
<joint name="swim" type="floating"><parent link="sea"/><child link="hull"/></joint>
<joint name="slide" type="planar"><parent link="hull"/><child link="deck"/>
  <axis xyz="0 0 1"/></joint></robot>"""
STATE_OF_BOAT = """<robot name="boat"><group_state name="out" group="all">
<joint name="swim" value="1 2 3 0 0 0.70710678118654752 0.70710678118654752"/>
<joint name="slide" value="0.1 0.2 0.3"/></group_state></robot>"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    (tmp_path / 'boat.urdf').write_text(FLOATING)
    (tmp_path / 'boat.srdf').write_text(STATE_OF_BOAT)
    return tmp_path


def scene(folder, configuration, robot='arm', rest='pose: {position: [1, 2, 3]}'):
    path = folder / 'cell.yaml'
    path.write_text(
        f'robots:\n- name: {robot}\n  urdf: {robot}.urdf\n  srdf: {robot}.srdf\n'
        f'  configuration: {configuration}\n  {rest}\n'
    )
    return read_scene(path)


def assert_stands(description, q):
    robot = description.robots[0]
    kinematics = Kinematics(robot.tree)
    X_WLs = kinematics.link_transforms(q, robot.X_WB.GetAsMatrix4())
    stands = {frame.name: frame.X_PF for frame in description.frames}
    for link, X_WL in zip(kinematics.link_names, X_WLs, strict=True):
        np.testing.assert_allclose(stands[link].GetAsMatrix4(), X_WL, rtol=0, atol=1e-14)


@given(st.tuples(st.floats(-1, 2), st.floats(-9, 9), st.floats(0, 0.1)))
def test_listed_values_pose_the_links(tmp_path_factory, q):
    folder = tmp_path_factory.mktemp('standing')
    (folder / 'arm.urdf').write_text(ARM)
    (folder / 'arm.srdf').write_text(SRDF)
    values = dict(zip(JOINTS_OF_ARM, q, strict=True))
    listed = ', '.join(f'{name}: {value:.17f}' for name, value in values.items())
    assert_stands(scene(folder, f'{{{listed}}}'), q)


def test_links_with_a_joint_without_a_value_wait(folder):
    found = scene(folder, '{shoulder: 0.5}')
    assert found.robots[0].configuration == {'shoulder': 0.5}
    waiting = {frame.name for frame in found.frames if frame.X_PF is None}
    assert waiting == {'hand', 'left', 'right'}
    # Nobody knows how old the place of a link is that a joint moves.
    assert [f.static for f in found.frames if f.name == 'upper'] == [False]


@pytest.mark.parametrize(
    ('names', 'q'), [('ready', (0.5, -0.3, 0.02)), ('[ready]', (0.5, -0.3, 0.02))]
)
def test_a_named_state_counts_for_all_its_groups(folder, names, q):
    assert_stands(scene(folder, names), q)


def test_states_of_several_groups_add_up(folder):
    (folder / 'arm.srdf').write_text(
        SRDF.replace('<group_state name="ready" group="hand">', '<group_state name="x" group="h">')
    )
    assert_stands(scene(folder, '[ready, open]'), (0.5, -0.3, 0.1))


def test_joints_of_several_values_take_those_of_an_srdf(folder):
    found = scene(folder, 'out', 'boat')
    assert found.robots[0].configuration == pytest.approx(
        {
            'swim/x': 1,
            'swim/y': 2,
            'swim/z': 3,
            'swim/yaw': np.pi / 2,
            'swim/pitch': 0,
            'swim/roll': 0,
            'slide/x': 0.1,
            'slide/y': 0.2,
            'slide/theta': 0.3,
        },
        abs=1e-12,
    )
    assert_stands(found, list(found.robots[0].configuration.values()))


@pytest.mark.parametrize(
    ('configuration', 'words'),
    [
        ('{sholder: 1}', "cell.yaml:5: robots[0].configuration.sholder: no joint 'sholder'"),
        ('{sholder: 1}', "nearest: 'shoulder'"),
        ('{other: 1}', "no joint 'other' of 'arm' has a value of its own (it follows 'finger')"),
        ('{shoulder: 3}', 'shoulder = 3 must lie in [-1, 2]'),
        ('home', "no group_state 'home'; it has ready, open, bent, lost, words"),
        ('raedy', "nearest: 'ready'"),
        ('[ready, open]', 'finger has the value 0.02 in one of the states, and 0.1 here'),
        ('bent', 'arm.srdf:10: group_state[bent].joint[shoulder]: shoulder = 3 must lie in'),
        ('lost', "group_state[lost].joint[sholder]: no joint 'sholder'"),
        ('words', "value = 'up' must be a number"),
        ('[]', 'robots[0].configuration'),
        ('{shoulder: up}', 'robots[0].configuration'),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(folder, configuration, words):
    with pytest.raises(SceneFileError) as told:
        scene(folder, configuration)
    assert words in str(told.value)


def test_a_name_needs_an_srdf_and_values_a_tree_of_joints(folder):
    path = folder / 'cell.yaml'
    path.write_text('robots: [{name: arm, urdf: arm.urdf, configuration: ready}]')
    with pytest.raises(SceneFileError, match='the robot has no key `srdf`'):
        read_scene(path)
    mimic = '<mimic joint="none"/></joint>'
    (folder / 'arm.urdf').write_text(ARM.replace('</joint>', mimic, 1))
    with pytest.raises(SceneFileError, match="mimics 'none', which is not a joint"):
        scene(folder, '{shoulder: 0}')


def test_a_saved_scene_stands_as_before(folder):
    scene_graph = SceneGraph()
    scene(folder, 'ready')
    loaded = load_scene(folder / 'cell.yaml', scene_graph)
    text = to_yaml(describe(scene_graph, loaded.X_PFs, loaded.robots.values(), loaded.static))
    again = read_scene(text)
    assert again.robots[0].configuration == loaded.robots['arm'].configuration
    assert [f.X_PF.ToArray().tolist() for f in again.frames] == [
        X_PF.ToArray().tolist() for X_PF in loaded.X_PFs.values()
    ]
    # A robot that was beyond a limit when it was saved comes back as it was.
    beyond = read_scene(text.replace('shoulder: 0.5', 'shoulder: 2.5'))
    assert beyond.robots[0].configuration['shoulder'] == 2.5
