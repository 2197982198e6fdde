"""Tracked bodies come, move, take another shape, grow stale and leave, without ROS."""

import array
import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.live_scenes import Clock

from drake_geom_ros.geometry import Box, Sphere
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.conversions.scene import fill_roles, properties_from_message
from drake_geom_ros.live.conversions.tracked_objects import TrackedObjectsReader
from drake_geom_ros.live.inputs.tracked_input import TrackedInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services import scene as services
from drake_geom_ros.proximity_rules import Why
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.viewing.looks import is_drawn, looks_of

CELL = """
frames: [{name: hand, source: arm, pose: {}}]
geometries:
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: floor, source: cell, shape: {type: half_space}, pose: {position: [0, 0, -5]}}
proximity_rules:
- {name: stop, set_a: [arm], set_b: [tracked], level: stop, enter: 0.5, leave: 0.6}
"""
STALE_AFTER = 1.0
FILES = FileAccess([])
BALL, BOX = (1, [0.1]), (2, [0.2, 0.3, 0.4])


def message(bodies, at=0.0, frame='', lifetime=0.5, shape=BALL, **fields):
    """Return a TrackedObjects of bodies {name: x} or {name: (x, shape)}."""
    kinds = {name: v[1] if isinstance(v, tuple) else shape for name, v in bodies.items()}
    xs = [v[0] if isinstance(v, tuple) else v for v in bodies.values()]
    whole, part = divmod(round(at * 1e9), 10**9)
    values = {
        'header': Plain(stamp=Plain(sec=whole, nanosec=part), frame_id=frame),
        'names': list(bodies),
        'shapes': [
            Plain(
                type=kind,
                dimensions=array.array('d', sizes),
                mesh_uri='',
                vertices=array.array('d'),
                triangles=array.array('I'),
            )
            for kind, sizes in kinds.values()
        ],
        'poses': [value for x in xs for value in (x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)],
        'velocities': [],
        'lifetimes': [lifetime] * len(bodies),
    }
    return Plain(**{**values, **fields})


class Cell:
    """A live scene with a tracker, whose node's and steady time the test sets."""

    def __init__(self, text=CELL):
        self.node, self.steady = Clock(), Clock()
        self.live = LiveScene('exact', Clocks(self.node, self.steady))
        self.input = TrackedInput(self.live, self.hanging)
        self.reader = TrackedObjectsReader()
        if text:
            with self.live.editing() as scene:
                scene.make(addition(read_scene(text)))

    @staticmethod
    def hanging(scene, name, _):
        return scene.model.names.frame(name), scene.query.X_WF(scene.model.names.world)

    def wait(self, seconds):
        """Let both clocks go on."""
        self.node.now += seconds
        self.steady.now += seconds

    def hear(self, bodies, sender='t', **fields):
        """Hear a message of now."""
        fields = {'at': self.node.now, **fields}
        return self.input.take(self.reader.read(message(bodies, **fields), FILES), 0.0, sender)

    def xs(self):
        """Return where bodies are, by name."""
        with self.live.reading() as scene:
            return {
                name: scene.query.X_WF(body.frame).translation()[0]
                for name, body in scene.tracked.bodies.items()
            }

    def names(self):
        """Return the full names of the source's geometries."""
        with self.live.reading() as scene:
            names = scene.model.names.geometry_names.values()
            return sorted(name for name in names if name.startswith('tracked::'))

    def decide(self):
        """Decide the rule, and return its state."""
        with self.live.editing() as scene:
            scene.bind_rules()
            blind = scene.blind_frames(STALE_AFTER)
            scene.rules.decide(self.steady.now, scene.query, blind)
            (state,) = scene.rules.states()
        return state

    def why(self):
        """Return why the rule is entered; None: it is not."""
        return self.decide().why

    def distance(self, name='anna'):
        """Return the distance from the hand to a body [m]."""
        with self.live.reading() as scene:
            inspector, names = scene.model.inspector, scene.model.names
            hand = names.geometry('arm::hand/hand')
            body = names.geometry(f'tracked::{name}/body')
            assert inspector.CollisionFiltered(hand, body) is False
            return scene.query.ComputeSignedDistancePairClosestPoints(hand, body).distance


