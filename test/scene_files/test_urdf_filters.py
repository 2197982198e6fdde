from types import SimpleNamespace

import pytest
from lxml import etree

from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    GroupDescription,
    Member,
    RobotOptions,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.urdf_filters import (
    Joint,
    adjacent_cliques,
    moved_links,
    read_groups,
    self_cliques,
    undriven_joints,
)
from drake_geom_ros.scene_files.urdf_tree import read_joints

OLDER = """<robot>
<link name="body1"/><link name="body2"/><link name="body3"/>
<collision_filter_group name="group1">
  <member link="body1"/>
  <member link="body2"/>
  <ignored_collision_filter_group collision_filter_group="group2"/>
  <ignored_collision_filter_group collision_filter_group="group3"/>
</collision_filter_group>
</robot>"""
NEWER = """<robot xmlns:drake="d">
<link name="body1"/><link name="body2"/>
<drake:collision_filter_group name="group1">
  <drake:member link="body1"/>
  <drake:member link="body2"/>
  <drake:ignored_collision_filter_group name="group2"/>
  <drake:ignored_collision_filter_group name="group3"/>
</drake:collision_filter_group>
</robot>"""


@pytest.mark.parametrize('text', [OLDER, NEWER])
def test_groups_are_read_in_both_spellings_and_belong_to_their_robot(text):
    members = (Member('left', 'body1'), Member('left', 'body2'))
    expected = GroupDescription('left::group1', members, ('left::group2', 'left::group3'))
    assert read_groups(etree.fromstring(text), 'r.urdf', 'left') == ((expected,), ())


@pytest.mark.parametrize(
    ('text', 'named'),
    [(OLDER, 'collision_filter_group="group3"'), (NEWER, 'group name="group3"')],
)
def test_the_universal_group_is_the_same_for_all_robots(text, named):
    assert named in text
    text = text.replace(named, named.replace('group3', 'universal'))
    ((group,), _) = read_groups(etree.fromstring(text), 'r.urdf', 'left')
    assert group.ignores == ('left::group2', 'universal')


@pytest.mark.parametrize(
    ('old', 'new', 'message'),
    [
        ('<member link="body2"/>', '<member link="body9"/>',
         "r.urdf:5: collision_filter_group[group1].member: link 'body9' is not in the file"),
        ('<member link="body2"/>', '<member/>', 'r.urdf:5: .* missing attribute `link`'),
        (' name="group1"', '', 'r.urdf:3: .* missing attribute `name`'),
        (' collision_filter_group="group2"', '', 'r.urdf:6: .* missing attribute `name`'),
    ],
)  # fmt: skip
def test_a_bad_group_is_refused_with_its_line(old, new, message):
    assert old in OLDER
    with pytest.raises(SceneFileError) as caught:
        read_groups(etree.fromstring(OLDER.replace(old, new)), 'r.urdf', 'left')
    start, _, end = message.partition('.*')
    assert str(caught.value).startswith(start.strip())
    assert str(caught.value).endswith(end)


def joint(parent, child, kind='revolute'):
    return SimpleNamespace(parent=parent, child=child, type=kind)


def cliques(joints, with_geometry, **options):
    made = adjacent_cliques(joints, with_geometry, 'r', RobotOptions(**options))
    return [tuple(member.frame for member in clique.members) for clique in made]


def test_two_links_of_a_moving_joint_are_a_clique():
    joints = [joint('a', 'b'), joint('b', 'c', 'prismatic'), joint('a', 'd', 'continuous')]
    assert cliques(joints, 'abcd') == [('a', 'b'), ('b', 'c'), ('a', 'd')]
    assert cliques(joints, 'acd') == [('a', 'd')]


def test_links_that_are_fixed_to_each_other_are_one_clique_through_empty_ones():
    joints = [
        joint('a', 'b', 'fixed'),
        joint('c', 'd', 'fixed'),
        joint('b', 'c', 'fixed'),
        joint('d', 'e'),
        joint('e', 'f', 'fixed'),
    ]
    assert cliques(joints, 'adef') == [('d', 'e'), ('a', 'd'), ('e', 'f')]
    assert cliques(joints, 'ae') == []


def test_a_floating_joint_connects_nothing():
    assert cliques([joint('a', 'b', 'floating'), joint('b', 'c')], 'abc') == [('b', 'c')]


def test_adjacent_links_can_be_kept():
    assert cliques([joint('a', 'b')], 'ab', filter_adjacent_links=False) == []


def test_all_self_collisions_can_be_switched_off():
    assert list(self_cliques('ab', 'r', RobotOptions())) == []
    (clique,) = self_cliques('ba', 'r', RobotOptions(filter_self_collisions=True))
    assert clique == CliqueDescription('r: all links', (Member('r', 'a'), Member('r', 'b')))


def test_links_move_where_a_joint_above_them_is_not_fixed():
    joints = [
        Joint('fixed', 'base', 'plate'),
        Joint('fixed', 'wrist', 'flange'),
        Joint('revolute', 'plate', 'arm'),
        Joint('fixed', 'arm', 'wrist'),
        Joint('continuous', 'flange', 'wrist'),  # a loop, which is no tree and ends all the same
    ]
    assert moved_links(joints) == {'arm', 'wrist', 'flange'}


