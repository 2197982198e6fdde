"""Proximity rules on the real middleware: events, states, the scale of speed, and a dead node."""

import math
import signal
import time

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from live.plain_messages import echoed
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile
from ros.harness import LATCHED, Client, start_node
from ros.scene_calls import accepted, poses, refused
from std_msgs.msg import Float64

from drake_geom_ros.client import ProximityMonitor
from drake_geom_ros.replay import Finding, Judge, read_events
from drake_geom_ros.ros.topics import DEADLINE, LEASE

pytestmark = pytest.mark.topics

SCENE = """
name: cell
sources: [arm]
frames:
- {name: hand, source: arm, static: false}
- {name: tray, pose: {position: [0, 5, 0]}}
geometries:
- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: post, pose: {position: [0, 0, 0]}, shape: {type: box, size: [0.2, 0.2, 2]}}
- {name: tray, frame: tray, shape: {type: box, size: [0.2, 0.2, 0.2]}}
proximity_rules:
- {name: hands off, set_a: arm, level: stop, enter: 0.05, leave: 0.1}
- {name: go slowly, set_a: arm, set_b: [post, tray], level: slow, enter: 0.3, leave: 0.45}
"""
EVENTS = QoSProfile(depth=1000)
AGAIN = 1.0  # [s] after which a pose is sent again
STOP, SLOW = 'hands off', 'go slowly'


@pytest.fixture(scope='module')
def scene_file(tmp_path_factory):
    path = tmp_path_factory.mktemp('rules') / 'cell.yaml'
    path.write_text(SCENE)
    return path


@pytest.fixture
def node(scene_file, tmp_path):
    process = start_node(
        tmp_path / 'log', name='ruled', scene_file=scene_file, stale_after=1e6, max_distance=0.01
    )
    yield process
    process.end()


@pytest.fixture
def client(node):
    client = Client('/ruled')
    yield client
    client.close()


class Hand:
    """Poses the ball so far from the post, as often as it takes to be heard."""

    def __init__(self, client):
        self._client = client
        self._publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def stand_at(self, gap):
        """Pose the ball with a gap [m] to the post."""
        message = poses(['hand'], [(0.2 + gap, 0, 0)], source='arm')
        message.header.stamp = self._client.node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def until(self, gap, fact, what):
        """Stand there until a fact holds; return it. What is sent to who is not known is lost."""
        again = 0.0

        def holds():
            nonlocal again
            if time.monotonic() > again:
                again = time.monotonic() + AGAIN
                self.stand_at(gap)
            return fact()

        return self._client.wait_for(holds, what)


def changes(heard):
    return [
        (rule, entered) for m in heard for rule, entered in zip(m.rule, m.entered, strict=True)
    ]


def sequences(heard):
    return [number for message in heard for number in message.sequence]


def standing(states):
    """Return by name whether rules are entered, as the last message says."""
    last = states[-1] if states else None
    return last and dict(zip(last.rules.name, last.entered, strict=True))


