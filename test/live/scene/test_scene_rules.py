"""Proximity rules of a live scene: the next decision knows what changed. Without a node."""

from collections import Counter
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from drake_geom_msgs import msg
from live.live_scenes import Clock, Topic, live_scene
from ros.scene_calls import poses
from std_msgs.msg import Float64

from drake_geom_ros.geometry import ACCURACY_LEVELS
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.live.scene.changes.attachment import attachment, detachment
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import begin_with_maps
from drake_geom_ros.live.services.proximity_rules import (
    acknowledge_rule,
    list_proximity_rules,
    remove_proximity_rule,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import RuleError, Why
from drake_geom_ros.scene_files import read_scene, to_yaml

TEXT = """
name: cell
sources: [arm]
frames:
- {name: hand, source: arm, static: false, pose: {position: [1, 0, 0]}}
- {name: part, pose: {position: [0, 3, 0]}, static: true}
geometries:
- {name: ball, source: arm, frame: hand, shape: {type: ellipsoid, semi_axes: [0.1, 0.15, 0.2]}}
- {name: box, frame: part, shape: {type: box, size: [0.2, 0.2, 0.2]}}
- {name: post, shape: {type: cylinder, radius: 0.1, length: 1}}
proximity_rules:
- {name: hand, set_a: arm, set_b: post, level: warn, enter: 0.2, leave: 0.3}
- {name: part, set_a: part, set_b: post, level: stop, enter: 0.2, leave: 0.3}
"""
TYPES = Plain(
    ProximityEvents=msg.ProximityEvents,
    ProximityRules=msg.ProximityRules,
    ProximityStates=msg.ProximityStates,
    SpeedLimits=msg.SpeedLimits,
    Stopping=msg.Stopping,
    Float64=Float64,
)


class Ruled:
    """A live scene with rules, looked at again and again as a node does."""

    def __init__(self, text=TEXT, stale_after=1.0, time_budget=0.0):
        self.clock = Clock()
        self.live = live_scene(text, self.clock)
        self.topics = RuleTopics(*(Topic() for _ in range(5)))
        self.computed = []
        settings = RuleSettings(stale_after, time_budget)
        did = lambda pairs, _: self.computed.append(pairs)  # noqa: E731
        self.events = RuleEvents(self.topics, TYPES, lambda: settings, did)

    def move(self, *place, cycle=True):
        """Pose the hand; with a ``cycle``, decide by it."""
        with self.live.editing() as scene:
            scene.poses.take(poses(['hand'], [(*place, 0, 0)[:3]], source='arm'))
            if cycle:
                self.events.look_at(scene, None, 0.0)

    def wait(self, seconds=0.1):
        """Let time go on; return what was told in it: names and whether they were entered."""
        self.clock.now += seconds
        told = len(self.topics.events.published)
        with self.live.reading() as scene:
            self.events.look_again(scene)
        return [
            (name, entered)
            for message in self.topics.events.published[told:]
            for name, entered in zip(message.rule, message.entered, strict=True)
        ]


def frame(scene, name):
    return next(f for f, label in scene.model.names.frame_names.items() if label.endswith(name))


@pytest.fixture
def ruled():
    made = Ruled()
    made.move(1.0)
    made.wait()
    return made


def test_what_is_attached_grows_old_with_what_holds_it(ruled):
    with ruled.live.editing() as scene:
        hand, part = frame(scene, 'hand'), frame(scene, 'part')
        scene.make(attachment(scene, part, hand, RigidTransform([0.5, 0, 0])))
    assert ruled.wait() == []
    assert ruled.wait(2.0) == [('part', True)]
    assert ruled.topics.events.published[-1].why[0] == Why.STALE
    ruled.move(1.0)
    ruled.wait()
    with ruled.live.editing() as scene:
        scene.make(detachment(scene, part, RigidTransform([0, 3, 0])))
    ruled.wait()
    assert ruled.wait(2.0) == []


def test_what_is_put_somewhere_without_a_cycle_is_seen(ruled):
    with ruled.live.editing() as scene:
        X_HP = RigidTransform([-0.7, 0, 0])
        scene.make(
            attachment(scene, frame(scene, 'part'), frame(scene, 'hand'), X_HP, is_part=False)
        )
    assert ruled.wait() == [('part', True)]
    with ruled.live.editing() as scene:
        scene.make(detachment(scene, frame(scene, 'part'), RigidTransform([0, 3, 0])))
    assert ruled.wait() == [('part', False)]
    ruled.move(0.25, cycle=False)  # as poses come that hang on others, or between two cycles
    assert ruled.wait() == [('hand', True)]


def test_rules_are_decided_at_the_level_of_now(ruled):
    ruled.move(0.33, 0.33, 0.6)
    assert ruled.wait() == []  # 0.2506 m, to be seen at level exact
    with ruled.live.editing() as scene:
        scene.set_accuracy('bound')
    assert ruled.wait() == [('hand', True)]  # its bounds alone do not prove 0.2 m
    event = ruled.topics.events.published[-1]
    assert event.accuracy == 'bound'
    assert event.distance[0] - event.error_bound[0] < 0.2
    with ruled.live.editing() as scene:
        scene.set_accuracy('exact')
    assert ruled.wait() == []
    ruled.move(0.55)
    assert not ruled.topics.events.published[-1].entered[0]


@pytest.mark.parametrize('level', ACCURACY_LEVELS)
@pytest.mark.parametrize('time_budget', [0.0, 1e-9])
def test_no_rule_is_entered_later_than_at_the_exact_distance(level, time_budget):
    """At no level, and where the time is up before any pair was looked at."""
    exact, other = Ruled(stale_after=1e6), Ruled(stale_after=1e6, time_budget=time_budget)
    with other.live.editing() as scene:
        scene.set_accuracy(level)
    rng, entered = np.random.default_rng(1), Counter()
    for _ in range(150):
        place = rng.uniform((-0.6, -0.6, 0.0), (0.6, 0.6, 0.9))
        for each in (exact, other):
            each.move(*place)
            each.wait()
        with exact.live.reading() as a, other.live.reading() as b:
            for one, two in zip(a.rules.states(), b.rules.states(), strict=True):
                assert two.is_entered or not one.is_entered
                assert two.lowest <= one.lowest + 1e-9
                entered[one.is_entered, two.is_entered] += 1
    assert entered[True, True] > 5
    assert entered[False, True] > 0 or level != 'bound'  # early is allowed


def test_an_event_bears_where_its_pair_was(ruled):
    ruled.move(0.3)
    (event,) = ruled.topics.events.published[-1:]
    places = {event.geometry_a[0]: event.pose_a, event.geometry_b[0]: event.pose_b}
    assert places['arm::hand/ball'].tolist() == pytest.approx([0.3, 0, 0, 0, 0, 0, 1])
    assert places['cell::world/post'].tolist() == pytest.approx([0, 0, 0, 0, 0, 0, 1])
    assert (event.limit_distance[0], event.limit_time[0]) == (0.2, 0.0)
    ruled.move(1.0)
    (event,) = ruled.topics.events.published[-1:]
    assert (event.entered[0], event.limit_distance[0]) == (False, 0.3)
    assert np.isnan(event.pose_a).all()
    assert event.distance[0] == np.inf


def test_a_rule_that_goes_on_without_a_name_is_told_of():
    text = TEXT.replace('set_a: arm, set_b: post, level: warn', 'set_a: [arm, box], level: warn')
    wall = '- {name: wall, source: other, shape: {type: sphere, radius: 0.01}}'
    text = text.replace('[arm]', '[arm, other]').replace(
        'proximity_rules', f'{wall}\nproximity_rules'
    )
    ruled = Ruled(text)
    ruled.move(1.0)
    ruled.wait()
    with ruled.live.editing() as scene:
        assert not scene.rules.troubles(watches_motion=True)
        scene.make(removal(scene, scene.model.names.source('cell')))
    ruled.wait()
    with ruled.live.reading() as scene:
        (told,) = scene.rules.troubles(watches_motion=True)
    assert "'hand' goes on without box" in told


def test_a_rule_by_time_to_contact_is_not_left_where_nobody_knows_how_its_body_moves():
    text = TEXT.replace('level: warn', 'level: warn, min_time_to_contact: 3.0')
    ruled = Ruled(text, stale_after=10.0)
    with ruled.live.editing() as scene:
        scene.poses.watch_motion(10.0)

    def move(x, stamp):
        with ruled.live.editing() as scene:
            message = poses(['hand'], [(x, 0, 0)], source='arm', stamp=stamp)
            scene.poses.take(message)
            ruled.events.look_at(scene, None, 0.0)
        told = ruled.topics.events.published
        return [(n, e, w) for m in told for n, e, w in zip(m.rule, m.entered, m.why, strict=True)]

    assert move(4.0, 97) == []
    assert move(3.0, 98)[-1] == ('hand', True, Why.SOON)
    known = len(move(3.0, 0))  # without a stamp
    with ruled.live.reading() as scene:
        (told,) = scene.rules.troubles(watches_motion=True)
    assert told.startswith('nobody knows how all bodies move')
    assert 'rules hand:' in told
    assert len(move(3.0, 99)) == known  # the first stamp tells no motion yet
    assert move(3.0, 100)[-1] == ('hand', False, Why.SOON)


def test_numbers_have_no_gap_whoever_ends_a_rule(ruled):
    with ruled.live.editing() as scene:
        scene.rules.remove('hand')
        scene.make(removal(scene, scene.model.names.source('cell')))
    ruled.wait()
    numbers = [n for message in ruled.topics.events.published for n in message.sequence]
    assert numbers == list(range(1, len(numbers) + 1))
    last = ruled.topics.states.published[-1]
    assert (last.rules.name, last.next_sequence) == ([], len(numbers) + 1)


PART_AT = [0.3, 0, 0]  # beside the hand, so near the post when the hand is not


@pytest.mark.parametrize('is_part', [True, False])
def test_what_a_robot_carries_counts_as_the_robot_unless_it_is_turned_off(ruled, is_part):
    ruled.move(-0.7)
    ruled.wait()
    assert ruled.wait() == []
    with ruled.live.editing() as scene:
        hand, part = frame(scene, 'hand'), frame(scene, 'part')
        scene.make(attachment(scene, part, hand, RigidTransform(PART_AT), is_part=is_part))
    told = ruled.wait()
    assert ('part', True) in told
    assert (('hand', True) in told) == is_part
    if is_part:
        message = ruled.topics.events.published[-1]
        assert 'cell::part/box' in {*message.geometry_a, *message.geometry_b}
    with ruled.live.editing() as scene:
        scene.make(detachment(scene, part, RigidTransform([0, 3, 0])))
    told = ruled.wait()
    assert ('part', False) in told
    assert (('hand', False) in told) == is_part


@pytest.mark.parametrize('key', ['', ', part_of_robot: false'])
def test_what_a_file_attaches_counts_as_the_robot_and_is_saved_so(key):
    attached = f'- {{name: part, attached_to: hand, pose: {{position: {PART_AT}}}{key}}}'
    old = '- {name: part, pose: {position: [0, 3, 0]}, static: true}'
    ruled = Ruled(TEXT.replace(old, attached))
    with ruled.live.reading() as scene:
        saved = to_yaml(scene.description())
    for text in (TEXT.replace(old, attached), saved):
        ruled = Ruled(text)
        ruled.move(-0.7)
        ruled.wait()
        with ruled.live.reading() as scene:
            entered = [s.rule.name for s in scene.rules.states() if s.is_entered]
        assert ('hand' in entered) == (not key)


def test_a_key_of_attached_frames_is_refused_for_others():
    text = TEXT.replace('static: true}', 'static: true, part_of_robot: false}')
    with pytest.raises(RuntimeError, match='part_of_robot is of frames that are attached'):
        Ruled(text)


ABOUT_MAPS = '- {name: seen, set_a: arm, set_b: obstacles, level: stop, enter: 0.2, leave: 0.3}\n'


def test_a_rule_about_maps_that_the_node_listens_to_is_no_trouble_at_the_start():
    described = read_scene(TEXT + ABOUT_MAPS)
    live = LiveScene('exact', Clocks(Clock(), Clock()))
    with live.editing() as scene:
        assert begin_with_maps(scene, described, ['points', 'depth']) == (2, 3)
        assert scene.log.warnings == []
        assert scene.troubles() == []
        (seen,) = [s for s in scene.rules.states() if s.rule.name == 'seen']
        assert seen.pairs == 2
    without = LiveScene('exact', Clocks(Clock(), Clock()))
    with without.editing() as scene:
        begin_with_maps(scene, described, [])
        (told,) = scene.log.warnings
        assert "'obstacles' stands for no geometry" in told


def test_a_scene_with_a_source_called_as_that_of_maps_is_refused_beside_maps():
    described = read_scene(TEXT.replace('sources: [arm]', 'sources: [arm, obstacles]'))
    live = LiveScene('exact', Clocks(Clock(), Clock()))
    with live.editing() as scene:
        with pytest.raises(RuntimeError, match="has a source 'obstacles'"):
            begin_with_maps(scene, described, ['points'])
        assert scene.maps.by_name == {}


LATCHED = TEXT.replace('level: warn,', 'level: stop, acknowledge: true,')


def latched_by_its_cause():
    """Return a scene whose rule about the hand is entered, and its cause gone."""
    ruled = Ruled(LATCHED, stale_after=1e6)
    for place in (1.0, 0.2, 1.0):
        ruled.move(place)
        ruled.wait()
    return ruled


def state_of(ruled, name='hand'):
    """Return whether a rule is entered, awaits to be acknowledged, and by which event."""
    with ruled.live.reading() as scene:
        answer = Plain(states=msg.ProximityStates())
        list_proximity_rules(ruled.live, Plain(), answer)
        assert [r.name for r in scene.rules.rules] == answer.states.rules.name
    states, k = answer.states, answer.states.rules.name.index(name)
    return states.entered[k], states.awaits_acknowledgement[k], states.entered_sequence[k]


def acknowledge(ruled, sequence, name='hand'):
    answer = Plain(message='')
    acknowledge_rule(ruled.live, Plain(name=name, sequence=sequence), answer)
    return answer.message


def test_a_latched_rule_is_published_as_what_it_is_until_it_is_acknowledged():
    ruled = latched_by_its_cause()
    entered, awaits, event = state_of(ruled)
    assert (entered, awaits) == (True, True)
    assert ruled.wait() == []
    with ruled.live.reading() as scene:
        assert scene.rules.in_words() == '2, entered: hand (near, to be acknowledged)'
    states = ruled.topics.states.published[-1]
    assert list(states.awaits_acknowledgement) == [True, False]
    assert list(states.entered_sequence) == [event, 0]
    assert list(states.rules.acknowledge) == [True, False]
    with pytest.raises(RuleError, match=f'by event {event}'):
        acknowledge(ruled, event + 1)
    assert ruled.wait() == []
    assert acknowledge(ruled, event) == 'it is left by the next decision'
    assert ruled.wait() == [('hand', False)]
    assert state_of(ruled) == (False, False, event)
    ruled.wait()
    assert not ruled.topics.states.published[-1].awaits_acknowledgement[0]


def test_a_scene_that_is_loaded_anew_releases_no_latch():
    ruled = latched_by_its_cause()
    event = state_of(ruled)[2]
    changed = LATCHED.replace('acknowledge: true', 'acknowledge: true, hold: 0.5')
    for text in (changed, LATCHED):
        ruled.live.replace_all(read_scene(text))
        ruled.move(1.0)
        assert ('hand', False) not in ruled.wait()
        assert state_of(ruled)[::2] == (True, event)
    ruled.live.replace_all(read_scene(TEXT[: TEXT.index('geometries')]))
    assert ('hand', False) not in ruled.wait()
    assert state_of(ruled)[::2] == (True, event)  # though nothing is left that it is about
    acknowledge(ruled, event)
    ruled.wait()
    assert ruled.topics.events.published[-1].why[-1] == Why.GONE


def test_a_rule_without_a_latch_in_the_place_of_a_latched_one_is_warned_of():
    ruled = latched_by_its_cause()
    ruled.live.replace_all(read_scene(TEXT))
    with ruled.live.editing() as scene:
        assert any('was entered and not acknowledged' in text for text in scene.log.take()[1])
    assert ('hand', False) in ruled.wait()


def test_removing_a_latched_rule_says_that_nobody_acknowledged_it():
    ruled = latched_by_its_cause()
    answer, event = Plain(message=''), state_of(ruled)[2]
    remove_proximity_rule(ruled.live, Plain(name='hand'), answer)
    assert f'entered by event {event}, and nobody acknowledged it' in answer.message
    assert ruled.wait() == [('hand', False)]


def test_latches_of_a_scene_that_a_node_begins_with_are_entered():
    ruled = Ruled(LATCHED, stale_after=1e6)
    with ruled.live.editing() as scene:
        scene.rules.begin_entered()
    ruled.move(1.0)
    event = state_of(ruled)[2]
    assert state_of(ruled) == (True, False, event)
    ruled.wait()
    assert state_of(ruled) == (True, True, event)
    acknowledge(ruled, event)
    assert ruled.wait() == [('hand', False)]
