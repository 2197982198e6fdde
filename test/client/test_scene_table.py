"""Names and frames of a scene, from its message."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest
from ros.demo import demo_scenes as scenes
from ros.demo.demo_scenes import SCENE

from drake_geom_ros.client.scene_table import Geometry, SceneTable, UnknownNameError


def test_names():
    table = scenes.table()
    assert table[1].full_name == 'left::hand/ball'
    assert table[1].body == 'left::hand'
    assert table[5].full_name == 'room::world/table'
    assert table[5].body == 'room::table'
    assert table.pair_name(1, 5) == 'left::hand - room::table'


def test_a_message_gives_names_shapes_poses_and_parents():
    table = SceneTable.from_message(SCENE)
    assert table.version == 7
    assert table[5].full_name == 'room::world/table'
    assert table[5].anchored
    assert (table[6].full_name, table[6].frame) == ('arm::tip/ball', 'arm::tip')
    assert (table[6].shape_type, table[6].dimensions) == (1, (0.1,))
    np.testing.assert_allclose(table[6].X_FG[:3, 3], [0, 0, 0.2])
    assert list(table.parents.items()) == [
        (('arm', 'hand'), None),
        (('arm', 'tip'), ('arm', 'hand')),
    ]


def test_pairs_between_two_sources_in_either_order():
    id_a, id_b = np.array([1, 3, 1, 1, 3]), np.array([3, 2, 2, 5, 4])
    mask = scenes.table().between(id_a, id_b, ('right', 'left'))
    assert mask.tolist() == [True, True, False, False, False]


@pytest.mark.parametrize(
    ('pattern', 'ids'),
    [
        ('left', [1, 2]),
        ('left::hand', [1]),
        ('hand', [1, 3]),
        ('hand/ball', [1, 3]),
        ('right::hand/ball', [3]),
        ('*::hand/*', [1, 3]),
        ('ball', [1, 3]),
        ('room', [5, 6, 7]),
        ('room::table', [5]),
        ('world/table', [5]),
        ('*', [1, 2, 3, 4, 5, 6, 7]),
    ],
)
def test_what_a_name_or_a_pattern_stands_for(pattern, ids):
    assert scenes.table().ids(pattern).tolist() == ids


def ball(id, source, frame, name='ball', **more):
    """Return a ball; on the world where the frame is empty."""
    line = (f'{source}::{frame}',) if frame else ()
    return Geometry(id, source, frame or 'world', name, 1, (0.1,), np.eye(4), line, **more)


def test_names_may_hold_what_joins_names():
    """As SDFormat nests models: ``arm::base`` is a frame's own name."""
    table = SceneTable(
        [
            ball(1, 'cell', 'arm::base'),
            ball(2, 'cell', 'leg::base'),
            ball(3, 'lab::arm', 'base'),
            ball(4, 'arm', 'base', 'left/tip'),
            ball(5, 'arm', 'finger[0]'),
        ]
    )
    for name, ids in {
        'leg::base': [2],
        'cell::arm::base': [1],
        'arm::base': [1, 4],  # whatever bears the name, as with one of two sources' frames
        'lab::arm': [3],
        'lab::arm::base/ball': [3],
        'arm::base/ball': [1],
        'arm::base/left/tip': [4],
        'left/tip': [4],
        'finger[0]': [5],
        'cell::*::base': [1, 2],
    }.items():
        assert table.ids(name).tolist() == ids
    assert [table[i].frame for i in (1, 3)] == ['cell::arm::base', 'lab::arm::base']
    assert table[1].short_name == 'arm::base/ball'
    assert table[3].full_name == 'lab::arm::base/ball'


def test_the_own_name_of_a_frame_is_looked_up_whole():
    frames = ('a', 'b::c'), ('a::b', 'c'), ('cell', 'part'), ('other', 'part'), ('a::b', 'tool/0')
    table = SceneTable([], parents=dict.fromkeys(frames))
    for text, own in (
        *(('cell::part', 'part'), ('part', 'part'), ('a::b::tool/0', 'tool/0'), ('b::c', 'b::c')),
    ):
        assert table.own_name(text) == own
    with pytest.raises(UnknownNameError, match=r"'a::b::c' stands for 'b::c' of"):
        table.own_name('a::b::c')
    with pytest.raises(UnknownNameError, match=r"no frame 'cell::prt'.*nearest: 'cell::part'"):
        table.own_name('cell::prt')


def test_what_queries_never_report_is_not_found():
    seen = ball(9, 'room', '', 'picture', has_proximity=False)
    table = SceneTable([*scenes.table().geometries.values(), seen], version=4)
    told = r"'picture' stands for .*; of that name 1 geometry without the proximity role"
    for _ in range(2):  # the second one is remembered
        with pytest.raises(UnknownNameError, match=told):
            table.ids('picture')
    assert table.ids('room').tolist() == [5, 6, 7, 9]
    with pytest.raises(UnknownNameError, match=r"'n{80}' stands for no geometry"):
        table.ids('n' * 10**6)
    with pytest.raises(UnknownNameError, match=r'version 4; nearest: .left::hand.'):
        table.ids('left::hant')
    with pytest.raises(UnknownNameError, match=r"no source 'rigth' .*; nearest: 'right'"):
        table.between(np.array([1]), np.array([3]), ('left', 'rigth'))
    with pytest.raises(UnknownNameError, match='It holds 0 geometries of no source'):
        SceneTable([]).ids('*')


def test_what_hangs_on_a_frame_waits_with_it():
    table = SceneTable.from_message(SCENE)
    assert table[6].line == ('arm::tip', 'arm::hand')
    everything = table.ids('*')
    assert table.waits([everything], ['arm::hand'])
    assert table.waits([table.ids('tip')], ['arm::hand'])
    assert not table.waits([table.ids('ring')], ['arm::tip'])
    assert not table.waits([everything], [])


@pytest.mark.parametrize('is_part', [True, False])
def test_what_a_robot_carries_is_found_by_the_names_of_the_robot(is_part):
    message = copy.deepcopy(SCENE)
    tip = next(frame for frame in message.frames if frame.name == 'tip')
    part = copy.deepcopy(tip)
    part.id, part.name, part.source_id, part.parent_id = 90, 'part', 91, tip.id
    part.part_of_robot = is_part
    box = copy.deepcopy(next(g for g in message.geometries if g.frame_id == tip.id))
    box.id, box.name, box.source_id, box.frame_id = 92, 'box', 91, 90
    message.frames.append(part)
    message.geometries.append(box)
    message.sources.append(SimpleNamespace(id=91, name='parts'))
    table = SceneTable.from_message(message)
    carried, before = [92] if is_part else [], SceneTable.from_message(SCENE)
    for name in ('arm', 'arm::tip'):
        assert table.ids(name).tolist() == [*before.ids(name).tolist(), *carried]
    assert table.ids('parts').tolist() == [92]
    assert table[92].full_name == 'parts::part/box'
