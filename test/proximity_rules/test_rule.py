"""What a proximity rule may be, and what is said of one that cannot be."""

import math

import pytest

from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError, scale_points


def rule(**changes):
    return ProximityRule(**{'name': 'r', 'set_a': ('a',), 'enter': 0.1, 'leave': 0.2, **changes})


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'name': ''}, 'no name'),
        ({'set_a': ()}, 'set_a is empty'),
        ({'level': 5}, 'level is 5'),
        ({'enter': math.nan}, 'enter=nan'),
        ({'leave': math.inf}, 'leave=inf'),
        ({'leave': 0.1}, 'not greater than enter=0.1'),
        ({'leave': 0.05}, 'not greater than enter=0.1'),
        ({'hold': -1.0}, 'hold is -1.0'),
        ({'enter_after': math.nan}, 'enter_after is nan'),
        ({'min_time_to_contact': math.inf}, 'min_time_to_contact is inf'),
        ({'when_stale': 'stop'}, "when_stale is 'stop'"),
        ({'scale': ((0.0, 0.0), (1.0, 1.0))}, 'this is a STOP rule'),
        ({'margin': 0.1}, 'margin is for stoppable rules'),
        ({'decelerations': (1.0,)}, 'decelerations is for stoppable rules'),
        ({'level': Level.SLOW, 'scale': ((0.0, 0.0),)}, 'two or more'),
        ({'level': Level.SLOW, 'scale': ((0.0, math.nan), (1.0, 1.0))}, 'two or more finite'),
        ({'level': Level.SLOW, 'scale': ((1.0, 0.0), (1.0, 1.0))}, 'must ascend'),
        ({'level': Level.SLOW, 'scale': ((0.0, -0.1), (1.0, 1.0))}, 'from 0 to 1'),
        ({'level': Level.SLOW, 'scale': ((0.0, 1.0), (1.0, 0.5))}, 'nearer must not be faster'),
    ],
)
def test_what_cannot_be_is_refused_by_its_field(changes, told):
    with pytest.raises(RuleError, match=told):
        rule(**changes)


def stoppable(**changes):
    given = {'name': 'r', 'set_a': ('a',), 'level': Level.STOPPABLE, 'decelerations': (2.0,)}
    return ProximityRule(**{**given, **changes})


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'enter': 0.1}, 'enter is for other levels'),
        ({'leave': 0.1}, 'leave is for other levels'),
        ({'min_time_to_contact': 1.0}, 'min_time_to_contact is for other levels'),
        ({'margin': -0.1}, 'margin is -0.1'),
        ({'max_speed': math.inf}, 'max_speed is inf'),
        ({'reaction_time': math.nan}, 'reaction_time is nan'),
        ({'stop_category': 2}, 'stop_category is 2'),
        ({'decelerations': ()}, 'either decelerations or stopping_times'),
        ({'stopping_times': ((1.0, 0.1),)}, 'either decelerations or stopping_times'),
        ({'decelerations': (0.0,)}, 'must be finite and > 0'),
        ({'decelerations': (1.0, 2.0)}, '2 numbers for 0 joint_names'),
        ({'joint_names': ('x', 'x')}, 'nor twice'),
        ({'stopping_times': ((1.0, -0.1),), 'decelerations': ()}, 'must be finite and > 0'),
        ({'stopping_times': ((1.0, 0.1), (1.0, 0.2)), 'decelerations': ()}, 'must ascend'),
        ({'stopping_times': ((1.0, 0.2), (2.0, 0.1)), 'decelerations': ()}, 'not stand sooner'),
    ],
)
def test_an_invalid_braking_is_refused_by_its_field(changes, message):
    with pytest.raises(RuleError, match=message):
        stoppable(**changes)


def test_a_stoppable_rule_has_its_braking_and_needs_no_distance():
    braking = stoppable(reaction_time=0.1, stop_category=0).braking
    assert (braking.reaction_time, braking.category) == (0.1, 0)
    assert stoppable().farthest == -math.inf
    assert stoppable().enters_when_stale
    assert stoppable().stop_category == 1
    assert rule().stop_category == 0


def test_a_stop_enters_when_a_pose_is_stale_unless_it_says_otherwise():
    assert rule().enters_when_stale
    assert not rule(when_stale='keep').enters_when_stale
    assert not rule(level=Level.WARN).enters_when_stale
    assert rule(level=Level.WARN, when_stale='enter').enters_when_stale


def test_a_rule_looks_as_far_as_it_leaves_or_scales():
    assert rule().farthest == 0.2
    assert rule(level=Level.SLOW, scale=((0.0, 0.0), (0.5, 1.0))).farthest == 0.5
    assert rule(level=Level.SLOW, scale=((0.0, 0.0), (0.1, 1.0))).farthest == 0.2


def test_the_points_of_a_scale_come_as_numbers_in_a_row():
    assert scale_points([0, 0.0, 0.5, 1]) == ((0.0, 0.0), (0.5, 1.0))
    assert scale_points([]) == ()
    with pytest.raises(RuleError, match='3 numbers'):
        scale_points([0.0, 0.0, 1.0])