@pytest.fixture
def cell():
    return Cell()


def test_the_heartbeat_is_in_no_picture(cell):
    cell.hear({'anna': 3.0})
    with cell.live.reading() as scene:
        looks = looks_of(scene.model.inspector)
        heartbeat = scene.model.names.geometry('tracked::heartbeat/heartbeat')
        message = Plain(roles=[])
        types = Plain(
            Role=lambda role: Plain(role=role, properties=[]),
            Property=lambda group, name: Plain(group=group, name=name, value=Plain()),
        )
        fill_roles(message, scene.model.inspector, heartbeat, types)
    assert {look.name for look in looks} >= {'tracked::anna/body', 'arm::hand/hand'}
    assert 'tracked::heartbeat/heartbeat' not in {look.name for look in looks}
    (role,) = message.roles  # from which a page of another process draws
    assert not is_drawn(properties_from_message(role))


def test_bodies_come_move_and_leave_when_they_are_not_named(cell):
    cell.hear({'anna': 3.0, 'ben': 4.0})
    assert cell.names() == [
        'tracked::anna/body',
        'tracked::ben/body',
        'tracked::heartbeat/heartbeat',
    ]
    assert cell.distance() == pytest.approx(2.8)
    cell.wait(0.4)
    cell.hear({'anna': 2.0})
    assert cell.xs() == {'anna': 2.0, 'ben': 4.0}
    cell.wait(0.4)
    assert cell.input.sweep() == 1
    assert cell.xs() == {'anna': 2.0}
    with cell.live.editing() as scene:
        (note,) = [note for note in scene.log.take()[0] if 'tracked' in note]
    assert note.endswith('not named for the lifetime, taken out: tracked::ben')
    cell.hear({'ben': 1.0})
    assert cell.xs() == {'anna': 2.0, 'ben': 1.0}, 'a name may come again'


def test_a_message_itself_takes_out_what_has_ended(cell):
    cell.hear({'anna': 3.0, 'ben': 4.0})
    cell.wait(0.6)
    cell.hear({'anna': 2.0})
    assert cell.xs() == {'anna': 2.0}


def test_a_body_that_ended_and_is_named_again_stays(cell):
    cell.hear({'anna': 3.0})
    cell.wait(9.0)
    cell.hear({'anna': 2.0})
    assert cell.xs() == {'anna': 2.0}


def test_another_shape_takes_the_place_of_the_one_before(cell):
    cell.hear({'anna': 3.0})
    with cell.live.reading() as scene:
        before = scene.tracked.bodies['anna']
    cell.hear({'anna': (3.0, BOX)})
    with cell.live.reading() as scene:
        after = scene.tracked.bodies['anna']
        assert scene.model.inspector.GetShape(after.geometry) == Box(0.2, 0.3, 0.4)
    assert (after.frame, after.geometry) == (before.frame, before.geometry)
    assert cell.distance() == pytest.approx(3.0 - 0.1 - 0.1)
    version = after.shape
    cell.hear({'anna': (2.0, BOX)})
    with cell.live.reading() as scene:
        assert scene.tracked.bodies['anna'].shape is version, 'an equal shape is no change'


def test_bodies_move_in_a_scene_that_is_held(cell):
    def move(bodies, **fields):
        read = cell.reader.read(message(bodies, at=cell.node.now, **fields), FILES)
        with cell.live.editing() as scene:
            return cell.input.move(scene, read, 0.0, 't')

    assert not move({'anna': 3.0}), 'nobody was there'
    cell.hear({'anna': 3.0, 'ben': 4.0})
    assert move({'anna': 2.0, 'ben': 5.0})
    assert cell.xs() == {'anna': 2.0, 'ben': 5.0}
    assert move({'anna': 1.0}), 'ben may be hidden'
    for does_more in ({'carl': 1.0}, {'anna': (1.0, BOX)}):
        assert not move(does_more)
    assert not move({'anna': 9.0}, frame='camera'), 'whose pose may have to be waited for'
    cell.wait(0.6)
    assert not move({'anna': 9.0}), 'ben leaves'
    assert cell.xs() == {'anna': 1.0, 'ben': 5.0}


