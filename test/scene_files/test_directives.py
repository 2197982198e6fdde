"""Drake's model directives: their meaning as in pydrake, and refusals with their lines."""

import math

import pytest
from oracles.like_drake import compared

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import Member, load_scene, read_scene
from drake_geom_ros.scene_files.errors import SceneFileError

INERTIA = (
    '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    '</inertial>'
)
BALL = '<collision><geometry><sphere radius="0.2"/></geometry></collision>'
ARM = f"""<robot name="arm" xmlns:drake="http://drake.mit.edu">
<link name="base">{INERTIA}{BALL}</link>
<link name="upper">{INERTIA}{BALL}</link>
<link name="tip">{INERTIA}{BALL}</link>
<joint name="j" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/>
</joint>
<joint name="f" type="fixed"><parent link="upper"/><child link="tip"/><origin xyz="0.3 0 0"/>
</joint>
<frame name="tool" link="tip" xyz="0 0 0.1" rpy="0 0.5 0"/>
<drake:collision_filter_group name="ends"><drake:member link="tip"/></drake:collision_filter_group>
</robot>"""
CUP = f'<robot name="cup"><link name="cup">{INERTIA}{BALL}</link></robot>'

TWO = """directives:
- add_model: {name: left, file: package://parts/arm.urdf}
- add_model: {name: cup, file: package://parts/cup.urdf}
"""
STANDS = '- add_weld: {parent: world, child: left::base}\n'
CASES = {
    'free models': TWO,
    'a weld to the world': TWO
    + """- add_weld:
    parent: world
    child: left::base
    X_PC: {translation: [1, 2, 3], rotation: !Rpy {deg: [30, 40, 50]}}
""",
    'an angle and an axis': TWO
    + """- add_weld:
    parent: world
    child: left::base
    X_PC: {rotation: !AngleAxis {angle_deg: 30, axis: [1, 2, 0]}}
""",
    'no rotation': TWO
    + '- add_weld: {parent: world, child: left::base, X_PC: {rotation: !Identity {}}}\n',
    'a weld to a link, which is filtered': TWO
    + STANDS
    + '- add_weld: {parent: left::tip, child: cup::cup, X_PC: {translation: [0, 0.1, 0]}}\n',
    'a weld to a moving robot': TWO + '- add_weld: {parent: left::base, child: cup::cup}\n',
    'a weld to a frame of the file': TWO
    + STANDS
    + '- add_weld: {parent: left::tool, child: cup::cup}\n',
    'frames of directives': TWO
    + STANDS
    + """- add_frame:
    name: grip
    X_PF: {base_frame: left::tip, translation: [0, 0, 0.4]}
- add_frame:
    name: cup::handle
    X_PF: {base_frame: cup::cup, translation: [0.1, 0, 0], rotation: !Rpy {deg: [90, 0, 0]}}
- add_weld: {parent: grip, child: cup::handle}
""",
    'a frame in the world': TWO
    + """- add_frame:
    name: corner
    X_PF: {base_frame: world, translation: [4, 0, 0]}
- add_weld: {parent: corner, child: left::base}
""",
    'directives in a namespace': """directives:
- add_model_instance: {name: cell}
- add_directives: {file: package://parts/inner.dmd.yaml, model_namespace: cell}
- add_directives: {file: package://parts/inner.dmd.yaml}
- add_weld: {parent: cell::left::tool, child: cup::cup}
""",
    'groups': TWO
    + """- add_collision_filter_group:
    name: g
    members: [left::base, cup::cup]
    ignored_collision_filter_groups: [g]
""",
    'a group in a group': TWO
    + """- add_collision_filter_group:
    name: h
    members: [left::base]
- add_collision_filter_group:
    name: g
    members: [cup::cup]
    member_groups: [h]
    ignored_collision_filter_groups: [g]
""",
    'a group of a model': TWO
    + """- add_collision_filter_group:
    name: g
    members: [cup::cup]
    ignored_collision_filter_groups: ['left::ends']
""",
    'a namespace of a group': TWO
    + """- add_collision_filter_group:
    name: g
    model_namespace: left
    members: [base]
- add_collision_filter_group:
    name: h
    members: [cup::cup]
    ignored_collision_filter_groups: ['left::g']
""",
}


