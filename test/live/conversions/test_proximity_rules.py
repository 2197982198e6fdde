"""Proximity rules as messages: what goes in comes out, and counts that lie are refused."""

import pytest
from drake_geom_msgs import msg
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.live.conversions.proximity_rules import fill_rules, rules_from_message
from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError

seconds = st.floats(0.0, 10.0)
names = st.lists(st.text(min_size=1, max_size=3), max_size=3)
scales = st.lists(st.floats(0.0, 1.0), min_size=2, max_size=4).map(
    lambda values: tuple(enumerate(sorted(values)))
)


@st.composite
def stoppable_rules(draw):
    joints = draw(st.lists(st.text(min_size=1, max_size=3), max_size=3, unique=True))
    count = len(joints) or 1
    accelerations = st.floats(0.1, 10.0)
    times = draw(st.just(()) | st.just(((0.5, 0.1), (1.0, 0.3))))
    each = draw(st.lists(accelerations, min_size=count, max_size=count))
    return ProximityRule(
        draw(st.text(min_size=1, max_size=5)),
        ('a',),
        tuple(draw(names)),
        Level.STOPPABLE,
        acknowledge=draw(st.booleans()),
        joint_names=tuple(joints),
        decelerations=() if times else tuple(each),
        stopping_times=times,
        **{name: draw(seconds) for name in ('hold', 'reaction_time', 'margin', 'max_speed')},
        stop_category=draw(st.sampled_from([0, 1])),
    )


@st.composite
def rules_about_distances(draw):
    level = draw(st.sampled_from([Level.WARN, Level.SLOW, Level.STOP]))
    enter = draw(st.floats(-1.0, 1.0))
    return ProximityRule(
        draw(st.text(min_size=1, max_size=5)),
        ('a', *draw(names)),
        tuple(draw(names)),
        level,
        enter,
        enter + 0.1,
        **{name: draw(seconds) for name in ('hold', 'enter_after', 'min_time_to_contact')},
        when_stale=draw(st.sampled_from(['', 'enter', 'keep'])),
        scale=draw(st.just(()) | scales) if level == Level.SLOW else (),
        acknowledge=draw(st.booleans()),
        min_points=draw(st.integers(1, 9)),
    )


@given(st.lists(rules_about_distances() | stoppable_rules(), max_size=5))
def test_rules_come_back_as_they_were_told(told):
    message = msg.ProximityRules()
    fill_rules(message, told)
    assert rules_from_message(message) == told


@pytest.mark.parametrize(
    'field',
    [*('set_a_count', 'set_b_count', 'scale_count', 'joint_count'), 'stopping_time_count'],
)
@pytest.mark.parametrize('counts', [[], [3], [2, 1], [1, 1, 5]])
def test_counts_that_do_not_fit_are_refused(field, counts):
    message = msg.ProximityRules()
    fill_rules(message, [ProximityRule(f'{k}', ('a',), leave=0.1) for k in range(2)])
    setattr(message, field, counts)
    with pytest.raises(RuleError, match=field):
        rules_from_message(message)