def test_bodies_that_move_with_poses_renew_their_lifetimes_and_the_heartbeat(cell):
    cell.hear({'anna': 3.0})
    assert cell.why() is None
    for _ in range(5):
        cell.wait(0.4)
        read = cell.reader.read(message({'anna': 3.0}, at=cell.node.now), FILES)
        with cell.live.editing() as scene:
            assert cell.input.move(scene, read, 0.0, 't')
        assert not cell.input.sweep()
        assert cell.why() is None


def test_a_rule_is_stopped_until_a_tracker_speaks_and_when_it_falls_silent(cell):
    assert cell.why() == Why.NO_POSE
    cell.hear({})
    assert cell.why() is None, 'nobody is there, and the tracker says so'
    cell.hear({'anna': 0.5})
    assert cell.why() == Why.NEAR
    cell.wait(0.7)
    cell.hear({})
    assert cell.why() is None
    cell.wait(1.5)
    assert cell.why() == Why.STALE, 'a silent tracker is no empty room'
    cell.hear({})
    assert cell.why() is None


def test_what_is_only_late_is_stale_and_stays(cell):
    cell.hear({'anna': 3.0}, lifetime=5.0)
    assert cell.why() is None
    cell.wait(1.5)
    cell.input.sweep()
    cell.hear({})
    assert cell.why() == Why.STALE
    assert cell.xs() == {'anna': 3.0}
    cell.hear({'anna': 3.0}, at=cell.node.now - 3.0, lifetime=5.0)
    assert cell.why() == Why.STALE, 'its stamp is that old'
    cell.wait(4.0)
    assert cell.input.sweep() == 0, 'it was heard of 4 s ago'
    cell.wait(1.1)
    assert cell.input.sweep() == 1


def test_while_simulated_time_rests_nobody_leaves_and_rules_are_stale(cell):
    cell.hear({'anna': 3.0})
    cell.steady.now += 60.0
    assert cell.input.sweep() == 0
    assert cell.why() == Why.STALE


def test_lifetimes_begin_anew_where_the_clock_jumps(cell):
    cell.hear({'anna': 3.0})
    cell.live.clocks.begin_anew()
    cell.node.now += 1e6
    assert cell.input.sweep() == 0
    assert cell.why() == Why.STALE
    cell.wait(0.6)
    assert cell.input.sweep() == 1


def test_lifetimes_end_by_the_time_to_which_the_clock_went_back(cell):
    cell.hear({'anna': 3.0})
    cell.live.clocks.begin_anew()
    cell.node.now -= 1000.0
    cell.hear({})
    cell.wait(0.6)
    assert cell.input.sweep() == 1


def test_the_shortest_lifetime_ends_first(cell):
    cell.hear({'anna': 3.0, 'ben': 4.0}, lifetimes=[0.9, 0.3])
    cell.wait(0.4)
    assert cell.input.sweep() == 1
    assert set(cell.xs()) == {'anna'}
    cell.hear({'anna': 3.0}, lifetime=0.2)
    cell.wait(0.25)
    assert cell.input.sweep() == 1


def test_a_rule_that_names_a_body_ends_with_it(cell):
    cell.hear({'anna': 3.0})
    with cell.live.editing() as scene:
        rules = read_scene(CELL.replace('name: stop', 'name: anna').replace('[tracked]', '[anna]'))
        scene.bind_rules()
        scene.rules.add(rules.rules)
        scene.rules.take_events()
    cell.wait(0.6)
    cell.input.sweep()
    with cell.live.editing() as scene:
        scene.bind_rules()
        (event,) = scene.rules.take_events()
        assert [rule.name for rule in scene.rules.rules] == ['stop']
    assert event.why == Why.GONE


def test_of_two_trackers_the_silent_one_counts(cell):
    for sender in 'aba':
        cell.hear({sender: 3.0}, sender=sender)
    for _ in range(8):
        cell.wait(0.2)
        cell.hear({'a': 3.0}, sender='a')
    assert cell.why() == Why.STALE
    with cell.live.reading() as scene:
        (trouble,) = scene.tracked.troubles()
    assert trouble.startswith('2 trackers send bodies: ')


