from types import SimpleNamespace

import pytest
from lxml import etree

from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    GroupDescription,
    Member,
    Operation,
    RobotOptions,
    Statement,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.urdf_filters import (
    Joint,
    adjacent_cliques,
    moved_links,
    read_groups,
    read_srdf,
    self_cliques,
)

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
    assert read_groups(etree.fromstring(text), 'r.urdf', 'left') == (expected,)


@pytest.mark.parametrize(
    ('text', 'named'),
    [(OLDER, 'collision_filter_group="group3"'), (NEWER, 'group name="group3"')],
)
def test_the_universal_group_is_the_same_for_all_robots(text, named):
    assert named in text
    text = text.replace(named, named.replace('group3', 'universal'))
    (group,) = read_groups(etree.fromstring(text), 'r.urdf', 'left')
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


def test_adjacent_links_can_be_kept():
    assert cliques([joint('a', 'b')], 'ab', filter_adjacent_links=False) == []


def test_all_self_collisions_can_be_switched_off():
    assert list(self_cliques('ab', 'r', RobotOptions())) == []
    (clique,) = self_cliques('ba', 'r', RobotOptions(filter_self_collisions=True))
    assert clique == CliqueDescription('r: all links', (Member('r', 'a'), Member('r', 'b')))


SRDF = b"""<robot name="arm">
<group name="g"><link name="x"/></group>
<disable_collisions link1="a" link2="b" reason="Adjacent"/>
<disable_collisions link1="b" link2="c"/>
</robot>"""


def test_an_srdf_is_one_declaration():
    declaration = read_srdf(SRDF, 'r.srdf', 'left', 'abc')
    a, b, c = ((Member('left', link),) for link in 'abc')
    assert declaration.statements == (
        Statement(Operation.EXCLUDE_BETWEEN, a, b),
        Statement(Operation.EXCLUDE_BETWEEN, b, c),
    )
    kept = read_srdf(SRDF, 'r.srdf', 'left', 'abc', filter_adjacent_links=False)
    assert kept.statements == declaration.statements[1:]


@pytest.mark.parametrize(
    ('data', 'message'),
    [
        (SRDF.replace(b'link2="c"', b'link2="d"'),
         "r.srdf:4: disable_collisions: link 'd' is not in the robot 'left'"),
        (SRDF.replace(b'link2="c"', b''), 'r.srdf:4: disable_collisions: missing attribute'),
        (b'<robot>', 'r.srdf:1: not XML'),
    ],
)  # fmt: skip
def test_a_bad_srdf_is_refused_with_its_line(data, message):
    with pytest.raises(SceneFileError) as caught:
        read_srdf(data, 'r.srdf', 'left', 'abc')
    assert str(caught.value).startswith(message)


def test_links_move_where_a_joint_above_them_is_not_fixed():
    joints = [
        Joint('fixed', 'base', 'plate'),
        Joint('fixed', 'wrist', 'flange'),
        Joint('revolute', 'plate', 'arm'),
        Joint('fixed', 'arm', 'wrist'),
        Joint('continuous', 'flange', 'wrist'),  # a loop, which is no tree and ends all the same
    ]
    assert moved_links(joints) == {'arm', 'wrist', 'flange'}