@pytest.fixture
def parts(tmp_path):
    """The folder of the package ``parts``."""
    folder = tmp_path / 'parts'
    folder.mkdir()
    (folder / 'package.xml').write_text('<package><name>parts</name></package>')
    (folder / 'arm.urdf').write_text(ARM)
    (folder / 'cup.urdf').write_text(CUP)
    (folder / 'inner.dmd.yaml').write_text(
        TWO + '- add_weld: {parent: world, child: left::base}\n'
    )
    return folder


def written(folder, text):
    path = folder / 'scene.dmd.yaml'
    path.write_text(text)
    return path


@pytest.mark.parametrize('text', CASES.values(), ids=CASES.keys())
def test_models_are_those_of_pydrake(parts, text):
    pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    assert not compared(written(parts, text), [parts])


def test_a_model_that_nothing_holds_waits_for_its_pose(parts):
    scene = read_scene(written(parts, TWO + STANDS))
    poses = {(frame.source, frame.name): frame.X_PF for frame in scene.frames}
    assert poses['cup', 'cup'] is None
    assert poses['left', 'base'].IsExactlyIdentity()
    assert poses['left', 'upper'] is None


def test_a_free_body_has_the_pose_of_the_directive(parts):
    text = TWO.replace(
        'file: package://parts/cup.urdf',
        'file: package://parts/cup.urdf, default_free_body_pose: {cup: {base_frame: left::base, '
        'translation: [0, 0, 5]}}',
    )
    text += '- add_weld: {parent: world, child: left::base, X_PC: {translation: [1, 0, 0]}}\n'
    scene = read_scene(written(parts, text))
    (cup,) = (frame for frame in scene.frames if frame.source == 'cup')
    assert cup.X_PF.translation().tolist() == [1.0, 0.0, 5.0]
    assert cup.mounted_on is None


def test_joint_values_pose_the_links(parts):
    text = TWO.replace(
        'package://parts/arm.urdf', 'package://parts/arm.urdf, default_joint_positions: {j: [0.5]}'
    )
    scene = read_scene(written(parts, text + STANDS))
    assert scene.robots[0].configuration == {'j': 0.5}
    poses = {frame.name: frame.X_PF for frame in scene.frames}
    expected = [0.5 + 0.3 * math.cos(0.5), 0.3 * math.sin(0.5), 0.0]
    assert poses['tip'].translation().tolist() == pytest.approx(expected, abs=1e-15)


def test_a_mounted_model_is_carried(parts):
    text = TWO + STANDS + '- add_weld: {parent: left::tip, child: cup::cup}\n'
    loaded = load_scene(written(parts, text), SceneGraph())
    assert loaded.robots['cup'].mounted_on == Member('left', 'tip')
    assert loaded.frames.keys() == {
        ('left', 'base'),
        ('left', 'upper'),
        ('left', 'tip'),
        ('cup', 'cup'),
    }


def test_groups_that_hold_each_other_by_many_ways_are_read_once(parts):
    # Each of the groups holds the next twice: there are 2**60 ways to the last.
    text = TWO + STANDS + '- add_collision_filter_group: {name: g60, members: [cup::cup]}\n'
    for k in range(60):
        text += (
            f'- add_collision_filter_group: {{name: g{k}, members: [left::base], '
            f'member_groups: [g{k + 1}, g{k + 1}, g0], ignored_collision_filter_groups: [g{k}]}}\n'
        )
    scene_graph = SceneGraph()
    loaded = load_scene(written(parts, text), scene_graph)
    id_of = {(source, frame): id for (source, frame, _), id in loaded.geometries.items()}
    filtered = scene_graph.model_inspector().CollisionFiltered
    assert filtered(id_of['left', 'base'], id_of['cup', 'cup'])
    assert not filtered(id_of['left', 'tip'], id_of['cup', 'cup'])