def test_a_hand_that_comes_and_goes(client):
    states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    events = client.listen(msg.ProximityEvents, 'proximity_events', EVENTS)
    scales = client.listen(Float64, 'speed_scale')
    # Before the first pose both are entered, because nobody knows where the hand is.
    client.wait_for(lambda: standing(states) == {STOP: True, SLOW: True}, 'the first states')
    assert states[-1].why[0] == msg.ProximityEvents.NO_POSE
    client.wait_for(lambda: scales and scales[-1].data == 0.0, 'a scale of 0')
    hand = Hand(client)
    hand.until(1.0, lambda: standing(states) == {STOP: False, SLOW: False}, 'the stop to go')
    client.wait_for(lambda: scales[-1].data == 1.0, 'a scale of 1')
    hand.until(0.25, lambda: standing(states) == {STOP: False, SLOW: True}, 'slow')
    client.wait_for(lambda: math.isclose(scales[-1].data, 0.5, abs_tol=1e-9), 'half speed')
    hand.until(0.04, lambda: standing(states) == {STOP: True, SLOW: True}, 'stop')
    client.wait_for(lambda: scales[-1].data == 0.0, 'a scale of 0')
    hand.until(0.07, lambda: scales[-1].data == 0.0, 'the stop to stay')
    hand.until(0.5, lambda: standing(states) == {STOP: False, SLOW: False}, 'all to go')
    expected = [(SLOW, True), (STOP, True), (STOP, False), (SLOW, False)]
    client.wait_for(lambda: changes(events)[-4:] == expected, 'the events')
    numbers = sequences(events)
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert states[-1].next_sequence == numbers[-1] + 1
    near = msg.ProximityEvents.NEAR
    stop = next(m for m in events if m.rule[0] == STOP and m.entered[0] and m.why[0] == near)
    assert (stop.geometry_a[0], stop.geometry_b[0]) in (
        ('arm::hand/ball', 'cell::world/post'),
        ('cell::world/post', 'arm::hand/ball'),
    )
    assert stop.distance[0] == pytest.approx(0.04, abs=1e-9)
    assert np.linalg.norm(np.subtract(stop.p_wca, stop.p_wcb)) == pytest.approx(0.04)
    assert stop.accuracy == 'exact'
    assert stop.header.stamp.sec >= 1


def test_rules_are_added_listed_and_removed(client):
    rule = msg.ProximityRule(
        name='tray', set_a=['arm'], set_b=['cell::tray'], level=1, enter=9.0, leave=9.5
    )
    added = accepted(client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule))
    assert (added.pairs, added.left_out_pairs) == (1, 0)
    events = client.listen(msg.ProximityEvents, 'proximity_events', EVENTS)
    Hand(client).until(1.0, lambda: ('tray', True) in changes(events), 'the tray to warn')
    told = accepted(client.call(srv.ListProximityRules, 'list_proximity_rules')).states
    assert told.rules.name == [STOP, SLOW, 'tray']
    assert list(told.entered) == [False, False, True]
    assert list(told.pairs) == [2, 2, 1]
    refused(client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule), 'already')
    rule.name, rule.set_b = 'new', ['trey']
    told = refused(client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule), 'trey')
    assert "nearest: 'tray'" in told
    rule.set_b, rule.min_time_to_contact = ['tray'], 1.0
    answer = client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule)
    refused(answer, 'closing_speeds')
    accepted(client.call(srv.RemoveProximityRule, 'remove_proximity_rule', name='tray'))
    client.wait_for(lambda: ('tray', False) in changes(events), 'the tray to be gone')
    refused(client.call(srv.RemoveProximityRule, 'remove_proximity_rule', name='tray'), 'no prox')


def test_rules_are_saved_and_end_with_what_they_are_about(client, tmp_path):
    saved = accepted(client.call(srv.SaveScene, 'save_scene'))
    assert 'name: hands off' in saved.text
    events = client.listen(msg.ProximityEvents, 'proximity_events', EVENTS)
    states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    client.wait_for(lambda: standing(states), 'the states')
    bare = SCENE[: SCENE.index('proximity_rules')].replace('tray', 'shelf').replace('post', 'mast')
    accepted(client.call(srv.LoadScene, 'load_scene', text=bare, replace=True))
    client.wait_for(lambda: standing(states) == {STOP: True}, 'a rule to end')
    # States may come before the events that they know of.
    client.wait_for(lambda: any(SLOW in m.rule for m in events), 'its event')
    reasons = [m.why[m.rule.index(SLOW)] for m in events if SLOW in m.rule]
    assert reasons[-1] == msg.ProximityEvents.GONE
    assert set(reasons[:-1]) <= {msg.ProximityEvents.NO_POSE}  # of before, where it was heard
    accepted(client.call(srv.LoadScene, 'load_scene', text=saved.text, replace=True))
    client.wait_for(lambda: set(standing(states)) == {STOP, SLOW}, 'the rules again')