def test_a_tracker_that_is_started_anew_takes_the_place_of_the_one_before(cell):
    cell.hear({}, sender='a')
    cell.wait(1.5)
    for _ in range(3):
        cell.hear({}, sender='b')
    assert cell.why() is None


def test_a_body_that_two_send_in_turn_is_contested(cell):
    for sender in 'ababab':
        cell.wait(0.05)
        cell.hear({'anna': 3.0}, sender=sender)
    assert cell.why() == Why.TWO_SENDERS


BAD = [
    ({'poses': [0.0] * 6}, 'poses holds 6 numbers for 1 body'),
    ({'poses': [math.nan, *[0.0] * 5, 1.0]}, 'nan'),
    ({'poses': [0.0] * 7}, ''),
    ({'lifetimes': []}, 'lifetimes holds 0 for 1 body'),
    ({'lifetimes': [0.0]}, 'it must be > 0'),
    ({'lifetimes': [math.nan]}, 'it must be > 0'),
    ({'velocities': [0.0]}, 'velocities holds 1 numbers'),
    ({'velocities': [math.inf] * 6}, 'must be finite'),
    ({'shapes': []}, 'shapes holds 0 for 1 body'),
    ({'names': ['']}, 'must not be empty'),
    ({'names': ['heartbeat']}, "the name 'heartbeat' is that of no body"),
    ({'names': ['x' * 300]}, 'a name has 300 letters'),
]


@pytest.mark.parametrize(('fields', 'reason'), BAD)
def test_a_bad_message_is_refused_whole(cell, fields, reason):
    cell.hear({'ben': 4.0})
    with pytest.raises(RuntimeError) as caught:
        cell.hear({'anna': 1.0}, **fields)
    assert reason in str(caught.value)
    assert cell.xs() == {'ben': 4.0}


@pytest.mark.parametrize(
    ('shape', 'reason'),
    [
        ((6, []), "the body 'anna' is a HalfSpace"),
        ((1, [-1.0]), "the body 'anna': "),
        ((99, []), 'shape.type is 99'),
        ((11, [0.1]), "the body 'anna' is a PointCloud"),
    ],
)
def test_a_shape_that_no_body_has_is_refused(cell, shape, reason):
    with pytest.raises(RuntimeError) as caught:
        cell.hear({'ben': 4.0, 'anna': (1.0, shape)})
    assert reason in str(caught.value)
    assert cell.names() == []


def test_names_that_are_named_twice_or_are_too_many_are_refused(cell):
    with pytest.raises(RuntimeError, match="'a' is named twice"):
        cell.hear({'a': 1.0, 'b': 2.0}, names=['a', 'a'])
    many = {f'{k}': float(k) for k in range(700)}
    cell.hear(many)
    with pytest.raises(RuntimeError, match='more than 1000 tracked bodies'):
        cell.hear({f'other {k}': float(k) for k in range(700)})
    assert len(cell.xs()) == 700


def test_the_scene_may_have_a_source_of_that_name_for_itself():
    own = Cell('sources: [tracked]\nframes: [{name: cart, source: tracked, pose: {}}]\n')
    with pytest.raises(RuntimeError, match="the scene has a source 'tracked'"):
        own.hear({'anna': 1.0})
    with own.live.reading() as scene:
        frame = scene.model.names.frame('cart')
        assert scene.model.names.tf_names(frame) == ('tracked/cart', 'cart')


def test_only_messages_change_tracked_bodies_and_tf_does_not_pose_them(cell):
    cell.hear({'anna': 3.0})
    for service, request in (
        (services.remove_geometry, {'geometry': 'tracked::anna/body'}),
        (services.remove_role, {'geometry': 'tracked::anna/body', 'role': 1}),
        (services.register_frame, {'name': 'x', 'source': 'tracked', 'parent': ''}),
    ):
        with pytest.raises(RuntimeError, match="the source 'tracked' holds bodies"):
            service(cell.live, Plain(**request), Plain())
    with cell.live.reading() as scene:
        assert scene.model.names.tf_names(scene.model.names.frame('anna')) == ()
    services.remove_source(cell.live, Plain(source='tracked'), Plain())
    assert cell.names() == []
    cell.hear({'ben': 1.0})
    assert cell.xs() == {'ben': 1.0}


