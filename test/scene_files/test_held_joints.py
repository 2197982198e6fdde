"""Joints that a scene file holds: by the key, by an SRDF, and what is refused."""

import pytest

from drake_geom_ros.scene_files import SceneFileError, read_scene, to_yaml

ARM = """<robot name="arm"><link name="base"/><link name="wheel"/><link name="lid"/>
<joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/>
<axis xyz="0 1 0"/></joint>
<joint name="hinge" type="revolute"><parent link="base"/><child link="lid"/>
<limit lower="0.5" upper="2" effort="1" velocity="1"/></joint></robot>"""
SRDF = '<robot name="arm"><passive_joint name="spin"/><passive_joint name="hinge"/></robot>'


@pytest.fixture
def robot_of(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    (tmp_path / 'arm.srdf').write_text(SRDF)

    def read(keys):
        text = f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, pose: {{}}, {keys}}}]\n'
        return read_scene(text)

    return read


def held(scene):
    (robot,) = scene.robots
    return {name: robot.configuration[name] for name in robot.held_joints}


def static(scene):
    return {frame.name: frame.static for frame in scene.frames}


def test_held_joints_pose_their_links_which_are_not_expected_to_move(robot_of):
    scene = robot_of('held_joints: {spin: 0.25}')
    assert held(scene) == {'spin': 0.25}
    assert static(scene) == {'base': None, 'wheel': None, 'lid': False}
    assert {f.name for f in scene.frames if f.X_PF is not None} == {'base', 'wheel'}


def test_passive_joints_of_an_srdf_are_held_where_the_scene_puts_them_else_at_rest(robot_of):
    srdf = robot_of('held_joints: {spin: 1}').robots[0].urdf.with_suffix('.srdf')
    file = f'srdf: {srdf}'
    assert held(robot_of(file)) == {'spin': 0.0, 'hinge': 0.5}
    assert held(robot_of(f'{file}, configuration: {{hinge: 1.5}}')) == {'spin': 0.0, 'hinge': 1.5}
    assert held(robot_of(f'{file}, held_joints: {{spin: 2}}')) == {'spin': 2.0, 'hinge': 0.5}


def test_what_is_held_is_saved(robot_of):
    scene = robot_of('held_joints: {spin: 0.25}, configuration: {hinge: 1}')
    text = to_yaml(scene)
    assert 'held_joints: {spin: 0.25}' in text
    assert held(read_scene(text)) == {'spin': 0.25}


@pytest.mark.parametrize(
    ('keys', 'reason'),
    [
        ('held_joints: {spun: 0}', "no joint 'spun'.*nearest: 'spin'"),
        ('held_joints: {hinge: 0}', r'hinge = 0 must lie in \[0.5, 2\]'),
        ('held_joints: {hinge: 1}, configuration: {hinge: 1.5}', 'hinge is held at 1, and has'),
        ('held_joints: {}', 'has 0 keys; give at least one'),
        ('configuration: {}', 'has 0 keys; give at least one'),
    ],
)
def test_what_cannot_be_held_is_refused(robot_of, keys, reason):
    with pytest.raises(SceneFileError, match=reason):
        robot_of(keys)
