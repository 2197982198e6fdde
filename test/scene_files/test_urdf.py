import numpy as np
import pytest

from drake_geom_ros.geometry import Box, Capsule, Cylinder, Ellipsoid, Mesh, Role, Sphere
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    GroupDescription,
    RobotOptions,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.model_files import robot_name
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.urdf import read_urdf

ARM = b"""<?xml version="1.0"?>
<robot name="arm" xmlns:drake="http://drake.mit.edu">
  <link name="base">
    <visual><geometry><mesh filename="package://not/there.dae"/></geometry></visual>
    <collision name="foot">
      <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
      <geometry><box size="1 2 3"/></geometry>
    </collision>
    <collision name="foot"><geometry><sphere radius="0.5"/></geometry></collision>
    <collision><geometry><!-- thin --><cylinder radius="0.1" length="2"/></geometry></collision>
  </link>
  <link name="empty"/>
  <link name="tip">
    <collision><geometry><drake:capsule radius="0.1" length="2"/></geometry></collision>
    <collision><geometry><drake:ellipsoid a="1" b="2" c="3"/></geometry></collision>
    <collision><geometry><mesh filename="meshes/tip.obj" scale="2 2 -2"/></geometry></collision>
  </link>
  <joint name="j1" type="revolute">
    <parent link="base"/><child link="empty"/><limit effort="1" velocity="1" lower="0" upper="1"/>
  </joint>
  <joint name="j2" type="prismatic">
    <parent link="base"/><child link="tip"/><limit effort="1" velocity="1" lower="0" upper="1"/>
  </joint>
  <collision_filter_group name="g"><member link="tip"/></collision_filter_group>
</robot>
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'meshes').mkdir()
    (tmp_path / 'meshes' / 'tip.obj').write_text('v 0 0 0')
    return tmp_path


def read(data, folder, **options):
    return read_urdf(data, 'r.urdf', 'left', folder, ResourceResolver(), RobotOptions(**options))


def test_the_name_of_a_robot():
    assert robot_name(ARM, 'r.urdf') == 'arm'


def test_every_link_is_a_frame_on_the_world(folder):
    parts = read(ARM, folder)
    assert parts.link_names == ['base', 'empty', 'tip']
    assert {(frame.source, frame.parent) for frame in parts.frames} == {('left', 'world')}


def test_a_link_called_world_is_the_world_and_no_frame(folder):
    world = (
        b'<link name="world"/><joint name="j0" type="fixed"><parent link="world"/>'
        b'<child link="base"/></joint><link name="empty"/>'
    )
    parts = read(ARM.replace(b'<link name="empty"/>', world), folder)
    assert parts.link_names == ['base', 'empty', 'tip']
    names = [filter.name for filter in parts.filters]
    assert names == [filter.name for filter in read(ARM, folder).filters]


def test_every_collision_element_is_a_geometry_with_its_own_name(folder):
    geometries = read(ARM, folder).geometries
    assert [(g.frame, g.name) for g in geometries] == [
        ('base', 'foot'),
        ('base', 'foot_1'),
        ('base', 'collision_2'),
        ('tip', 'collision_0'),
        ('tip', 'collision_1'),
        ('tip', 'collision_2'),
    ]
    assert [g.shape for g in geometries] == [
        Box(1, 2, 3),
        Sphere(0.5),
        Cylinder(0.1, 2),
        Capsule(0.1, 2),
        Ellipsoid(1, 2, 3),
        Mesh(str(folder / 'meshes' / 'tip.obj'), [2, 2, -2]),
    ]
    assert all(set(g.roles) == {Role.kProximity} for g in geometries)


def test_a_pose_has_rotation_and_position(folder):
    X = read(ARM, folder).geometries[0].X_FG
    np.testing.assert_array_equal(X.translation(), [1, 2, 3])
    expected = RollPitchYaw(0.1, 0.2, 0.3).ToRotationMatrix().matrix()
    np.testing.assert_allclose(X.rotation().matrix(), expected, rtol=0, atol=1e-15)


def test_a_quaternion_turns_a_collision_element(folder):
    turned = ARM.replace(b'rpy="0.1 0.2 0.3"', b'quat_xyzw="0 0 0.7071 0.7071"')
    X = read(turned, folder).geometries[0].X_FG
    np.testing.assert_allclose(
        X.rotation().matrix(), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], rtol=0, atol=1e-15
    )


def test_a_robot_without_shapes_and_a_leader_that_is_not_there_are_told(folder):
    bare = b"""<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><mimic joint="k"/></joint>
