"""What a ProximityMonitor makes of what comes, in whatever order; without a node."""

import pytest
from drake_geom_msgs import msg
from std_msgs.msg import Float64

from drake_geom_ros.client import ProximityMonitor


class Node:
    """Keeps what is to be called, by the end of the topic's name."""

    def __init__(self):
        self.hears = {}

    def create_subscription(self, kind, topic, hear, profile):
        self.hears[topic.rpartition('/')[2]] = hear

    def create_timer(self, period, look, clock):
        pass


def events(*sequence, entered=True, version=0):
    n = len(sequence)
    message = msg.ProximityEvents(sequence=sequence, rule=['stop'] * n, level=[3] * n)
    message.entered, message.why = [entered] * n, [1] * n
    message.scene_version = version
    message.geometry_a = message.geometry_b = [''] * n
    message.id_a = message.id_b = [0] * n
    numbers = ('distance', 'error_bound', 'closing_speed', 'limit_distance', 'limit_time')
    for field in (*numbers, 'oldest_pose_age'):
        setattr(message, field, [0.0] * n)
    message.p_wca = message.p_wcb = [0.0] * (3 * n)
    message.pose_a = message.pose_b = [0.0] * (7 * n)
    return message


def states(next_sequence, *entered, version=0):
    """Return the states of so many rules, the first of them called as that of the events."""
    n, message = len(entered), msg.ProximityStates(next_sequence=next_sequence)
    names = ['stop', 'other', 'third'][:n]
    message.rules = msg.ProximityRules(name=names, level=[3] * len(names))
    message.entered, message.why = list(entered), [int(each) for each in entered]
    message.since = [0.0] * n
    message.pairs = message.left_out_pairs = [1] * n
    message.trouble, message.scene_version = [''] * n, version
    message.awaits_acknowledgement, message.entered_sequence = [False] * n, [0] * n
    return message


@pytest.mark.parametrize(
    ('heard', 'missed'),
    [
        ([states(1), events(1, 2), events(3)], 0),
        ([states(5), events(5)], 0),
        ([states(1), events(3)], 2),
        ([states(1), events(1), events(4)], 2),
        # Topics have no common order: states of before may come after events.
        ([states(1), events(1), events(2), states(2), events(3)], 0),
        ([events(7), states(7), states(8), events(8)], 0),
        # A node that began anew counts from 1.
        ([states(9), events(9), states(1), events(1)], 0),
        ([states(9), events(9), events(1), states(1), events(2)], 0),
        ([states(9), events(9), states(1), events(2)], 1),
    ],
)
def test_what_was_missed_is_counted(heard, missed):
    node, got = Node(), []
    monitor = ProximityMonitor(node, on_event=lambda event: got.append(event.sequence))
    for message in heard:
        is_states = isinstance(message, msg.ProximityStates)
        node.hears['proximity_states' if is_states else 'proximity_events'](message)
    assert monitor.missed == missed
    assert got == [n for m in heard if isinstance(m, msg.ProximityEvents) for n in m.sequence]


@pytest.mark.parametrize(
    ('heard', 'entered'),
    [
        ([states(1, False), events(1)], {'stop': True}),
        ([states(1, False), events(1), states(2, True)], {'stop': True}),
        ([states(1, False, True), events(1), states(1, False)], {'stop': True, 'other': True}),
        ([states(1, True), events(1, entered=False)], {'stop': False}),
        ([states(1), events(1)], {'stop': True}),  # one that the states do not know yet
        ([events(1), states(1, False)], {}),  # states follow events that they do not know
        ([states(3, True), events(3, 4, entered=False), states(4, True)], {'stop': False}),
        # A node that began anew, whose number is among those of the dead one, has a later scene.
        ([states(3, False), events(3, 4), states(4, False, version=1)], {'stop': False}),
    ],
)
def test_events_are_known_before_states_say_so(heard, entered):
    node = Node()
    monitor = ProximityMonitor(node)
    for message in heard:
        is_states = isinstance(message, msg.ProximityStates)
        node.hears['proximity_states' if is_states else 'proximity_events'](message)
    assert {name: rule.entered for name, rule in monitor.rules.items()} == entered
    assert ('stop: near' in monitor.why_stop()) == entered.get('stop', False)


@pytest.mark.parametrize('waits', [False, True])
def test_a_stoppable_rule_asks_for_less_speed_and_a_latched_one_for_rest(waits):
    node = Node()
    monitor = ProximityMonitor(node)
    message = states(2, True)
    message.rules.level = [msg.ProximityRule.STOPPABLE]
    message.why, message.awaits_acknowledgement = [msg.ProximityEvents.CANNOT_STOP], [waits]
    node.hears['proximity_states'](message)
    node.hears['speed_scale'](Float64(data=0.4))
    assert monitor.why_stop() == ('stop: cannot stop, to be acknowledged' if waits else '')
    assert monitor.speed_scale == (0.0 if waits else 0.4)