def test_what_is_decided_while_nobody_listens_is_known_later(client):
    hand = Hand(client)
    states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    hand.until(1.0, lambda: standing(states) == {STOP: False, SLOW: False}, 'all to go')
    before = states[-1].next_sequence
    client.node.destroy_subscription(
        next(s for s in client.node.subscriptions if s.topic_name.endswith('proximity_states'))
    )

    def listed():
        return accepted(client.call(srv.ListProximityRules, 'list_proximity_rules')).states

    hand.until(0.0, lambda: all(listed().entered), 'the rules, with no listener')
    for transition in (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE):
        request = Transition(id=transition)
        assert client.call(ChangeState, 'change_state', transition=request).success
    # In this order: once the states have come the node knows who listens to events.
    events = client.listen(msg.ProximityEvents, 'proximity_events', EVENTS)
    late = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    client.wait_for(lambda: standing(late) == {STOP: True, SLOW: True}, 'a late listener to know')
    assert late[-1].next_sequence == before + 2
    assert all(since > 1e9 for since in late[-1].since)  # by the time of day
    hand.until(1.0, lambda: standing(late) == {STOP: False, SLOW: False}, 'all to go')
    client.wait_for(lambda: len(sequences(events)) == 2, 'the events')
    assert sequences(events) == [before + 2, before + 3]


def test_recorded_events_are_computed_again(client, tmp_path):
    events = client.listen(msg.ProximityEvents, 'proximity_events', EVENTS)
    states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    hand = Hand(client)
    for gap, stands in ((1.0, False), (0.04, True), (0.2, False)):
        hand.until(gap, lambda s=stands: (standing(states) or {}).get(STOP) == s, 'a change')
    client.wait_for(lambda: (STOP, True) in changes(events), 'the events')
    saved = accepted(client.call(srv.SaveScene, 'save_scene')).text
    (tmp_path / 'scene.yaml').write_text(saved)
    (tmp_path / 'events.yaml').write_text(echoed(events))
    judge = Judge(tmp_path / 'scene.yaml')
    recorded = read_events(tmp_path / 'events.yaml')
    assert {event.scene_version for event in recorded} == {states[-1].scene_version}
    found = [judge.verdict(event).finding for event in recorded if event.has_pair]
    assert len(found) >= 2
    assert set(found) == {Finding.FOUNDED}


def test_poses_that_stop_enter_a_stop_though_no_message_comes(scene_file, tmp_path):
    process = start_node(tmp_path / 'log', name='ageing', scene_file=scene_file, stale_after=0.5)
    client = Client('/ageing')
    try:
        states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
        hand = Hand(client)
        hand.until(1.0, lambda: standing(states) == {STOP: False, SLOW: False}, 'a good pose')
        client.wait_for(lambda: standing(states) == {STOP: True, SLOW: True}, 'a stale pose')
        assert states[-1].why[0] == msg.ProximityEvents.STALE
    finally:
        client.close()
        assert process.end() == 0, process.output()


def test_only_pairs_of_rules_are_computed_where_nobody_listens_to_distances(client):
    reports = client.listen(msg.CycleReport, 'cycle_report')
    hand = Hand(client)

    def decided():
        hand.stand_at(0.2)
        return next(
            (
                (report.effect_counts[k], report.effect_ran[k])
                for report in reports[-1:]
                for k, effect in enumerate(report.effects)
                if effect == 'decide proximity rules' and report.effect_ran[k]
            ),
            None,
        )

    count, ran = client.wait_for(decided, 'a report of rules')
    assert ran
    assert count >= 1
    assert reports[-1].broadphase_pairs == 0  # of the distances that nobody asked for


