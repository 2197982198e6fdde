"""Latches of rules: what holds them entered, and what lets them be left."""

import itertools

import numpy as np
import pytest
from proximity_rules.monitored import (
    FRESH,
    NAMES,
    NOTHING,
    measured,
    monitor,
    rule,
    scene,
)

from drake_geom_ros.common.geometry_names import GeometryNames
from drake_geom_ros.proximity_rules import Level, Poses, RuleError, Why

NEAR = measured((0, 4, 0.0, 0.0))
BETWEEN = measured((0, 4, 0.15, 0.0))
STALE = Poses(np.array([1, 0, 0, 0, 0, 0], bool), np.zeros(6, bool))
WITHOUT_LEFT = [each for each in NAMES if each.source != 'left']


def latched(name='r', set_a=('left',), set_b=('room',), **more):
    return rule(name, set_a, set_b, acknowledge=True, **more)


def test_a_latched_rule_is_left_by_nothing_but_its_acknowledgement():
    watch = monitor(latched())
    assert watch.decide(0.0, FRESH, NOTHING) == []
    (entered,) = watch.decide(1.0, FRESH, NEAR)
    assert not watch.states()[0].awaits_acknowledgement  # its cause holds
    assert watch.decide(2.0, FRESH, NOTHING) == []
    assert watch.decide(1e6, FRESH) == []
    (state,) = watch.states()
    assert (state.awaits_acknowledgement, state.entered_sequence) == (True, entered.sequence)
    assert (state.is_entered, state.why, watch.speed_scale()) == (True, Why.NEAR, 0.0)
    assert watch.acknowledge('r', entered.sequence) == []
    assert watch.states()[0].is_entered  # a decision leaves it, and nothing else
    (left,) = watch.decide(1e6, FRESH)
    assert (left.is_entered, left.sequence) == (False, entered.sequence + 1)
    assert watch.speed_scale() == 1.0


def test_an_acknowledgement_overrules_no_cause_that_persists():
    watch = monitor(latched())
    watch.decide(0.0, FRESH, NEAR)
    watch.acknowledge('r', 1)
    for poses, saw in ((FRESH, NEAR), (FRESH, BETWEEN), (STALE, NOTHING)):
        assert watch.decide(1.0, poses, saw) == []
        assert watch.states()[0].is_entered
    (left,) = watch.decide(2.0, FRESH, NOTHING)
    assert not left.is_entered


def test_an_acknowledgement_is_not_remembered_for_a_later_entering():
    watch = monitor(latched())
    with pytest.raises(RuleError, match='not entered'):
        watch.acknowledge('r', 0)
    watch.decide(0.0, FRESH, NEAR)
    watch.acknowledge('r', 1)
    watch.acknowledge('r', 1)  # twice is once
    assert [e.is_entered for e in watch.decide(1.0, FRESH, NOTHING)] == [False]
    (again,) = watch.decide(2.0, FRESH, NEAR)
    assert watch.decide(3.0, FRESH, NOTHING) == []
    with pytest.raises(RuleError, match=f'sequence is 1; .* by event {again.sequence}'):
        watch.acknowledge('r', 1)
    assert watch.states()[0].awaits_acknowledgement


def test_a_cause_that_comes_back_while_the_rule_is_held_is_to_be_acknowledged_anew():
    watch = monitor(latched(hold=10.0))
    watch.decide(0.0, FRESH, NEAR)
    watch.decide(1.0, FRESH, NOTHING)
    watch.acknowledge('r', 1)
    assert watch.decide(2.0, FRESH, BETWEEN) == []  # no cause to enter
    assert watch.decide(3.0, FRESH, NOTHING) == []
    assert not watch.states()[0].awaits_acknowledgement
    watch.decide(4.0, FRESH, NEAR)
    assert watch.decide(20.0, FRESH, NOTHING) == []
    assert watch.states()[0].awaits_acknowledgement
    watch.acknowledge('r', 1)
    assert [e.is_entered for e in watch.decide(20.0, FRESH)] == [False]


def test_what_cannot_be_acknowledged_is_refused_and_nothing_changes():
    watch = monitor(latched(), rule('plain'))
    watch.decide(0.0, FRESH, NEAR)
    before = watch.states()
    for name, sequence, told in (
        ('q', 1, "no proximity rule 'q'"),
        ('plain', 2, 'no key acknowledge'),
        ('r', 2, 'sequence is 2'),
        ('r', 0, 'sequence is 0'),
    ):
        with pytest.raises(RuleError, match=told):
            watch.acknowledge(name, sequence)
    assert watch.states() == before


def test_a_latched_slow_rule_stays_as_slow_as_where_it_was_entered():
    scale = ((0.0, 0.0), (0.2, 1.0))
    watch = monitor(latched(level=Level.SLOW, scale=scale))
    watch.decide(0.0, FRESH, BETWEEN)
    assert watch.speed_scale() == pytest.approx(0.75)
    watch.decide(1.0, FRESH, measured((0, 4, 0.05, 0.0)))
    assert watch.speed_scale() == pytest.approx(0.25)
    watch.decide(2.0, FRESH, NOTHING)
    assert watch.speed_scale() == pytest.approx(0.5)
    watch.acknowledge('r', 1)
    watch.decide(3.0, FRESH)
    assert watch.speed_scale() == 1.0


