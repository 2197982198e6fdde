"""A robot that comes as text, and another one in its place, without ROS."""

from itertools import pairwise

import pytest
from live.live_scenes import live_scene
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.geometry import CollisionFilterDeclaration, GeometrySet
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.scene.prepared_scene import prepared
from drake_geom_ros.scene_files import RobotOptions, read_scene

TABLE = """
sources: [room]
frames:
  - {name: table, source: room, pose: {position: [0, 0, 2]}}
geometries:
  - {name: top, source: room, frame: table, shape: {type: box, size: [1, 1, 1]}}
  - {name: leg, source: room, frame: table, shape: {type: box, size: [1, 1, 1]}}
"""


def link(name, radius):
    sphere = f'<collision><geometry><sphere radius="{radius}"/></geometry></collision>'
    return f'<link name="{name}">{sphere}</link>'


def urdf(name, *links, radius=0.1):
    joints = ''.join(
        f'<joint name="j{k}" type="revolute"><parent link="{a}"/><child link="{b}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k, (a, b) in enumerate(pairwise(links))
    )
    return f'<robot name="{name}">{"".join(link(each, radius) for each in links)}{joints}</robot>'


@pytest.fixture
def live():
    return live_scene(TABLE)


@pytest.fixture
def robot(live):
    return RobotInput(live)


def frames(scene):
    return {name for name in scene.model.names.frame_names.values() if name != 'world'}


def explain(scene, a, b):
    manager = scene.model.scene_graph.collision_filter_manager()
    return manager.explain(*(scene.model.names.geometry(f'{name}/collision_0') for name in (a, b)))


def test_a_robot_becomes_a_source_with_adjacent_links_filtered(scene, robot):
    assert 'added' in robot.take(urdf('arm', 'base', 'upper', 'hand'))
    assert frames(scene) == {'room::table', 'arm::base', 'arm::upper', 'arm::hand'}
    assert explain(scene, 'base', 'upper')
    assert not explain(scene, 'base', 'hand')


def test_the_same_text_again_changes_nothing(scene, robot):
    text = urdf('arm', 'base', 'hand')
    robot.take(text)
    version = scene.model.version
    assert robot.take(text) == ''
    assert scene.model.version == version


def test_a_robot_that_was_lost_with_its_scene_comes_back(scene, robot):
    text = urdf('arm', 'base', 'hand')
    robot.take(text)
    scene.replace(prepared(read_scene(TABLE)))
    assert 'added' in robot.take(text)
    assert 'arm::hand' in frames(scene)


def test_another_text_takes_its_place_and_all_else_stays(scene, robot):
    robot.take(urdf('arm', 'base', 'upper', 'hand'))
    manager = scene.model.scene_graph.collision_filter_manager()
    names = ('table/top', 'hand/collision_0', 'base/collision_0')
    top, hand, base = (scene.model.names.geometry(name) for name in names)
    leg = scene.model.names.geometry('table/leg')
    manager.Apply(
        CollisionFilterDeclaration()
        .ExcludeBetween(GeometrySet([top]), GeometrySet([hand]))
        .ExcludeBetween(GeometrySet([leg]), GeometrySet([base]))
        .ExcludeWithin(GeometrySet([top, leg]))
    )
    version = scene.model.version
    assert "replaces 'arm'" in robot.take(urdf('arm2', 'base', 'grip', radius=0.2))
    assert scene.model.version > version
    assert frames(scene) == {'room::table', 'arm2::base', 'arm2::grip'}
    assert scene.query.X_WF(scene.model.names.frame('table')).translation()[2] == 2.0
    assert explain(scene, 'base', 'grip')
    # Filters between the table and the robot of before are gone with it.
    manager = scene.model.scene_graph.collision_filter_manager()
    for one, other in (('table/top', 'grip/collision_0'), ('table/leg', 'base/collision_0')):
        assert not manager.explain(
            scene.model.names.geometry(one), scene.model.names.geometry(other)
        )


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('', 'text'),
        ('no robot', '<text>'),
        (urdf('arm', 'base', radius=-1.0), 'radius'),
        (urdf('room', 'base'), 'has a source of that name'),
        ('<robot name="x"><link name="a"/><link name="a"/></robot>', 'twice'),
        ('<robot name="foo"></robot>', 'no links; a robot has at least one'),
        (urdf('arm', 'base', 'upper', 'hand').replace('j1', 'j0'), "'j0' is listed twice"),
        (urdf('arm', 'base', 'hand', 'base'), 'listed twice'),
        (urdf('arm', 'a', 'b', 'c').replace('parent link="a"', 'parent link="c"'), 'form a ring'),
        (urdf('arm', 'a', 'b', 'c').replace('child link="c"', 'child link="b"'), 'two parents'),
        (urdf('arm', 'a', 'b').replace('child link="b"', 'child link="c"'), "'c' is not in the"),
        (urdf('arm', 'a', 'b').replace('<axis', '<origin xyz="0,0,1"/><axis'), '3 numbers'),
        (urdf('arm', 'a', 'b').replace('<axis', '<origin rot="0 0 1"/><axis'), '`rot` of <origin'),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(scene, robot, text, words):
    robot.take(urdf('arm', 'base', 'hand'))
    version, before = scene.model.version, frames(scene)
    with pytest.raises(RuntimeError, match=words):
        robot.take(text)
    assert (scene.model.version, frames(scene)) == (version, before)