</robot>"""
    assert not read(ARM, folder).warnings
    assert read(bare, folder).warnings == (
        "r.urdf:2: joint[j]: it mimics 'k', which is not a joint: joint values pose no link of "
        'this robot. Drake refuses it',
        "r.urdf:1: the robot 'left' has no <collision> elements: no query sees anything of it",
    )


def test_links_that_are_drawn_and_have_no_shape_are_named_in_one_warning(folder):
    visual = '<visual><geometry><sphere radius="0.1"/></geometry></visual>'
    ball = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    bare = f'<link name="world">{visual}</link><link name="bare">{visual}</link>'
    text = f'<robot name="r">\n<link name="a">{visual}{ball}</link><link name="frame"/>{bare}'
    assert read(f'{text}</robot>'.encode(), folder).warnings == (
        'r.urdf:1: 1 of 4 links have visuals and no collision geometry, so no query sees them: '
        'bare. Give them collision elements, or cover them by geometries of the scene file',
    )
    many = ''.join(f'<link name="l{k}">{visual}</link>' for k in range(60))
    (warning,) = read(f'{text}{many}</robot>'.encode(), folder).warnings
    assert '61 of 64 links have' in warning
    assert 'l38 and 21 more. Give' in warning
    # Where nothing has a shape that is said instead.
    (warning,) = read(f'<robot name="r">{bare}</robot>'.encode(), folder).warnings
    assert 'no <collision> elements' in warning


def test_what_is_fixed_to_a_placed_root_has_a_pose_and_no_other_link(folder):
    fixed = ARM.replace(b'type="prismatic"', b'type="fixed"')
    parts = read(fixed, folder).placed(RigidTransform([0, 0, 1]))
    poses = {frame.name: frame.X_PF for frame in parts.frames}
    assert poses['empty'] is None
    for name in ('base', 'tip'):
        np.testing.assert_array_equal(poses[name].translation(), [0, 0, 1])


def test_what_has_several_roots_has_no_place(folder):
    two = ARM.replace(b'<link name="empty"/>', b'<link name="empty"/><link name="alone"/>')
    with pytest.raises(ValueError, match="the links 'base', 'alone' have no parent each"):
        read(two, folder).placed(RigidTransform())


def test_filters_are_cliques_of_adjacent_links_and_groups(folder):
    clique, group = read(ARM, folder).filters
    assert isinstance(clique, CliqueDescription)
    assert isinstance(group, GroupDescription)
    (group,) = read(ARM, folder, filter_adjacent_links=False).filters
    assert group.name == 'left::g'


def test_places_have_lines(folder):
    parts = read(ARM, folder)
    assert parts.frames[2].where.line == 13
    assert parts.geometries[2].where.line == 10
    assert parts.geometries[0].where.key == 'link[base].collision[foot]'


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        (b'<sphere radius="0.5"/>', b'<sphere radius="-0.5"/>',
         'r.urdf:9: link[base].collision[foot]: Sphere: radius = -0.5 must be >= 0'),
        (b'<sphere radius="0.5"/>', b'<sphere radius="nan"/>',
         'r.urdf:9: link[base].collision[foot]: Sphere: radius = nan must be finite'),
        (b'<sphere radius="0.5"/>', b'<sphere radius="big"/>',
         "r.urdf:9: link[base].collision[foot]: sphere: radius = 'big' must be a number"),
        (b'<sphere radius="0.5"/>', b'<sphere/>',
         'r.urdf:9: link[base].collision[foot]: sphere has no attribute `radius`'),
        (b'<sphere radius="0.5"/>', b'<cone radius="0.5"/>',
         'r.urdf:9: link[base].collision[foot]: unknown shape <cone>; known are '
         'box, capsule, cylinder, ellipsoid, mesh, sphere; give a cone as a mesh'),
        (b'<sphere radius="0.5"/>', b'',
         'r.urdf:9: link[base].collision[foot]: missing <geometry> with one shape'),
        (b'<sphere radius="0.5"/>', b'<box size="1 2"/>',
         "r.urdf:9: link[base].collision[foot]: box: size = '1 2' must be 3 numbers"),
        (b'xyz="1 2 3"', b'xyz="1 2 inf"',
         'r.urdf:5: link[base].collision[foot]: origin: xyz = \'1 2 inf\''),
        (b'xyz="1 2 3"', b'xyz="1 2"',
         "r.urdf:5: link[base].collision[foot]: origin: xyz = '1 2' must be 3 numbers"),
        (b'meshes/tip.obj', b'tip.obj',
         "r.urdf:16: link[tip].collision: 'tip.obj': there is no file"),
        (b' filename="meshes/tip.obj"', b'',
         'r.urdf:16: link[tip].collision: mesh has no attribute `filename`'),
        (b'meshes/tip.obj', b'package://nowhere/tip.obj',
         "r.urdf:16: link[tip].collision: 'package://nowhere/tip.obj': there is no package"),
        (b'<link name="empty"/>', b'<link name="base"/>',
         "r.urdf:12: link[base]: link 'base' is listed twice, see line 3"),
        (b'<link name="empty"/>', b'<link/>', 'r.urdf:12: link: missing attribute `name`'),
        (b'<parent link="base"/><child link="tip"/>', b'<parent link="bas"/><child link="tip"/>',
         "r.urdf:22: joint[j2].parent: link 'bas' is not in the file"),
        (b'<child link="tip"/>', b'', 'r.urdf:21: joint[j2]: missing <child link="..."/>'),
        (b'<joint name="j2"', b'<joint', 'r.urdf:21: joint: missing attribute `name`'),
        (b'<link name="empty"/>',
         b'<link name="empty"/><link name="world"><collision/></link>',
         'r.urdf:12: link[world].collision: missing <geometry>'),
        (b'<link name="empty"/>', b'<link name="empty"/><link name="world"/><joint name="w" '
         b'type="fixed"><parent link="base"/><child link="world"/></joint>',
         "r.urdf:12: joint[w]: the child 'world' is the world frame, which nothing holds"),
        (b'<joint name="j2"', b'<joint name="j1"',
         "r.urdf:21: joint[j1]: joint 'j1' is listed twice, see line 18"),
        (b' type="prismatic"', b'', 'r.urdf:21: joint[j2]: missing attribute `type`'),
        (b'<robot name="arm"', b'<robot', 'r.urdf:2: missing attribute `name`'),
        (b'member link="tip"', b'member link="top"',
         "r.urdf:24: collision_filter_group[g].member: link 'top' is not in the file"),
    ],
)  # fmt: skip
def test_each_fault_names_its_line(folder, old, new, message):
    assert old in ARM
    with pytest.raises(SceneFileError) as caught:
        read(ARM.replace(old, new), folder)
    assert str(caught.value).startswith(message)
