"""MoveIt's objects in a live scene, without ROS: what they do, whole messages or nothing."""

from itertools import combinations
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from live.live_scenes import Clock, live_scene
from live.moveit_messages import (
    ADD,
    APPEND,
    MOVE,
    REMOVE,
    attached_object,
    ball,
    collision_object,
    mesh,
    plane,
    pose,
    primitive,
)

from drake_geom_ros.geometry import GeometryId
from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.live.services import scene
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene, to_yaml

ARM = """
sources: [arm]
frames:
- {name: base, source: arm, pose: {position: [0, 0, 5]}}
- {name: hand, source: arm, pose: {position: [0, 0, 1]}}
- {name: finger, source: arm, pose: {position: [0, 0, 1.1]}}
geometries:
- {name: base, source: arm, frame: base, shape: {type: sphere, radius: 0.1}}
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: finger, source: arm, frame: finger, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def live():
    return live_scene(ARM, Clock())


@pytest.fixture
def moveit(live):
    return PlanningSceneInput(live)


def place(live, name):
    """Return where a frame is in the world."""
    with live.reading() as held:
        return held.query.X_WF(held.model.names.frame(name)).translation().tolist()


def put(live, name, x=0.0, y=0.0, z=0.0):
    with live.editing() as held:
        held.poses.put({tuple(name.split('::')): RigidTransform([x, y, z])})


def pairs(live):
    """Return the pairs that queries report, by names without sources."""
    with live.reading() as held:
        names, ids = held.model.names, held.model.inspector.candidate_pairs().ids.tolist()
        short = {i: names.geometry_names[GeometryId(i)].rpartition('::')[2] for i in ids}
        return {
            frozenset([short[a], short[b]])
            for a, b in combinations(ids, 2)
            if not held.model.inspector.CollisionFiltered(GeometryId(a), GeometryId(b))
        }


def state(live):
    """Return all that a message may change: names, poses, shapes, pairs, welds, filters."""
    with live.reading() as held:
        names = held.model.names
        poses = {n: held.query.X_WF(f).ToArray().tolist() for f, n in names.frame_names.items()}
        welded = {names.frame_names[f] for f in held.model.filter_manager.welded_frames()}
        owners = sorted(held.filters.owners().values())
        shapes = {
            n: repr(held.model.inspector.GetShape(g)) for g, n in names.geometry_names.items()
        }
    return poses, shapes, welded, owners, pairs(live)


def box(name, x=0.0, **fields):
    given = {'primitives': [ball()], 'primitive_poses': [pose()], 'at': pose(x)}
    return collision_object(name, **{**given, **fields})


def test_an_object_is_a_frame_with_its_shapes_where_the_header_says(live, moveit):
    put(live, 'arm::hand', 1.0, 2.0, 3.0)
    done = moveit.take_object(
        collision_object(
            'shelf', frame='hand', at=pose(10.0),
            primitives=[ball(), ball()], primitive_poses=[pose(0.0, 100.0)],
            planes=[plane(0, 0, 1, 0)], plane_poses=[pose(0.0, 0.0, -50.0)],
            subframe_names=['door'], subframe_poses=[pose(0.0, 0.0, 7.0)],
        )
    )  # fmt: skip
    assert 'plane' in done
    assert place(live, 'shelf') == [11.0, 2.0, 3.0]
    assert place(live, 'shelf/door') == [11.0, 2.0, 10.0]
    with live.reading() as held:
        at = {
            n: held.query.X_WG(g).translation().tolist()
            for g, n in held.model.names.geometry_names.items()
            if 'shelf' in n
        }
    assert at == {
        'planning_scene::shelf/sphere_0': [11.0, 102.0, 3.0],
        'planning_scene::shelf/sphere_1': [11.0, 2.0, 3.0],
        'planning_scene::shelf/plane_2': [11.0, 2.0, -47.0],
    }
    put(live, 'arm::hand', 0.0)
    assert place(live, 'shelf') == [11.0, 2.0, 3.0], 'it stays where it was put'


def test_the_pose_of_a_lone_shape_is_that_of_the_object(live, moveit):
    moveit.take_object(box('a', primitive_poses=[pose(3.0)], at=pose()))
    assert place(live, 'a') == [3.0, 0.0, 0.0]
    moveit.take_object(box('b', primitive_poses=[pose(3.0)], at=pose(1.0)))
    assert place(live, 'b') == [1.0, 0.0, 0.0]


def test_world_objects_stand_and_pairs_of_them_are_not_reported(live, moveit):
    moveit.take_object(box('a'))
    moveit.take_object(box('b', 1.0))
    links = {'base/base', 'hand/hand', 'finger/finger'}
    expected = {frozenset([link, f'{o}/sphere_0']) for link in links for o in 'ab'}
    between = {frozenset(both) for both in combinations(links, 2)}
    assert pairs(live) == expected | between
    moveit.take_object(collision_object('a', MOVE, at=pose(9.0)))
    assert pairs(live) == expected | between
    with live.reading() as held:
        assert held.poses.ages_by_name()['planning_scene::a'] == 0.0


def test_add_replaces_append_adds_and_move_moves(live, moveit):
    moveit.take_object(box('a', subframe_names=['tip'], subframe_poses=[pose(0.0, 1.0)]))
    moveit.take_object(box('a', 5.0, operation=APPEND))
    with live.reading() as held:
        names = set(held.model.names.geometry_names.values())
    assert {'planning_scene::a/sphere_0', 'planning_scene::a/sphere_1'} <= names
    assert place(live, 'a') == [0.0, 0.0, 0.0]
    moveit.take_object(collision_object('a', MOVE, 'hand', at=pose(2.0)))
    assert place(live, 'a') == [2.0, 0.0, 1.0]
    assert place(live, 'a/tip') == [2.0, 1.0, 1.0]
    moveit.take_object(box('a', 4.0))
    with live.reading() as held:
        names = [n for n in held.model.names.geometry_names.values() if '::a/' in n]
    assert names == ['planning_scene::a/sphere_0']
    assert place(live, 'a') == [4.0, 0.0, 0.0]


def test_a_move_may_place_the_shapes_too(live, moveit):
    moveit.take_object(box('a', primitives=[ball(), ball()], primitive_poses=[pose(), pose(1.0)]))
    poses = [pose(0.0, 3.0), pose(1.0)]
    moveit.take_object(collision_object('a', MOVE, at=pose(2.0), primitive_poses=poses))
    with live.reading() as held:
        at = [
            held.query.X_WG(held.model.names.geometry(f'a/sphere_{k}')).translation().tolist()
            for k in range(2)
        ]
    assert at == [[2.0, 3.0, 0.0], [3.0, 0.0, 0.0]]


def test_remove_takes_one_or_all_and_leaves_attached_ones(live, moveit):
    before = state(live)
    for name in 'abc':
        moveit.take_object(box(name))
    moveit.take_object(collision_object('a', REMOVE, frame=''))
    moveit.take_attached(attached_object('hand', collision_object('b')))
    assert '1 in' not in moveit.take_object(collision_object('', REMOVE))
    assert not any('/sphere' in n and n[0] in 'ac' for pair in pairs(live) for n in pair)
    assert frozenset(['base/base', 'b/sphere_0']) in pairs(live)
    moveit.take_attached(attached_object('', collision_object('', REMOVE)))
    moveit.take_object(collision_object('', REMOVE))
    assert state(live) == before


def test_an_object_in_the_frame_of_another_one(live, moveit):
    moveit.take_object(box('a', 1.0, subframe_names=['tip'], subframe_poses=[pose(0.0, 1.0)]))
    moveit.take_object(box('b', 1.0, frame='/a/tip'))
    assert place(live, 'b') == [2.0, 1.0, 0.0]


# Attached objects.


def test_an_attached_object_follows_its_link_and_touches_what_it_may(live, moveit):
    moveit.take_object(box('a', 1.0))
    moveit.take_attached(attached_object('hand', collision_object('a'), ['finger']))
    assert frozenset(['base/base', 'a/sphere_0']) in pairs(live)
    assert not {frozenset([f'{k}/{k}', 'a/sphere_0']) for k in ('hand', 'finger')} & pairs(live)
    put(live, 'arm::hand', 0.0, 7.0, 1.0)
    assert place(live, 'a') == [1.0, 7.0, 0.0]
    moveit.take_attached(attached_object('hand', collision_object('a', REMOVE)))
    put(live, 'arm::hand', 0.0)
    assert place(live, 'a') == [1.0, 7.0, 0.0]
    assert {frozenset([f'{k}/{k}', 'a/sphere_0']) for k in ('hand', 'finger')} <= pairs(live)


def test_attached_objects_of_one_link_do_not_collide_with_each_other(live, moveit):
    for name, link in (('a', 'hand'), ('b', 'hand'), ('c', 'base')):
        moveit.take_attached(attached_object(link, box(name)))
    assert frozenset(['a/sphere_0', 'b/sphere_0']) not in pairs(live)
    assert frozenset(['a/sphere_0', 'c/sphere_0']) in pairs(live)


@pytest.mark.parametrize('service', ['attach', 'detach'])
def test_the_services_leave_objects_to_the_messages(live, moveit, service):
    moveit.take_attached(attached_object('hand', box('a')))
    request = Plain(frame='a', parent='base', pose_given=False, touch_links=[], part_of_robot=True)
    before = state(live)
    with pytest.raises(RuntimeError, match='is an object of the planning scene'):
        getattr(scene, service)(live, request, Plain(pose=pose()))
    assert state(live) == before


def test_append_adds_to_an_attached_object_and_keeps_what_it_may_touch(live, moveit):
    moveit.take_attached(attached_object('hand', box('a', 1.0), ['finger']))
    moveit.take_attached(attached_object('hand', box('a', 0.0, operation=APPEND, at=pose())))
    assert place(live, 'a') == [1.0, 0.0, 0.0]
    assert frozenset(['finger/finger', 'a/sphere_1']) not in pairs(live)
    assert frozenset(['base/base', 'a/sphere_1']) in pairs(live)


def test_the_usual_way_to_grasp_and_to_release(live, moveit):
    moveit.take_object(box('a', 1.0))
    moveit.take_attached(attached_object('hand', box('a', 2.0, frame='hand')))
    done = moveit.take_object(collision_object('a', REMOVE))
    assert 'REMOVE does nothing, for the world has no such object; one of this id' in done
    assert place(live, 'a') == [2.0, 0.0, 1.0]
    moveit.take_attached(attached_object('hand', collision_object('a', REMOVE)))
    moveit.take_object(box('a', 3.0))
    assert place(live, 'a') == [3.0, 0.0, 0.0]


def test_what_nobody_reads_is_reported(live, moveit):
    message = box('a', meshes=[], primitive_poses=[pose(q=(0.0, 0.0, 0.0, 0.0))])
    message.type.key = 'mug'
    done = moveit.take_attached(attached_object('hand', message, ['nobody'], weight=0.3))
    for note in ('type', "'nobody' stands for no frame", 'weight of 0.3 kg', 'quaternion'):
        assert note in done
    done = moveit.take_object(box('b', operation=REMOVE))
    assert "object 'b': REMOVE does nothing" in done
    moveit.take_object(box('b'))
    assert 'its primitives are ignored' in moveit.take_object(box('b', 1.0, operation=MOVE))


# Refusals.


def refusals():
    """Return messages that are refused, and what is said of them."""
    nan = float('nan')
    lone = collision_object
    return [
        (box('<octomap>'), 'MoveIt reserves this id'),
        (box(''), 'has an empty id'),
        (box(' a'), 'no space or tab'),
        (box('world'), "object 'world': this is the name of the world frame"),
        (box('a', operation=7), "object 'a': operation is 7; it must be one of 0 (ADD)"),
        (box('a', frame=''), "object 'a': header.frame_id is empty"),
        (box('a', frame='hnd'), "object 'a': There is no frame 'hnd'"),
        (box('a', at=pose(nan)), "object 'a': pose"),
        (box('a', at=pose(q=(0.0, 0.0, 0.5, 0.5))), "object 'a': pose"),
        (box('a', at=pose(1e305)), 'a'),
        (lone('a'), "object 'a': it has no shape"),
        (box('a', primitives=[ball(-1.0)]), "object 'a': primitives[0]: "),
        (box('a', meshes=[mesh([], [])]), "object 'a': meshes[0]: it holds 0 vertices"),
        (box('a', planes=[plane(0, 0, 0, 1)]), "object 'a': planes[0]: coef is"),
        (box('a', plane_poses=[pose()]), 'plane_poses holds 1 poses for 0 planes'),
        (box('a', subframe_names=['x']), 'subframe_poses holds 0 poses for 1'),
        (box('there', subframe_names=['x', 'x'], subframe_poses=[pose()] * 2), 'subframe_names'),
        (box('there', operation=MOVE, primitive_poses=[pose()] * 3), 'the object has 1'),
        (lone('nowhere', MOVE), "object 'nowhere': the world has no such object to MOVE"),
        (box('held'), "object 'held': it is attached to 'arm::hand'; detach it first"),
        (lone('held', MOVE), "object 'held': it is attached"),
        (box('there/tip'), 'there/tip'),
    ]


def attached_refusals():
    """Return messages of attached objects that are refused, and what is said of them."""
    return [
        (attached_object('hnd', box('a')), "object 'a': There is no frame 'hnd'"),
        (attached_object('world', box('a')), "object 'a': link_name is 'world'"),
        (attached_object('there', box('a')), "object 'a': link_name is 'there'"),
        (attached_object('hand', collision_object('a')), 'no such object to attach'),
        (attached_object('hand', collision_object('a', MOVE)), 'MOVE does not go with'),
        (
            attached_object('base', collision_object('held', REMOVE)),
            "it is attached to 'arm::hand', not to 'base'",
        ),
        (attached_object('hand', box('a', primitives=[primitive(9)])), 'primitives[0]'),
    ]


@pytest.fixture
def full(live, moveit):
    """Return a scene with one object in the world and one that is held."""
    tip = {'subframe_names': ['tip'], 'subframe_poses': [pose()]}
    moveit.take_object(box('there', 1.0, **tip))
    moveit.take_attached(attached_object('hand', box('held'), ['finger']))
    return live


@pytest.mark.parametrize(('message', 'reason'), refusals())
def test_a_refusal_names_object_and_reason_and_changes_nothing(full, moveit, message, reason):
    before = state(full)
    with pytest.raises(RuntimeError) as refused:
        moveit.take_object(message)
    assert reason in str(refused.value)
    assert state(full) == before


@pytest.mark.parametrize(('message', 'reason'), attached_refusals())
def test_a_refused_attachment_changes_nothing(full, moveit, message, reason):
    before = state(full)
    with pytest.raises(RuntimeError) as refused:
        moveit.take_attached(message)
    assert reason in str(refused.value)
    assert state(full) == before


def test_a_name_of_an_object_and_of_a_link_is_refused_as_a_frame(live, moveit):
    moveit.take_object(box('hand'))
    with pytest.raises(RuntimeError, match='is the name of an object and of another frame'):
        moveit.take_object(box('a', frame='hand'))


def test_a_link_without_a_pose_is_refused(moveit):
    lost = live_scene(ARM.replace('pose: {position: [0, 0, 5]}', ''), Clock())
    with pytest.raises(RuntimeError, match='arm::base has no pose yet'):
        PlanningSceneInput(lost).take_object(box('a', frame='base'))


def test_what_hangs_on_an_object_is_not_left_without_it(live, moveit):
    moveit.take_object(box('a'))
    moveit.take_attached(attached_object('hand', box('b')))
    with live.editing() as held:
        names = held.model.names
        held.make(attachment(held, names.frame('arm::finger'), names.frame('a'), RigidTransform()))
    before = state(live)
    with pytest.raises(RuntimeError, match='hangs on'):
        moveit.take_object(collision_object('a', REMOVE))
    assert state(live) == before


def test_a_saved_scene_holds_the_objects(full):
    with full.reading() as held:
        text = to_yaml(held.description())
    again = live_scene(text, Clock())
    assert place(again, 'there') == place(full, 'there')
    moveit = PlanningSceneInput(again)
    assert '1 object in the world, 1 attached' in moveit.take_object(
        collision_object('there', MOVE, at=pose(4.0))
    )
    assert read_scene(text).sources == ('arm', 'planning_scene')


# A model of MoveIt's world, one number an object: where it is along x.


class Model:
    """Objects by id: x in the world, number of shapes, and whether the hand at ``x`` has it."""

    def __init__(self):
        self.x, self.objects = 0.0, {}

    def take(self, operation, name, x):
        held = name in self.objects and self.objects[name][2]
        if operation == REMOVE:
            self.objects = {k: v for k, v in self.objects.items() if v[2] or (name and k != name)}
        elif held or (operation == MOVE and name not in self.objects) or not name:
            return False
        elif operation == APPEND and name in self.objects:
            old = self.objects[name]
            self.objects[name] = (old[0], old[1] + 1, False)
        elif operation == MOVE:
            self.objects[name] = (x, *self.objects[name][1:])
        else:
            self.objects[name] = (x, 1, False)
        return True

    def attach(self, name, x, *, bare):
        if not name or (bare and name not in self.objects):
            return False
        old = self.objects.get(name)
        self.objects[name] = (old[0], old[1], True) if bare else (x, 1, True)
        return True

    def detach(self, name):
        for key, (x, count, held) in self.objects.items():
            if held and name in ('', key):
                self.objects[key] = (x, count, False)
        return True

    def hand(self, x):
        for key, (at, count, held) in self.objects.items():
            self.objects[key] = (at + x - self.x if held else at, count, held)
        self.x = x


steps = st.lists(
    st.tuples(
        st.sampled_from(['take'] * 4 + ['attach', 'bare', 'detach', 'hand']),
        st.sampled_from(['', 'a', 'b', 'c']),
        st.sampled_from([ADD, REMOVE, APPEND, MOVE]),
        st.integers(-3, 3).map(float),
    ),
    max_size=12,
)


@settings(max_examples=60, deadline=None)
@given(steps)
@example([('attach', 'a', 0, 0.0), ('attach', 'b', 0, 0.0), ('detach', 'a', 0, 0.0)])
def test_any_order_of_messages_does_as_the_model(all_steps):
    live = live_scene(ARM, Clock())
    first, moveit, model = state(live), PlanningSceneInput(live), Model()
    for kind, name, operation, x in all_steps:
        before = state(live)
        bare = kind == 'bare'
        if kind == 'hand':
            put(live, 'arm::hand', x, 0.0, 1.0)
            model.hand(x)
            continue
        if kind == 'take':
            taken = model.take(operation, name, x)
            fields = {'primitives': [], 'primitive_poses': []} if operation == MOVE else {}
            message, take = box(name, x, operation=operation, **fields), moveit.take_object
        elif kind == 'detach':
            taken, take = model.detach(name), moveit.take_attached
            message = attached_object('', collision_object(name, REMOVE))
        else:
            taken, take = model.attach(name, x, bare=bare), moveit.take_attached
            message = attached_object('hand', collision_object(name) if bare else box(name, x))
        try:
            take(message)
        except RuntimeError:
            assert not taken
            assert state(live) == before
        else:
            assert taken
    _agree(live, model)
    moveit.take_attached(attached_object('', collision_object('', REMOVE)))
    moveit.take_object(collision_object('', REMOVE))
    put(live, 'arm::hand', 0.0, 0.0, 1.0)
    assert state(live) == first


def _agree(live, model):
    """Assert that a scene holds what a model does, with the pairs that follow."""
    with live.reading() as held:
        names = held.model.names
        mine = {n: f for f, (s, n) in names.labels.items() if s == 'planning_scene'}
        assert mine.keys() == model.objects.keys()
        for name, (x, count, is_held) in model.objects.items():
            at = held.query.X_WF(mine[name]).translation()
            assert np.abs(at - [x, 0.0, 0.0]).max() <= 1e-12
            assert held.model.inspector.NumGeometriesForFrame(mine[name]) == count
            assert held.model.inspector.IsAttached(mine[name]) == is_held
    links = ['base/base', 'hand/hand', 'finger/finger']
    expected = {frozenset(both) for both in combinations(links, 2)}
    shapes = [
        (f'{n}/sphere_{k}', n, h) for n, (_, c, h) in model.objects.items() for k in range(c)
    ]
    expected |= {frozenset([s, k]) for s, _, h in shapes for k in links if not (h and 'hand' in k)}
    expected |= {
        frozenset([s, t]) for (s, n, h), (t, m, g) in combinations(shapes, 2) if n != m and h != g
    }
    assert pairs(live) == expected