def test_what_is_not_understood_is_told_with_the_robot(scene, robot):
    text = urdf('arm', 'base', 'hand').replace('<sphere', '<sphere unit="mm"')
    assert 'added' in robot.take(text)
    (warning,) = scene.log.warnings
    assert warning.startswith(
        '<text>:1: link[base].collision.geometry.sphere: the attribute `unit`'
    )


def test_links_without_a_collision_shape_are_named_in_the_log(scene, robot):
    drawn = '<link name="cover"><visual><geometry><sphere radius="1"/></geometry></visual></link>'
    text = urdf('arm', 'base', 'hand').replace('</robot>', f'{drawn}</robot>')
    assert '1 warning' in robot.take(text)
    (warning,) = scene.log.warnings
    assert 'have visuals and no collision geometry, so no query sees them: cover.' in warning


def test_meshes_come_from_the_roots_only(scene, robot, tmp_path):
    mesh = tmp_path / 'ball.obj'
    mesh.write_text(TETRAHEDRON)
    shape = f'<collision><geometry><mesh filename="file://{mesh}"/></geometry></collision>'
    with pytest.raises(RuntimeError, match='outside'):
        robot.take(f'<robot name="arm"><link name="base">{shape}</link></robot>')


def srdf(name, first, second):
    pair = f'link1="{first}" link2="{second}" reason="Never"'
    return f'<robot name="{name}"><disable_collisions {pair}/></robot>'


def test_an_srdf_leaves_out_its_pairs_whether_it_comes_before_or_after(scene, robot):
    assert (
        robot.take_semantics(srdf('arm', 'base', 'hand')) == "the SRDF of 'arm' waits for its URDF"
    )
    assert robot.take_semantics(srdf('arm', 'base', 'hand')) == ''
    assert 'pairs of its SRDF left out' in robot.take(urdf('arm', 'base', 'upper', 'hand'))
    assert explain(scene, 'base', 'hand')
    version = scene.model.version
    assert robot.take_semantics(srdf('arm', 'base', 'hand')) == ''
    assert scene.model.version == version
    # Another one takes its place, as another robot would.
    robot.take(urdf('arm', 'base', 'upper', 'wrist', 'hand'))
    assert "replaces 'arm'" in robot.take_semantics(srdf('arm', 'upper', 'hand'))
    assert not explain(scene, 'base', 'hand')
    assert explain(scene, 'upper', 'hand')