def test_a_replaced_scene_waits_for_the_tracker_again_and_no_file_has_its_bodies(cell):
    cell.hear({'anna': 3.0})
    with cell.live.reading() as scene:
        described = scene.description()
    assert 'tracked' not in described.sources
    cell.live.replace_all(described)
    assert cell.names() == ['tracked::heartbeat/heartbeat']
    assert cell.why() == Why.NO_POSE
    cell.hear({'anna': 2.0})
    assert cell.why() is None
    assert cell.xs() == {'anna': 2.0}


def test_a_question_may_put_a_body_elsewhere(cell):
    cell.hear({'anna': 3.0})
    poses = Plain(
        header=Plain(stamp=Plain(sec=0, nanosec=0), frame_id=''),
        source='tracked',
        frame_names=['anna'],
        frame_ids=[],
        poses=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    )
    view = cell.live.view(poses)
    hand, body = (view.names.geometry(n) for n in ('arm::hand/hand', 'anna/body'))
    pair = view.query.ComputeSignedDistancePairClosestPoints(hand, body)
    assert pair.distance == pytest.approx(0.8)
    assert cell.xs() == {'anna': 3.0}


def move_hand(cell, row):
    """Pose the hand at the time of now."""
    stamp = Plain(sec=int(cell.node.now), nanosec=0)
    fields = {'source': '', 'frame_names': ['hand'], 'frame_ids': [], 'poses': row}
    with cell.live.editing() as scene:
        scene.poses.take(Plain(header=Plain(stamp=stamp, frame_id=''), **fields))


def test_bodies_in_the_frame_of_a_sensor_stand_where_it_was(cell):
    half_a_turn = [10.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    move_hand(cell, half_a_turn)
    # From the first message on the poses of the sensor are kept.
    with pytest.raises(RuntimeError, match='arm::hand was at the stamp of the message is not'):
        cell.hear({'anna': 3.0}, frame='hand')
    for _ in range(2):
        cell.wait(1.0)
        move_hand(cell, half_a_turn)
    cell.hear({'anna': 3.0}, frame='hand')
    assert cell.xs()['anna'] == pytest.approx(7.0)


def test_velocities_are_those_of_closing_speeds_in_the_axes_of_the_header(cell):
    with cell.live.editing() as scene:
        scene.poses.watch_motion(STALE_AFTER)
    cell.hear({'anna': 3.0}, velocities=[0.0, 0.0, 0.5, -1.0, 0.25, 0.0])
    with cell.live.reading() as scene:
        twist = scene.poses.twists()[scene.tracked.bodies['anna'].frame]
    np.testing.assert_array_equal(twist, [0.0, 0.0, 0.5, -1.0, 0.25, 0.0])


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.dictionaries(
                st.sampled_from('abc'),
                st.tuples(st.floats(-5, 5), st.sampled_from([BALL, BOX])),
                max_size=3,
            ),
            st.sampled_from([0.0, 0.1, 0.3, 0.6]),
            st.sampled_from([0.2, 0.5, math.inf]),
            st.booleans(),
            st.booleans(),
        ),
        max_size=12,
    )
)
def test_the_scene_has_the_bodies_that_were_named_within_their_lifetimes(steps):
    cell, expected = Cell(), {}
    for bodies, wait, lifetime, jumps, sweeps in steps:
        cell.wait(wait)
        if jumps:
            cell.live.clocks.begin_anew()
            cell.node.now -= 1000.0
            expected = {n: (*each[:3], cell.node.now) for n, each in expected.items()}
        cell.hear(bodies, lifetime=lifetime)
        for name, (x, shape) in bodies.items():
            expected[name] = x, shape, lifetime, cell.node.now
        if sweeps:
            cell.input.sweep()
        expected = {n: each for n, each in expected.items() if cell.node.now - each[3] <= each[2]}
        assert cell.xs() == {name: each[0] for name, each in expected.items()}
        with cell.live.reading() as scene:
            for name, (_, (kind, sizes), *_) in expected.items():
                shape = scene.model.inspector.GetShape(scene.tracked.bodies[name].geometry)
                assert shape == (Sphere if kind == 1 else Box)(*sizes)