def test_a_text_of_directives_is_known_by_its_key(parts):
    scene = read_scene(TWO, package_roots=[parts])
    assert scene.sources == ('left', 'cup')


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        (TWO + '- add_weld: {parent: world, child: left::bass}', r'4: .*child: .*left::base'),
        (TWO + '- add_weld: {parent: world, child: tip}', r'4: .*not the root .*free are base'),
        (TWO + STANDS + STANDS, r'5: .*a joint or a weld holds it'),
        (TWO + '- add_weld: {parent: left::base, child: world}', r'4: .*the child is the world'),
        (
            TWO + '- add_weld: {parent: left::tip, child: cup::cup}\n'
            '- add_weld: {parent: cup::cup, child: left::base}',
            r'in a circle',
        ),
        (TWO + '- add_model_instance: {name: left}', r'4: .*already, see line 2'),
        (TWO + '- add_thing: {name: left}', r'4: .*add_thing'),
        (TWO + '- add_model: {name: x, file: absent.urdf}', r'4: .*absent.urdf'),
        (TWO + '- add_model: {name: x, file: cup.urdf, scale: 2}', r'4: .*scale'),
        (
            TWO
            + '- add_weld: {parent: world, child: cup::cup, X_PC: {rotation: {deg: [1, 2, 3]}}}',
            r'4: .*rotation: must be !Rpy',
        ),
        (
            TWO + '- add_weld: {parent: world, child: cup::cup, X_PC: {rotation: !Uniform {}}}',
            r'4: .*tag !Uniform',
        ),
        (
            TWO + '- add_weld: {parent: world, child: cup::cup, X_PC: !Rpy {translation: '
            '[1, 2, 3]}}',
            r'4: .*the rotation alone',
        ),
        (
            TWO + '- add_weld: {parent: world, child: cup::cup, X_PC: {rotation: !AngleAxis '
            '{angle_deg: 1, axis: [0, 0, 0]}}}',
            r'4: .*axis: the axis must not be zero',
        ),
        (
            TWO + '- add_frame: {name: left::base, X_PF: {base_frame: world}}',
            r'4: .*already',
        ),
        (
            TWO + '- add_model: {name: x, file: arm.urdf}\n'
            '- add_frame: {name: f, X_PF: {base_frame: tip}}',
            r"5: .*several frames: 'left::tip', 'x::tip'",
        ),
        (
            TWO + '- add_collision_filter_group: {name: g, members: [left::tool]}',
            r'4: .*members\[0\]: .*not a link',
        ),
        (
            TWO + '- add_collision_filter_group: {name: g, member_groups: [h]}',
            r'4: .*member_groups\[0\]: .*no collision filter group',
        ),
        (
            TWO + '- add_model: {name: x, file: arm.urdf, default_joint_positions: {j: [1, 2]}}',
            r'4: .*j: 2 values of the revolute joint',
        ),
        (
            TWO + '- add_model: {name: x, file: arm.urdf, default_joint_positions: {k: [1]}}',
            r'4: .*no joint .k.; there are j, f',
        ),
        (
            TWO + '- add_model: {name: x, file: arm.urdf, default_free_body_pose: {tip: {}}}',
            r'not a free link',
        ),
        (
            TWO + '- add_model: {name: x, file: cup.urdf, default_free_body_pose: {"": '
            '{base_frame: left::tip}}}',
            r'which has no pose itself',
        ),
    ],
)
def test_what_is_refused_is_named_with_its_line(parts, text, fault):
    with pytest.raises(SceneFileError, match=fault):
        read_scene(written(parts, text))


def test_directives_that_include_themselves_are_refused(parts):
    path = written(parts, 'directives:\n- add_directives: {file: scene.dmd.yaml}\n')
    with pytest.raises(SceneFileError, match=r'2: .*includes itself'):
        read_scene(path)


def test_anchors_stand_for_what_they_name(parts):
    pose = '{translation: [1, 0, 0], rotation: !Rpy {deg: [0, 0, 90]}}'
    text = f'{TWO}- add_weld: {{parent: world, child: left::base, X_PC: &X {pose}}}\n'
    text += '- add_weld: {parent: left::tip, child: cup::cup, X_PC: *X}\n'
    first, second = (robot.X_WB for robot in read_scene(written(parts, text)).robots)
    assert first.IsExactlyEqualTo(second)
    assert first.translation().tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize('alias', ['*absent', '&a [*a]'])
def test_an_alias_of_nothing_or_of_itself_is_refused(parts, alias):
    with pytest.raises(SceneFileError, match=r'1: .*alias'):
        read_scene(written(parts, f'directives: {alias}'))


def test_scene_files_have_no_tags(tmp_path):
    (tmp_path / 's.yaml').write_text('frames:\n- {name: a, pose: !Rpy {position: [0, 0, 1]}}')
    with pytest.raises(SceneFileError, match=r'2: .*a scene has no tags'):
        read_scene(tmp_path / 's.yaml')
