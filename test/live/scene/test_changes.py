"""Attached frames, removed and replaced sources of a live scene, without ROS."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Clock, live_scene

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.attachment import detachment
from drake_geom_ros.live.services import files, queries, scene, shapes
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene, to_yaml

ANSWER = Guard(logger=None, count=None).answer
CELL = """
sources: [arm, parts]
frames:
- {name: part, source: parts}
- {name: hand, source: arm, pose: {position: [0, 0, 1]}}
geometries:
- {name: ball, source: parts, frame: part, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: table, source: parts, shape: {type: box, size: [1, 1, 0.1]}}
cameras:
- {name: wrist, frame: 'arm::hand', size: [8, 8]}
"""


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def live(clock):
    return live_scene(CELL, clock)


def poses(names, xs, stamp=0):
    return Plain(
        header=Plain(stamp=Plain(sec=stamp, nanosec=0), frame_id=''),
        source='',
        frame_names=names,
        frame_ids=[],
        poses=[value for x in xs for value in (x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)],
    )


def pose(x=0.0):
    position, orientation = Plain(x=x, y=0.0, z=0.0), Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    return Plain(position=position, orientation=orientation)


def call(live, service, response=None, **fields):
    """Call a service that takes the live scene."""
    response = response or Plain(pose=pose())
    return ANSWER(service, live, Plain(**fields), response)


def attach(live, **fields):
    given = {'frame': 'part', 'parent': 'hand', 'pose_given': False, 'pose': pose()}
    given |= {'part_of_robot': True, 'touch_links': []}
    return call(live, scene.attach, **{**given, **fields})


def detach(live, **fields):
    return call(live, scene.detach, **{'frame': 'part', 'pose_given': False, **fields})


def take(live, names, xs, stamp=0):
    with live.editing() as held:
        return held.poses.take(poses(names, xs, stamp))


def x_of(live, name):
    with live.reading() as held:
        return held.query.X_WF(held.model.names.frame(name)).translation()[0]


def pose_ages(live, *names):
    empty = {'names': [], 'ids': [], 'ages': [], 'waiting': [], 'attached_to': []}
    answer = call(live, queries.get_pose_ages, Plain(**empty), frames=list(names))
    assert answer.success, answer.message
    return dict(zip(answer.names, answer.ages, strict=True)), answer


def test_an_attached_part_follows_the_hand_from_where_it_is(live):
    take(live, ['part', 'hand'], [3.0, 1.0])
    answer = attach(live)
    assert answer.success, answer.message
    assert answer.pose.position.x == 2.0
    take(live, ['hand'], [5.0])
    assert x_of(live, 'part') == 7.0
    answer = detach(live)
    assert answer.pose.position.x == 7.0
    take(live, ['hand'], [0.0])
    assert x_of(live, 'part') == 7.0
    take(live, ['part'], [4.0])
    assert x_of(live, 'part') == 4.0


def test_a_part_without_a_pose_needs_one(live):
    answer = attach(live)
    assert not answer.success
    assert 'parts::part has no pose yet' in answer.message
    assert attach(live, pose_given=True, pose=pose(0.5)).success
    take(live, ['hand'], [1.0])
    assert x_of(live, 'part') == 1.5


def test_a_stream_that_goes_on_is_left_out_and_told(live, clock):
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    assert take(live, ['part', 'hand'], [9.0, 2.0]) == 2
    assert x_of(live, 'part') == 4.0
    with live.reading() as held:
        (told,) = held.troubles()
        assert 'parts::part' in told
        assert 'left out' in told
        clock.now += 60.0
        assert held.troubles() == []


def test_what_if_poses_are_those_in_the_parent_of_now(live):
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    view = live.view(poses(['part'], [0.25]))
    assert view.query.X_WF(view.names.frame('part')).translation()[0] == 1.25


def test_ages_while_attached_and_after(live, clock):
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    clock.now += 7.0
    found, answer = pose_ages(live)
    assert found == {'arm::hand': 7.0, 'parts::part': 0.0}
    assert list(found) == answer.names == ['arm::hand', 'parts::part']
    assert answer.attached_to == [0, answer.ids[0]]
    with live.reading() as held:
        assert held.moment().oldest == (7.0, answer.ids[0])
    detach(live)
    # Where it is was known by a pose of the hand of 7 s ago.
    assert pose_ages(live)[0] == {'arm::hand': 7.0, 'parts::part': 7.0}
    take(live, ['part'], [1.0])
    assert pose_ages(live)[0] == {'arm::hand': 7.0, 'parts::part': 0.0}
    assert pose_ages(live, 'part')[0] == {'parts::part': 0.0}


def test_a_frame_that_waits_is_the_oldest(live):
    found, answer = pose_ages(live)
    assert found == {'parts::part': float('inf'), 'arm::hand': 0.0}
    assert answer.waiting == [True, False]
    with live.reading() as held:
        assert held.moment().oldest == (float('inf'), answer.ids[0])


def test_a_saved_scene_has_the_attachment(live):
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    with live.reading() as held:
        text = to_yaml(held.description())
    (part,) = [f for f in read_scene(text).frames if f.name == 'part']
    assert (part.attached_to.source, part.attached_to.frame) == ('arm', 'hand')
    assert part.X_PF.translation()[0] == 2.0
    again = live_scene(text)
    take(again, ['hand'], [5.0])
    assert x_of(again, 'part') == 7.0
    assert detach(again).success
    with again.reading() as held:
        (part,) = [f for f in held.description().frames if f.name == 'part']
    assert part.attached_to is None
    assert part.X_PF.translation()[0] == 7.0


def test_a_removed_source_is_forgotten(live):
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    refused = call(live, scene.remove_source, source='arm')
    assert not refused.success
    assert 'detach it first' in refused.message
    detach(live)
    answer = call(live, scene.remove_source, Plain(), source='arm')
    assert (answer.frames, answer.geometries) == (1, 1)
    with live.reading() as held:
        assert held.cameras.by_name() == {}
        assert held.poses.ages_by_name().keys() == {'parts::part'}
        assert held.moment().oldest.age < 60.0
    with live.editing() as held:
        held.make(addition(read_scene('frames:\n- {name: hand, source: arm}')))
    assert pose_ages(live)[0]['arm::hand'] == float('inf')


NEW_ARM = """
sources: [arm]
frames: [{name: hand, source: arm}, {name: tip, source: arm, parent: hand, pose: {}}]
geometries:
- {name: cube, source: arm, frame: hand, shape: {type: box, size: [1, 1, 1]}}
"""


def load(live, text, *sources, replace=False):
    fields = {'path': '', 'srdf': '', 'format': '', 'replace': replace}
    return call(live, files.load_scene, text=text, replaced_sources=list(sources), **fields)


def test_a_replaced_source_keeps_the_poses_of_its_frames(live, clock):
    take(live, ['part', 'hand'], [3.0, 1.0])
    clock.now += 2.0
    answer = load(live, NEW_ARM, 'arm')
    assert answer.success, answer.message
    assert (answer.frames, answer.geometries) == (2, 1)
    assert x_of(live, 'hand') == x_of(live, 'tip') == 1.0
    assert pose_ages(live)[0] == {'arm::hand': 2.0, 'arm::tip': 0.0, 'parts::part': 2.0}
    with live.reading() as held:
        assert 'arm::hand/cube' in held.model.names.geometry_names.values()
        assert 'arm::hand/ball' not in held.model.names.geometry_names.values()


@pytest.mark.parametrize(
    ('text', 'sources', 'word'),
    [
        (NEW_ARM, ['leg'], 'no source'),
        (NEW_ARM, [], 'taken'),
        (NEW_ARM.replace('sources: [arm]', 'sources: [arm, parts]'), ['arm'], 'taken'),
        (NEW_ARM.replace('size: [1, 1, 1]', 'size: [1, 1, -1]'), ['arm'], '-1'),
    ],
)
def test_a_refused_replacement_changes_nothing(live, text, sources, word):
    with live.reading() as held:
        version = held.model.version
    answer = load(live, text, *sources)
    assert not answer.success
    assert word in answer.message
    with live.reading() as held:
        assert held.model.version == version
        assert held.cameras.by_name().keys() == {'wrist'}


def geometry(name, radius=0.1, frame='part'):
    shape = Plain(type=1, dimensions=[radius], vertices=[], triangles=[], mesh_uri='')
    roles = [Plain(role=1, properties=[])]
    return Plain(frame=frame, parent_geometry='', name=name, pose=pose(), shape=shape, roles=roles)


def register(live, *geometries):
    response = Plain(geometry_ids=[])
    return call(
        live, shapes.register_geometries, response, source='parts', geometries=list(geometries)
    )


def test_several_geometries_come_at_once(live):
    answer = register(live, *(geometry(f'g{k}') for k in range(5)))
    assert answer.success, answer.message
    with live.reading() as held:
        names = [
            held.model.names.geometry_names[held.model.names.geometry_of_value(i)]
            for i in answer.geometry_ids
        ]
    assert names == [f'parts::part/g{k}' for k in range(5)]


@pytest.mark.parametrize(
    'last', [geometry('g0'), geometry('g2', -1.0), geometry('g2', frame='hand')]
)
def test_of_several_geometries_none_comes_where_one_is_refused(live, last):
    answer = register(live, geometry('g0'), geometry('g1'), last)
    assert not answer.success
    assert answer.message.startswith('geometries[2]: ')
    with live.reading() as held:
        assert held.model.inspector.num_geometries() == 3


def test_tf_leaves_an_attached_frame_alone(live):
    from live.inputs.tf_messages import at, message, transform

    from drake_geom_ros.live.inputs.tf_input import TfInput

    tf = TfInput(live.clocks)
    take(live, ['part', 'hand'], [3.0, 1.0])
    attach(live)
    tf.hear(message(transform('world', 'part', at(9.0), stamp=5.0)), static=False)
    with live.editing() as held:
        tf.pose(held)
        assert x_of(live, 'part') == 3.0
        assert 'left out' in held.troubles()[0]
        held.make(detachment(held, held.model.names.frame('part'), RigidTransform([1.0, 0, 0])))
        tf.pose(held)
        assert x_of(live, 'part') == 1.0
    tf.hear(message(transform('world', 'part', at(9.0), stamp=6.0)), static=False)
    with live.editing() as held:
        tf.pose(held)
    assert x_of(live, 'part') == 9.0