def test_a_latch_outlives_what_it_is_about_and_the_rule_then_ends_with_its_acknowledgement():
    watch = monitor(latched(), latched('free'))
    watch.decide(0.0, FRESH, NOTHING)
    watch.remove('free')
    (entered,) = watch.decide(0.0, FRESH, NEAR)
    assert watch.bind(scene(names=WITHOUT_LEFT)) == []
    without = Poses(*np.zeros((2, len(WITHOUT_LEFT)), bool))
    assert watch.decide(1.0, without, NOTHING) == []
    assert watch.speed_scale() == 0.0
    (gone,) = watch.acknowledge('r', entered.sequence)
    assert (gone.rule, gone.why) == ('r', Why.GONE)
    assert watch.rules == ()


def test_a_latch_goes_on_where_what_it_is_about_comes_back():
    watch = monitor(latched())
    watch.decide(0.0, FRESH, NEAR)
    watch.bind(scene(names=WITHOUT_LEFT))
    assert watch.bind(scene()) == []
    assert watch.decide(1.0, FRESH, NOTHING) == []
    assert watch.states()[0].awaits_acknowledgement
    watch.acknowledge('r', 1)
    assert [e.is_entered for e in watch.decide(1.0, FRESH)] == [False]


def test_removing_a_rule_ends_its_latch_with_an_event():
    watch = monitor(latched(), rule('plain'), latched('free', ('right',)))
    watch.decide(0.0, FRESH, NEAR)
    assert watch.unacknowledged() == {'r': 1}
    assert [(event.rule, event.why) for event in watch.remove('r')] == [('r', Why.GONE)]
    assert watch.unacknowledged() == {}
    watch.add([latched()])
    assert not watch.states()[-1].is_entered


def test_a_rule_in_the_place_of_a_latched_one_takes_its_latch_over():
    watch = monitor(latched(), rule('plain'), latched('free', ('right',)))
    watch.decide(0.0, FRESH, NEAR)
    new = [latched(enter=0.05), rule('plain', enter=0.05), latched('free', ('right',), enter=0.05)]
    events, troubles = watch.exchange(['r', 'plain', 'free'], new)
    assert [event.rule for event in events] == ['plain', 'free']
    assert troubles == []
    assert watch.decide(1.0, FRESH, NOTHING) == []
    states = {state.rule.name: state for state in watch.states()}
    assert states['r'].rule.enter == 0.05
    assert (states['r'].awaits_acknowledgement, states['r'].entered_sequence) == (True, 1)
    assert not states['free'].is_entered
    events, (told,) = watch.exchange(['r'], [rule()])
    assert [(event.rule, event.why) for event in events] == [('r', Why.GONE)]
    assert "'r' was entered and not acknowledged" in told
    assert not {s.rule.name: s.is_entered for s in watch.states()}['r']


def test_a_process_that_starts_enters_latched_rules_and_no_others():
    watch = monitor(latched(), rule('plain'), latched('warn', level=Level.WARN, hold=3.0))
    watch.begin_entered()
    assert watch.speed_scale() == 0.0
    events = watch.decide(0.0, FRESH, NOTHING)
    assert [(e.rule, e.is_entered, e.why) for e in events] == [
        ('r', True, Why.NO_POSE),
        ('warn', True, Why.NO_POSE),
    ]
    assert watch.decide(1.0, FRESH, NOTHING) == []
    for event in events:
        watch.acknowledge(event.rule, event.sequence)
    assert [e.rule for e in watch.decide(2.0, FRESH)] == ['r']
    assert [e.rule for e in watch.decide(3.0, FRESH)] == ['warn']
    assert watch.decide(4.0, FRESH, NOTHING) == []  # once


def test_the_cause_that_there_is_at_the_start_is_told():
    watch = monitor(latched())
    watch.begin_entered()
    assert [e.why for e in watch.decide(0.0, STALE, NEAR)] == [Why.NEAR]


def test_a_filter_that_hides_all_pairs_does_not_release_a_latch():
    watch = monitor(latched())
    watch.decide(0.0, FRESH, NEAR)
    watch.bind(scene(filtered=list(itertools.combinations(range(6), 2))))
    assert watch.decide(1.0, FRESH, NOTHING) == []
    assert watch.states()[0].awaits_acknowledgement


def test_names_of_a_new_scene_keep_the_states_of_their_rules():
    watch = monitor(latched(), latched('right', ('right',)))
    watch.decide(0.0, FRESH, NEAR)
    names = [*NAMES, GeometryNames('drone', 'body', 'hull', False)]
    watch.bind(scene(names=names))
    states = [(s.is_entered, s.entered_sequence) for s in watch.states()]
    assert states == [(True, 1), (False, 0)]