def test_an_srdf_of_another_robot_or_that_is_none_changes_nothing(scene, robot):
    robot.take(urdf('arm', 'base', 'upper', 'hand'))
    version = scene.model.version
    told = "the SRDF of 'leg' waits for its URDF; the robot is 'arm'"
    assert robot.take_semantics(srdf('leg', 'base', 'hand')) == told
    with pytest.raises(RuntimeError, match='text'):
        robot.take_semantics('no srdf')
    assert scene.model.version == version
    assert 'left out' not in robot.take(urdf('arm', 'base', 'hand'))


def test_of_an_srdf_with_unknown_links_the_rest_counts(scene, robot):
    robot.take(urdf('arm', 'base', 'upper', 'hand'))
    text = srdf('arm', 'base', 'toe').replace('</robot>', '')
    text += srdf('arm', 'base', 'hand').partition('>')[2]
    assert robot.take_semantics(text).endswith('left out, 1 warning')
    assert explain(scene, 'base', 'hand')
    (warning,) = scene.log.warnings
    assert "disable_collisions: link 'toe' is not in the robot 'arm'" in warning


def test_a_robot_that_its_srdf_does_not_fit_is_told(scene, robot):
    """Another model of that name: its own SRDF may come after it, and all pairs count."""
    robot.take_semantics(srdf('arm', 'base', 'hand'))
    robot.take(urdf('arm', 'base', 'upper', 'hand'))
    told = robot.take(urdf('arm', 'base', 'upper', 'grip'))
    assert '1 warning' in told
    assert "link 'hand' is not in the robot 'arm'" in scene.log.warnings[-1]
    assert not explain(scene, 'base', 'grip')
    assert 'pairs of its SRDF left out' in robot.take_semantics(srdf('arm', 'base', 'grip'))
    assert explain(scene, 'base', 'grip')


def test_what_parameters_say_of_robots_holds_for_one_that_comes_by_topic(
    scene, live, robot, tmp_path
):
    mesh = tmp_path / 'ball.obj'
    mesh.write_text(TETRAHEDRON)
    live.files = FileAccess([], package_roots=[str(tmp_path)])
    live.robot_options = RobotOptions(
        filter_self_collisions=True, solid_meshes=('t*',), paddings=(('*', 0.01), ('base', 0.02))
    )
    shape = f'<collision><geometry><mesh filename="file://{mesh}"/></geometry></collision>'
    links = ''.join(f'<link name="{name}">{shape}</link>' for name in ('tool', 'base', 'far'))
    done = robot.take(f'<robot name="arm">{links}</robot>')
    assert done.endswith('; of 2 meshes the convex hull counts')
    assert explain(scene, 'base', 'far')
    for name, solid, padding in (('tool', True, 0.01), ('base', False, 0.02)):
        geometry = scene.model.names.geometry(f'{name}/collision_0')
        properties = scene.model.inspector.GetProximityProperties(geometry)
        assert properties.GetPropertyOrDefault('mesh', 'solid', False) is solid
        assert properties.GetProperty('proximity', 'padding') == padding


SDF = """<sdf version="1.9"><model name="arm"><link name="base"><collision name="c"><geometry>
<sphere><radius>0.1</radius></sphere></geometry></collision></link><link name="upper"><collision
name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link><joint
name="j" type="revolute"><parent>base</parent><child>upper</child><axis><xyz>0 0 1</xyz></axis>
</joint></model></sdf>"""


def test_a_model_of_sdformat_is_a_robot_whose_frames_wait(scene, robot):
    assert "robot 'arm' added: 2 links, 2 shapes" in robot.take(SDF)
    assert frames(scene) == {'room::table', 'arm::base', 'arm::upper'}
    waiting = {scene.model.names.frame_names[f] for f in scene.query.waiting_frames()}
    assert waiting == {'arm::base', 'arm::upper'}
    assert 'replaces' in robot.take(SDF.replace('upper', 'lower'))


def test_a_text_of_several_models_is_refused(scene, robot):
    model = SDF[SDF.index('<model') : SDF.index('</sdf>')]
    with pytest.raises(RuntimeError, match='2 models; a robot is one'):
        robot.take(SDF.replace('</sdf>', f'{model.replace("arm", "other")}</sdf>'))
