"""What an SRDF says of pairs, by MoveIt's rules."""

from itertools import combinations

import pytest

from drake_geom_ros.geometry import GeometryInstance, ProximityProperties, SceneGraph, Sphere
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene, register
from drake_geom_ros.scene_files.description import Member, Operation, RobotOptions, Statement
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.srdf import link_groups, read_srdf

PLAIN = RobotOptions()
SRDF = b"""<robot name="arm">
<group name="g"><link name="x"/></group>
<disable_collisions link1="a" link2="b" reason="Adjacent"/>
<disable_collisions link1="b" link2=" c "/>
</robot>"""


def read(body, options=PLAIN):
    data = body if isinstance(body, bytes) else f'<robot name="arm">\n{body}</robot>'.encode()
    return read_srdf(data, 'r.srdf', 'left', 'arm', 'abc', options)


def test_an_srdf_is_one_declaration():
    (declaration,), warnings = read(SRDF).filters, read(SRDF).warnings
    a, b, c = ((Member('left', link),) for link in 'abc')
    assert declaration.statements == (
        Statement(Operation.EXCLUDE_BETWEEN, a, b),
        Statement(Operation.EXCLUDE_BETWEEN, b, c),
    )
    assert warnings == ()
    (kept,) = read(SRDF, RobotOptions(filter_adjacent_links=False)).filters
    assert kept.statements == declaration.statements[1:]


@pytest.mark.parametrize(
    ('data', 'message'),
    [
        (SRDF.replace(b'link2=" c "', b''), 'r.srdf:4: disable_collisions: missing attribute'),
        (b'<robot>', 'r.srdf:1: not XML'),
        (b'<robot/>', 'r.srdf:1: missing attribute `name`'),
        (b'<robot name="arm" xmlns:xacro="x"><xacro:pairs/></robot>', 'r.srdf:1: pairs: <xacro:p'),
    ],
)
def test_a_bad_srdf_is_refused_with_its_line(data, message):
    with pytest.raises(SceneFileError) as caught:
        read(data)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ('body', 'told'),
    [
        ('<disable_collisions link1="a" link2="b_sc"/>',
         "r.srdf:2: disable_collisions: link 'b_sc' is not in the robot 'left'; the entry is left "
         'out'),
        ('<enable_collisions link1="x" link2="b"/>', "enable_collisions: link 'x' is not in the"),
        ('<disable_default_collisions link="x"/>', "disable_default_collisions: link 'x' is not"),
        ('<virtual_joint name="v" type="fixed" parent_frame="world" child_link="x"/>',
         "virtual_joint[v]: link 'x' is not in the"),
        ('<disable_collision link1="a" link2="b"/>', '<disable_collision> is not understood'),
        ('<group name="g"><disable_collisions link1="a" link2="b"/></group>',
         '<disable_collisions> counts directly in <robot> only'),
    ],
)  # fmt: skip
def test_what_is_left_out_is_told_by_name(body, told):
    (warning,) = read(body).warnings
    assert told in warning
    (declaration,) = read(body).filters
    assert declaration.statements == ()


def test_what_means_nothing_here_is_not_told():
    body = """<group name="g"><chain base_link="a" tip_link="c"/></group>
<group_state name="home" group="g"/><end_effector name="e" parent_link="c" group="g"/>
<virtual_joint name="v" type="fixed" parent_frame="world" child_link="a"/>
<passive_joint name="p"/><joint_property joint_name="j"/>
<link_sphere_approximation link="a"/><disable_collisions link1="world" link2="a"/>"""
    assert read(body).warnings == ()


def test_an_srdf_of_another_robot_is_told():
    (warning,) = read(SRDF.replace(b'"arm"', b'"leg"')).warnings
    assert "the SRDF is of the robot 'leg', the URDF of 'arm'" in warning