def test_a_dead_node_is_noticed_by_the_middleware_and_by_the_monitor(client, node):
    missed, died, told = [], [], []
    profile = QoSProfile(
        depth=1,
        deadline=Duration(seconds=DEADLINE),
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(seconds=LEASE),
    )
    callbacks = SubscriptionEventCallbacks(
        deadline=missed.append,
        liveliness=lambda event: died.append(event) if event.alive_count == 0 else None,
    )
    client.node.create_subscription(
        Float64, '/ruled/speed_scale', lambda _: None, profile, event_callbacks=callbacks
    )
    monitor = ProximityMonitor(client.node, '/ruled', rules=[STOP], on_change=told.append)
    assert 'nothing was heard' in monitor.why_stop()
    assert monitor.speed_scale == 0.0
    hand = Hand(client)
    hand.until(1.0, lambda: monitor.speed_scale == 1.0, 'full speed')
    assert monitor.why_stop() == ''
    assert monitor.rules[STOP].pairs == 2
    hand.until(0.0, lambda: monitor.why_stop() == f'{STOP}: near', 'a stop')
    hand.until(1.0, lambda: not monitor.why_stop(), 'the stop to go')
    node.popen.send_signal(signal.SIGKILL)
    client.wait_for(lambda: 'silent' in monitor.why_stop(), 'the monitor to notice')
    client.wait_for(lambda: missed and died, 'the middleware to notice')
    assert 'silent' in told[-1]
    assert monitor.missed == 0


def test_a_monitor_wants_its_rules(client):
    monitor = ProximityMonitor(client.node, '/ruled', rules=['hands of'])
    client.wait_for(lambda: monitor.rules, 'the states')
    assert "no proximity rule 'hands of'; nearest: 'hands off'" in monitor.why_stop()


def test_a_latched_stop_waits_for_somebody_who_saw_it(client):
    rule = msg.ProximityRule(name='latched', set_a=['arm'], set_b=['post'], level=3, leave=0.1)
    rule.enter, rule.acknowledge = 0.05, True
    monitor = ProximityMonitor(client.node, '/ruled', rules=['latched'])
    hand = Hand(client)
    hand.until(1.0, lambda: standing_of(monitor, STOP) == (False, False), 'a pose')
    accepted(client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule))
    hand.until(0.0, lambda: standing_of(monitor, 'latched') == (True, False), 'it to be entered')
    event = monitor.rules['latched'].entered_sequence
    hand.until(1.0, lambda: standing_of(monitor, 'latched') == (True, True), 'its cause to go')
    assert monitor.why_stop() == 'latched: near, to be acknowledged'
    assert monitor.speed_scale == 0.0

    def acknowledge(name, sequence):
        fields = {'name': name, 'sequence': sequence}
        return client.call(srv.AcknowledgeRule, 'acknowledge_rule', **fields)

    refused(acknowledge('latched', event + 1), f'by event {event}')
    refused(acknowledge(STOP, event), 'no key acknowledge')
    refused(acknowledge('latch', event), "nearest: 'latched'")
    assert standing_of(monitor, 'latched') == (True, True)
    future = monitor.acknowledge('latched')
    client.wait_for(future.done, 'the answer')
    accepted(future.result())
    hand.until(1.0, lambda: not monitor.why_stop(), 'it to be left')
    refused(acknowledge('latched', event), 'not entered')
    told = accepted(client.call(srv.ListProximityRules, 'list_proximity_rules')).states
    assert dict(zip(told.rules.name, told.rules.acknowledge, strict=True))['latched']


def standing_of(monitor, name):
    """Return whether a rule is entered, and whether it waits to be acknowledged."""
    rule = monitor.rules.get(name)
    return rule and (rule.entered, rule.awaits_acknowledgement)


def test_a_node_begins_with_its_latched_rules_entered(tmp_path):
    text = SCENE.replace('leave: 0.1}', 'leave: 0.1, acknowledge: true, when_stale: keep}')
    text = text.replace('static: false', 'pose: {position: [1, 0, 0]}')
    (tmp_path / 'cell.yaml').write_text(text)
    process = start_node(tmp_path / 'log', name='again', scene_file=tmp_path / 'cell.yaml')
    client = Client('/again')
    try:
        states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
        awaits = lambda: states and list(states[-1].awaits_acknowledgement) == [True, False]  # noqa: E731
        client.wait_for(awaits, 'the latch')
        assert standing(states)[STOP]
        event = states[-1].entered_sequence[0]
        assert event > 0
        answer = client.call(srv.AcknowledgeRule, 'acknowledge_rule', name=STOP, sequence=event)
        accepted(answer)
        client.wait_for(lambda: not standing(states)[STOP], 'it to be left')
    finally:
        client.close()
        assert process.end() == 0, process.output()
