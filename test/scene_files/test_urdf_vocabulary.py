"""What a URDF says that is not understood: refused, or named once, with its line."""

import pytest

from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.urdf_vocabulary import check_vocabulary
from drake_geom_ros.scene_files.xml_tree import read_robot_xml

DRAKE = 'xmlns:drake="http://drake.mit.edu"'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
BOX = '<geometry><box size="1 1 1"/></geometry>'


def warnings(text):
    return check_vocabulary(read_robot_xml(text.encode(), 'r.urdf'), 'r.urdf')


def robot(inside, attributes=''):
    return f'<robot name="r" {attributes}>\n{inside}</robot>'


def link(inside):
    return robot(f'<link name="a">{inside}</link>')


def test_what_changes_no_answer_is_not_told():
    assert not warnings(
        robot(
            '<material name="red"/><transmission name="t"><joint name="j"/></transmission>'
            '<gazebo reference="a"><selfCollide>true</selfCollide></gazebo><ros2_control/>'
            '<link name="a"><inertial><mass value="1"/></inertial><visual><geometry><mesh '
            'filename="a.dae"/></geometry></visual><collision name="c"><origin xyz="0 0 0"/>'
            f'{BOX}<verbose value="1"/><drake:proximity_properties/></collision></link>'
            '<joint name="j" type="fixed"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
            '<dynamics damping="1"/><limit lower="0" upper="1" effort="2" velocity="1" '
            'drake:acceleration="9" current="5"/><safety_controller k_velocity="1"/></joint>'
            '<drake:collision_filter_group name="g"><drake:member link="a"/>'
            '</drake:collision_filter_group>',
            f'version="1.1" {DRAKE}',
        )
    )


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        (link('<collison/>'), 'r.urdf:2: link[a].collison: <collison> in <link> is not'),
        (link('<origin xyz="0 0 1"/>'), '<origin> in <link> is not understood. It is left out'),
        (robot('<include href="b.urdf"/>'), '<include> in <robot> is not understood'),
        (robot('<drake:hinge/>', DRAKE), '<drake:hinge> in <robot> is not understood'),
        (
            robot('<drake:link name="a"/>', DRAKE),
            'drake:link> in <robot> is not understood',
        ),
        (
            link('<collision><geometry><box size="1 1 1" xmlns:b="b" b:size="1"/></geometry>'
                 '</collision>'),
            'the attribute `size` of <box>',
        ),
        (
            link('<collision><geometry><mesh filename="a" make_convex="0"/></geometry>'
                 '</collision>'),
            'the attribute `make_convex` of <mesh> is not understood; known: filename, scale',
        ),
        (
            link('<collision><geometry><box size="1 1 1" unit="mm"/></geometry></collision>'),
            'the attribute `unit` of <box> is not understood; known: size. It is left out',
        ),
        (robot('<link name="a" drake_ignore="true"/>'), 'the attribute `drake_ignore` of <link>'),
        (robot('<link name="a"/>', 'version="2.0"'), "version '2.0'; known are 1, 1.0, 1.1, 1.2"),
    ],
)  # fmt: skip
def test_what_may_change_an_answer_is_named_with_its_place(text, told):
    (warning,) = warnings(text)
    assert told in warning
    assert warning.startswith('r.urdf:')


def test_things_of_a_kind_are_named_once_and_counted():
    links = ''.join(f'<link name="{name}"><glue/></link>\n' for name in 'abc')
    (warning,) = warnings(robot(links))
    assert warning == (
        'r.urdf:2: link[a].glue: <glue> in <link> is not understood. It is left out '
        '(and 2 more like it)'
    )


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (
            link(f'<collision><origin xyz="0 0 0" rpy_deg="0 0 90"/>{BOX}</collision>'),
            'the attribute `rpy_deg` of <origin> is not understood; known: quat_xyzw, rpy, wxyz',
        ),
        (link(f'<Collision>{BOX}</Collision>'), '`Collision` must be written `collision`'),
        (link('<collision><origin RPY="0 0 1"/></collision>'), '`RPY` must be written `rpy`'),
        (robot('<LINK name="a"/>'), '`LINK` must be written `link`'),
        (
            link(f'<collision>{BOX}{BOX}</collision>'),
            'a second <geometry> in one <collision>; one is allowed',
        ),
        (link(f'<collision><origin/><origin/>{BOX}</collision>'), 'a second <origin>'),
        (robot('<joint name="j" type="fixed"><axis/><axis/></joint>'), 'a second <axis>'),
        (robot('<xacro:arm prefix="l"/>', XACRO), '<xacro:arm> is xacro: run xacro first'),
        (link('<xacro:shape xmlns:xacro="http://wiki.ros.org/xacro"/>'), 'is xacro'),
        (robot('<link name="${prefix}a"/>'), r"name = '\${prefix}a' is xacro: run xacro first"),
        (robot('<link name="$(arg a)"/>'), 'is xacro'),
    ],
)
def test_what_cannot_be_meant_as_it_is_read_is_refused(text, message):
    with pytest.raises(SceneFileError, match=rf'r\.urdf:2: .*{message}'):
        warnings(text)