def drakes(body, spelling='drake:'):
    """Return the root of a URDF of links a to d, each group written as ``name: members``."""
    links = ''.join(f'<link name="{name}"/>\n' for name in ('a', 'b', 'c', 'd', 'world'))
    return etree.fromstring(
        f'<robot xmlns:drake="d">\n{links}{body.replace("D:", spelling)}</robot>'
    )


def group(name, *elements, attributes=''):
    inside = ''.join(f'<D:{kind} {key}="{value}"/>\n' for kind, key, value in elements)
    return (
        f'<D:collision_filter_group name="{name}" {attributes}>\n{inside}'
        '</D:collision_filter_group>\n'
    )


A, B = ('member', 'link', 'a'), ('member', 'link', 'b')
ITSELF = ('ignored_collision_filter_group', 'name', 'g')


def of(name):
    return ('member_group', 'name', name)


@pytest.mark.parametrize(
    ('text', 'members'),
    [
        (group('h', A, B) + group('g', of('h'), ITSELF), 'ab'),
        (group('g', of('h'), ITSELF) + group('h', A, B), 'ab'),
        (group('g', of('h'), ITSELF) + group('h', of('k')) + group('k', A, B), 'ab'),
        (group('g', of('h'), ITSELF) + group('h', of('g'), A, B), 'ab'),
        (group('g', A, of('h'), ITSELF) + group('h', A, B), 'ab'),
    ],
)
@pytest.mark.parametrize('spelling', ['drake:', ''])
def test_a_group_has_the_members_of_its_member_groups(text, members, spelling):
    """The same as pydrake 1.51 makes of these texts: see test_urdf_like_pydrake."""
    groups, warnings = read_groups(drakes(text, spelling), 'r.urdf', 'left')
    found = {group.name: group.members for group in groups}
    assert found['left::g'] == tuple(Member('left', link) for link in members)
    assert warnings == ()


@pytest.mark.parametrize(
    ('value', 'count', 'told'),
    [
        ('true', 0, ()),
        ('false', 1, ()),
        ('TRUE', 1, ("r.urdf:7: collision_filter_group[g]: ignore = 'TRUE' is not `true`: the "
                     'group counts, as in Drake',)),
    ],
)  # fmt: skip
def test_a_group_that_says_so_is_none(value, count, told):
    text = group('g', A, B, ITSELF, attributes=f'ignore="{value}"')
    groups, warnings = read_groups(drakes(text), 'r.urdf', 'left')
    assert (len(groups), warnings) == (count, told)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (group('g', of('h')), "r.urdf:8: .*member_group.h.: group 'h' is not in the file"),
        (group('g', of('h')) + group('h', A, attributes='ignore="true"'), "group 'h' is not in"),
        (group('g', A) + group('g', B), "r.urdf:10: .*: group 'g' is there twice, see line 7"),
        (group('g', ('member', 'link', 'world')), "r.urdf:8: .*: link 'world' is not in the file"),
    ],
)
def test_what_pydrake_refuses_of_groups_is_refused(text, message):
    with pytest.raises(SceneFileError, match=message):
        read_groups(drakes(text), 'r.urdf', 'left')


def test_an_element_of_a_group_that_is_not_known_is_told():
    _, warnings = read_groups(drakes(group('g', A, ('membr', 'link', 'b'))), 'r.urdf', 'left')
    place = 'r.urdf:9: collision_filter_group[g].membr'
    assert warnings == (f'{place}: <membr> is not understood; it is left out',)


JOINT = '<drake:joint name="j" type="{}"><parent link="{}"/><child link="{}"/></drake:joint>'


@pytest.mark.parametrize('kind', ['ball', 'planar', 'universal', 'curvilinear'])
def test_drakes_joints_connect_links(kind):
    root, links = drakes(JOINT.format(kind, 'a', 'b')), dict.fromkeys('ab')
    driven = read_joints(root, links, 'r.urdf')
    joints = [*driven, *undriven_joints(root, links, 'r.urdf')]
    assert [(j.type, j.parent, j.child) for j in joints] == [(kind, 'a', 'b')]
    assert len(driven) == (kind != 'curvilinear')
    assert cliques(joints, 'ab') == [('a', 'b')]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (JOINT.format('fixed', 'a', 'b'), "r.urdf:7: joint.j.: type 'fixed' is none of <drake:"),
        (JOINT.format('ball', 'a', 'x'), "r.urdf:7: joint.j..child: link 'x' is not in the file"),
        (
            JOINT.format('curvilinear', 'a', 'x'),
            "r.urdf:7: joint.j..child: link 'x' is not in the file",
        ),
        ('<drake:joint name="j" type="ball"><child link="b"/></drake:joint>', 'missing <parent'),
    ],
)
def test_a_bad_joint_of_drakes_is_refused(text, message):
    root, links = drakes(text), dict.fromkeys('ab')
    read = undriven_joints if 'curvilinear' in text else read_joints
    with pytest.raises(SceneFileError, match=message):
        read(root, links, 'r.urdf')