# Four balls in one place, hanging from one another, and what is not said: "a" to "d" are links.
URDF = '<robot name="arm">{}</robot>'.format(
    ''.join(
        f'<link name="{link}"><collision name="s"><geometry><sphere radius="1"/></geometry>'
        '</collision></link>'
        for link in 'abcd'
    )
    + ''.join(
        f'<joint name="{a}{b}" type="revolute"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in ('ab', 'bc', 'cd')
    )
)


def reported(body, **options):
    """Return the pairs of links that are reported, and of links with a ball in the world."""
    srdf = f'<robot name="arm">{body}</robot>'
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(URDF, srdf=srdf, options=RobotOptions(**options)))
    ball = GeometryInstance(RigidTransform(), Sphere(1), 'ball')
    ball.set_proximity_properties(ProximityProperties())
    # It comes later: a default holds for it as well.
    scene_graph.RegisterAnchoredGeometry(scene_graph.RegisterSource('later'), ball)
    inspector, manager = scene_graph.model_inspector(), scene_graph.collision_filter_manager()
    names = {g: inspector.GetName(inspector.GetFrameId(g)) for g in inspector.GetAllGeometryIds()}
    return {
        f'{names[a]}{names[b]}'.replace('world', 'W')
        for a, b in combinations(names, 2)
        if not manager.explain(a, b)
    }


ALL = {'ac', 'ad', 'bd', 'aW', 'bW', 'cW', 'dW'}


@pytest.mark.parametrize(
    ('body', 'gone', 'options'),
    [
        ('', set(), {}),
        ('<disable_default_collisions link="a"/>', {'ac', 'ad', 'aW'}, {}),
        ('<disable_default_collisions link="a"/><disable_default_collisions link="c"/>',
         {'ac', 'ad', 'aW', 'cW'}, {}),
        ('<disable_default_collisions link="a"/><enable_collisions link1="d" link2="a"/>',
         {'ac', 'aW'}, {}),
        # The order in the file does not count: what is disabled has the last word.
        ('<disable_collisions link1="a" link2="d"/><enable_collisions link1="a" link2="d"/>'
         '<disable_default_collisions link="a"/>', {'ac', 'ad', 'aW'}, {}),
        ('<disable_default_collisions link="a"/><enable_collisions link1="d" link2="a"/>',
         {'ac', 'ad', 'aW', 'bd'}, {'filter_self_collisions': True}),
    ],
)  # fmt: skip
def test_pairs_are_switched_as_by_moveit(body, gone, options):
    assert reported(body, **options) == ALL - gone


def test_a_pair_that_is_enabled_counts_though_a_joint_connects_it():
    assert reported('<enable_collisions link1="a" link2="b"/>') == {*ALL, 'ab'}


GROUPED = """<robot name="arm">
<group name="links"><link name="a"/><link name="nobody"/></group>
<group name="joints"><joint name="bc"/><joint name="base_fixed"/></group>
<group name="chain"><chain base_link="a" tip_link="c"/></group>
<group name="elsewhere"><chain base_link="d" tip_link="b"/></group>
<group name="all"><group name="ring"/><group name="chain"/><group name="gone"/></group>
<group name="ring"><link name="d"/><group name="all"/></group>
<end_effector name="hand" group="links" parent_link="b"/>
</robot>"""
CHAIN = LinkTree(
    'arm',
    ('a', 'b', 'c', 'd'),
    tuple(
        UrdfJoint('fixed', parent, child, f'{parent}{child}', RigidTransform(), (1.0, 0.0, 0.0))
        for parent, child in ('ab', 'bc', 'ad')
    ),
)


def test_a_group_has_its_links_joints_chains_and_groups():
    assert link_groups(GROUPED.encode(), 'r.srdf', CHAIN) == {
        'links': ('a',),
        'joints': ('c',),
        'chain': ('b', 'c'),
        'elsewhere': ('b', 'd'),
        'all': ('b', 'c', 'd'),
        'ring': ('b', 'c', 'd'),
    }
