"""URDF that is written: it reads as the same robot, or what it cannot hold is named."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.geometry.meshes._obj_file import obj_text
from drake_geom_ros.scene_files import RobotOptions, SceneFileError, read_scene, register
from drake_geom_ros.scene_files.urdf_writer import to_urdf
from drake_geom_ros.trajectories.kinematics import Kinematics

ARM = """<robot name="arm" xmlns:drake="http://drake.mit.edu">
<link name="base"><collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
<collision name="foot"><origin xyz="0 0 -1" rpy="0.1 -1.2 3"/><geometry><sphere radius="0.1"/>
</geometry></collision></link>
<link name="upper"><collision><origin xyz="0.1 0 0" rpy="1 2 -0.5"/><geometry>
<drake:capsule radius="0.1" length="0.4"/></geometry><drake:proximity_properties>
<drake:compliant_hydroelastic/><drake:hydroelastic_modulus value="1e6"/>
<drake:mesh_resolution_hint value="0.1"/><drake:mu_static value="0.9"/>
<drake:mu_dynamic value="0.7"/></drake:proximity_properties></collision></link>
<link name="lower"><collision><geometry><drake:ellipsoid a="0.1" b="0.2" c="0.3"/></geometry>
</collision></link>
<link name="hand"><collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
</link>
<link name="eye"/>
<link name="finger"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0 0.1 0.3" rpy="0 1.5707963267948966 0.2"/><axis xyz="0 1 1"/>
<limit lower="-1" upper="2" velocity="3" effort="9"/></joint>
<joint name="b" type="prismatic"><parent link="upper"/><child link="lower"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.5" velocity="0" effort="0"/></joint>
<joint name="c" type="continuous"><parent link="lower"/><child link="hand"/><axis xyz="0 0 1"/>
</joint>
<joint name="d" type="fixed"><parent link="hand"/><child link="eye"/><origin xyz="0 0 1"/></joint>
<joint name="e" type="prismatic"><parent link="hand"/><child link="finger"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1" velocity="1" effort="0"/><mimic joint="b" multiplier="2" offset="0.1"/>
</joint>
<drake:collision_filter_group name="g"><drake:member link="base"/><drake:member link="finger"/>
<drake:ignored_collision_filter_group name="g"/></drake:collision_filter_group></robot>
"""
DRAKES = """<robot name="r" xmlns:drake="http://drake.mit.edu">
<link name="p"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="q"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="s"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<drake:joint name="j" type="{}"><parent link="p"/><child link="q"/>
<origin xyz="1 0 0" rpy="0.1 0.2 0.3"/><axis xyz="0 0 1"/>{}</drake:joint>
<joint name="k" type="continuous"><parent link="q"/><child link="s"/><axis xyz="1 0 0"/></joint>
</robot>
"""
SDF = """<sdf version="1.9"><model name="cart"><static>{}</static><pose>{}</pose>
<link name="base"><collision name="c"><geometry><box><size>1 1 1</size></box></geometry>
</collision></link>
<link name="wheel"><pose>0 1 0 0.3 0 0</pose><collision name="c"><geometry><cylinder>
<radius>0.3</radius><length>0.1</length></cylinder></geometry></collision></link>
<joint name="axle" type="revolute"><parent>base</parent><child>wheel</child>
<pose>0 0.1 0 0 0.2 0</pose><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>
"""
WORLD = """<robot name="r"><link name="world"><collision><geometry><box size="9 9 0.1"/></geometry>
</collision></link><link name="p"><collision><geometry><sphere radius="0.1"/></geometry>
</collision></link><joint name="j" type="prismatic"><parent link="world"/><child link="p"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1" velocity="1" effort="0"/></joint></robot>
"""
ROBOTS = {
    'arm': ARM,
    **{kind: DRAKES.format(kind, '') for kind in ('ball', 'universal')},
    'screw': DRAKES.format('screw', '<drake:screw_thread_pitch value="0.5"/>'),
    'sdf': SDF.format('false', '0 0 0 0 0 0'),
    'static sdf': SDF.format('true', '1 2 3 0 0 0.5'),
    'world': WORLD,
}


def facts_of(scene):
    """Names, shapes, poses at random joint values, properties and candidate pairs."""
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    (robot,) = scene.robots
    kinematics = Kinematics(robot.tree)
    names = list(kinematics.joint_names)
    values = np.random.default_rng(2).uniform(0.0, 0.5, len(names))
    poses = kinematics.link_transforms(values)
    links = {frame.name for frame in scene.frames}
    X_WLs = {
        link: X for link, X in zip(kinematics.link_names, poses, strict=True) if link in links
    }
    manager = scene_graph.collision_filter_manager()
    members = {id: key[1:] for key, id in loaded.geometries.items()}
    pairs = {
        frozenset((members[a], members[b]))
        for a in members
        for b in members
        if a != b and not manager.explain(a, b)
    }
    geometries = {
        (g.frame, g.name): (repr(g.shape), g.X_FG.GetAsMatrix4().round(12).tolist())
        for g in scene.geometries
    }
    properties = {
        (g.frame, g.name): {
            (group, key): value.get_value()
            for p in g.roles.values()
            for group in p.GetGroupNames()
            if group != 'drake'
            for key, value in p.GetPropertiesInGroup(group).items()
        }
        for g in scene.geometries
    }
    limits = dict(zip(names, zip(kinematics.lower, kinematics.upper, strict=True), strict=True))
    return (names, limits, pairs, geometries, properties), X_WLs


@pytest.mark.parametrize('name', ROBOTS)
def test_what_is_written_reads_as_the_same_robot(name):
    before = read_scene(ROBOTS[name])
    after = read_scene(to_urdf(before))
    (facts, poses), (again, written) = facts_of(before), facts_of(after)
    assert again == facts
    assert facts[2] or name.endswith('sdf')  # there are pairs
    assert poses.keys() <= written.keys()
    for link, X in poses.items():
        np.testing.assert_allclose(written[link], X, rtol=0.0, atol=1e-12)
    assert to_urdf(after) == to_urdf(read_scene(to_urdf(after)))


def test_pydrake_reads_it_as_the_same_robot():
    pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    from oracles.like_drake import compared

    inertia = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        '</inertial>'
    )
    text = to_urdf(read_scene(ARM)).replace('<collision', f'{inertia}<collision', 1)
    # Distances of Drake are off by 1e-5 here.
    lines = compared('', text=text, kind='urdf')
    assert [line for line in lines if 'distance' not in line] == []


def test_meshes_are_named_by_their_path(tmp_path):
    (tmp_path / 'box.obj').write_text(obj_text(BOX, SIDES))
    (tmp_path / 'r.urdf').write_text(
        '<robot name="r" xmlns:drake="d"><link name="a"><collision name="m"><geometry>'
        '<mesh filename="box.obj" scale="1 2 -3"/></geometry></collision><collision name="h">'
        '<geometry><mesh filename="box.obj"><drake:declare_convex/></mesh></geometry></collision>'
        '</link></robot>'
    )
    target = tmp_path / 'elsewhere' / 'r.urdf'
    target.parent.mkdir()
    assert main(['convert', str(tmp_path / 'r.urdf'), str(target)]) == 0
    shapes = [g.shape for g in read_scene(target).geometries]
    assert shapes == [g.shape for g in read_scene(tmp_path / 'r.urdf').geometries]


@pytest.mark.parametrize(
    ('keys', 'fault'),
    [
        ('geometries: [{name: g, shape: {type: box, size: [1, 1, 1]}}]', 'sources arm, scene'),
        ('frames: [{name: f, source: arm}]', 'frames that are no links: f'),
        ('cameras: [{name: eye, size: [4, 4], fov_y: 1}]', 'cameras: eye'),
        ('geometries: [{name: p, source: arm, shape: {type: half_space}}]', 'for a HalfSpace'),
        (
            'geometries: [{name: p, frame: base, source: arm, shape: {type: sphere, radius: 1}, '
            'roles: {illustration: {}}}]',
            'base/p has kIllustration',
        ),
        (
            'geometries: [{name: p, frame: base, source: arm, shape: {type: sphere, radius: 1}, '
            'roles: {proximity: {proximity: {padding: 0.1}}}}]',
            'property proximity/padding = 0.1',
        ),
        ('filters: [{clique: {name: c, members: [base/foot, lower]}}]', 'and not single ones'),
    ],
)
def test_what_a_urdf_cannot_hold_is_named(tmp_path, keys, fault):
    (tmp_path / 'arm.urdf').write_text(ARM)
    path = tmp_path / 'scene.yaml'
    path.write_text(f'robots: [{{name: arm, urdf: arm.urdf}}]\n{keys}\n')
    with pytest.raises(SceneFileError, match=fault):
        to_urdf(read_scene(path))


@pytest.mark.parametrize(
    ('robot', 'fault'),
    [
        ('pose: {position: [1, 0, 0]}', 'first poses of free links: base'),
        ('configuration: {a: 0.5}', 'first joint values: a'),
        ('adjacent_links: kept', 'reported here, as of links at one joint: base/collision_0'),
        ('solid_meshes: []', None),
    ],
)
def test_keys_of_a_robot_that_a_urdf_cannot_hold_are_named(tmp_path, robot, fault):
    (tmp_path / 'arm.urdf').write_text(ARM)
    path = tmp_path / 'scene.yaml'
    path.write_text(f'robots: [{{name: arm, urdf: arm.urdf, {robot}}}]\n')
    if fault is None:
        assert read_scene(to_urdf(read_scene(path))).robots[0].name == 'arm'
        return
    with pytest.raises(SceneFileError, match=fault):
        to_urdf(read_scene(path))


def test_several_models_are_refused_by_name():
    model = SDF.format('false', '0 0 0 0 0 0')
    several = model.replace('</sdf>', '<model name="b"><link name="l"/></model></sdf>')
    with pytest.raises(SceneFileError, match='2 robots with the sources cart, b'):
        to_urdf(read_scene(several))


def test_a_mesh_file_is_a_robot_of_one_link(tmp_path):
    path = tmp_path / 'part.obj'
    path.write_text(obj_text(BOX, SIDES))
    again = read_scene(to_urdf(read_scene(path)))
    (geometry,) = again.geometries
    assert [robot.name for robot in again.robots] == ['part']
    assert (geometry.frame, geometry.name) == ('body', 'mesh')
    np.testing.assert_array_equal(geometry.shape.surface()[0], BOX)
    with pytest.raises(SceneFileError, match='mesh/solid'):
        to_urdf(read_scene(path, options=RobotOptions(solid_meshes=('*',))))
