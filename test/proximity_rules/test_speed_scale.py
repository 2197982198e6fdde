"""The speed scale of one robot: the least of the rules about it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from proximity_rules.monitored import (
    FRESH,
    NAMES,
    NOTHING,
    PATTERNS,
    measured,
    monitor,
    rule,
    scene,
)

from drake_geom_ros.common.geometry_names import matches
from drake_geom_ros.proximity_rules import Level, Poses, RuleError, RuleMonitor


def test_only_the_rules_about_a_robot_scale_it():
    slow = rule('slow', ('right',), level=Level.SLOW, scale=((0.0, 0.0), (0.4, 1.0)))
    watch = monitor(rule('left stands'), slow, rule('warn', ('right',), level=Level.WARN))
    assert watch.scale_about('left')[:2] == (0.0, 'its rules were not decided yet')
    watch.decide(0.0, FRESH, measured((0, 4, 0.05, 0.0), (3, 5, 0.1, 0.0)))
    assert watch.scale_about('left')[:2] == (0.0, "proximity rule 'left stands'")
    assert watch.scale_about('right')[:2] == (pytest.approx(0.25), "proximity rule 'slow'")
    assert watch.scale_about('room').scale == watch.speed_scale() == 0.0
    watch.decide(1.0, FRESH, NOTHING)
    assert watch.scale_about('right')[:2] == (1.0, '')


def test_a_robot_of_which_nothing_is_known_does_not_move():
    watch = monitor(rule('left stands'), rule('warn', ('right',), level=Level.WARN))
    watch.decide(0.0, FRESH, NOTHING)
    assert watch.scale_about('left').scale == 1.0
    assert watch.scale_about('nobody')[:2] == (0.0, "'nobody' stands for no geometry of the scene")
    assert watch.scale_about('right')[:2] == (
        0.0,
        "no proximity rule says how fast 'right' may go",
    )
    stale = Poses(np.array([1, 0, 0, 0, 0, 0], bool), np.zeros(6, bool))
    watch.decide(1.0, stale, NOTHING)
    assert watch.scale_about('left').scale == 0.0


def test_a_rule_whose_robot_has_not_come_yet_is_about_every_robot():
    watch = monitor(rule('left stands'))
    watch.add([rule('later', ('drone',), ('room',))], may_wait=True)
    watch.decide(0.0, FRESH, NOTHING)
    assert watch.scale_about('left')[:2] == (0.0, "proximity rule 'later'")


pairs = st.lists(
    st.tuples(st.tuples(st.integers(0, 5), st.integers(0, 5)), st.floats(0.0, 0.4)), max_size=6
)
rules = st.lists(
    st.tuples(
        st.sampled_from(PATTERNS), st.sampled_from(PATTERNS), st.sampled_from(list(Level)[:3])
    ),
    min_size=1,
    max_size=5,
)


@given(rules, pairs)
def test_it_is_the_scale_of_a_monitor_with_the_rules_about_the_robot_alone(drawn, seen):
    where = scene()
    matrix = where.reported.matrix()
    every, about = RuleMonitor(where), RuleMonitor(where)
    for number, (a, b, level) in enumerate(drawn):
        # A scale of its own: a line would begin at the stop rules, which may be of others.
        scale = ((0.0, 0.1), (0.3, 1.0)) if level == Level.SLOW else ()
        made = rule(f'{number}', (a,), (b,), level=level, scale=scale)
        try:
            every.add([made])
        except RuleError:
            continue
        in_a, in_b = (
            np.array([any(matches(each.found_by, p) for p in [name]) for each in NAMES])
            for name in (a, b)
        )
        watched = (np.outer(in_a, in_b) | np.outer(in_b, in_a)) & matrix
        if watched[[k for k, each in enumerate(NAMES) if each.source == 'left']].any():
            about.add([made])
    rows = [(*pair, distance, 0.0) for pair, distance in seen if matrix[pair]]
    for watch in (every, about):
        watch.decide(0.0, FRESH, measured(*rows) if rows else NOTHING)
    expected = about.speed_scale()
    assert every.scale_about('left').scale == pytest.approx(0.0 if expected is None else expected)
