"""What rules decide, compared with a referee that decides pair by pair."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
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
from proximity_rules.referee import Referee

from drake_geom_ros.common.geometry_names import GeometryNames, matches
from drake_geom_ros.proximity_rules import (
    Level,
    Poses,
    ProximityRule,
    RuleError,
    RuleMonitor,
    WatchedPairs,
    Why,
    decisions,
    nearest_pairs,
)


def test_a_rule_is_entered_below_enter_and_left_from_leave_on():
    watch = monitor(rule())
    assert watch.decide(0.0, FRESH, measured((0, 4, 0.15, 0.0))) == []
    (event,) = watch.decide(1.0, FRESH, measured((0, 4, 0.3, 0.0), (1, 5, 0.12, 0.03)))
    assert (event.rule, event.level, event.is_entered, event.why) == (
        *('r', Level.STOP, True, Why.NEAR),
    )
    assert (event.id_A, event.id_B, event.distance, event.error_bound) == (12, 16, 0.12, 0.03)
    assert event.p_WCa.tolist() == [3.0, 4.0, 5.0]
    assert watch.decide(2.0, FRESH, measured((1, 5, 0.19, 0.0))) == []
    (event,) = watch.decide(3.0, FRESH, measured((1, 5, 0.25, 0.05)))
    assert (event.sequence, event.is_entered, event.why) == (2, False, Why.NEAR)


def test_the_lower_bound_decides_and_not_the_distance():
    watch = monitor(rule(enter=0.125))
    assert watch.decide(0.0, FRESH, measured((0, 4, 0.5, 0.375))) == []
    assert len(watch.decide(0.0, FRESH, measured((0, 4, 0.5, np.nextafter(0.375, 1))))) == 1


def test_what_is_not_a_number_is_not_free():
    watch = monitor(rule())
    (event,) = watch.decide(0.0, FRESH, measured((0, 4, math.nan, 0.0)))
    assert event.why == Why.NEAR


def test_a_rule_that_held_its_time_is_left_and_not_before():
    watch = monitor(rule(hold=1.0, enter_after=0.5))
    near, far = measured((0, 4, 0.0, 0.0)), measured((0, 4, 1.0, 0.0))
    assert not watch.decide(0.0, FRESH, near)
    assert not watch.decide(0.4, FRESH, far)  # a break: the time begins anew
    assert not watch.decide(0.6, FRESH, near)
    assert not watch.decide(1.0, FRESH)
    assert len(watch.decide(1.1, FRESH)) == 1
    assert not watch.decide(2.0, FRESH, far)
    assert len(watch.decide(2.1, FRESH)) == 1


def test_what_closes_fast_is_soon_though_it_is_far():
    watch = monitor(rule(min_time_to_contact=2.0))
    assert watch.farthest(fastest=3.0) == 6.0
    assert watch.farthest() == 0.2
    assert not watch.decide(0.0, FRESH, measured((0, 4, 5.0, 0.0), speeds=[2.5]))
    assert not watch.decide(0.0, FRESH, measured((0, 4, 5.0, 0.0), speeds=[-9.0]))
    assert not watch.decide(0.0, FRESH, measured((0, 4, 5.0, 0.0), speeds=[math.nan]))
    pairs = measured((1, 4, 4.0, 0.0), (0, 4, 5.0, 0.1), speeds=[0.1, 2.5])
    (event,) = watch.decide(0.0, FRESH, pairs)
    assert (event.why, event.id_A) == (Why.SOON, 11)


def test_what_closed_fast_is_not_free_where_nobody_knows_any_more_how_it_moves():
    watch = monitor(rule('timed', min_time_to_contact=2.0), rule('other', enter=5.0, leave=5.5))
    pairs = measured((0, 4, 4.0, 0.0), speeds=[4.0])
    assert [e.why for e in watch.decide(0.0, FRESH, pairs)] == [Why.SOON, Why.NEAR]
    lost = np.array([1, 0, 0, 0, 0, 0], bool)
    (left,) = watch.decide(1.0, FRESH, NOTHING._replace(unpredicted=lost))
    assert left.rule == 'other'
    assert watch.decide(2.0, FRESH) == []
    elsewhere = np.array([0, 0, 0, 1, 0, 0], bool)
    (left,) = watch.decide(3.0, FRESH, NOTHING._replace(unpredicted=elsewhere))
    assert left.rule == 'timed'


def test_a_stale_pose_enters_a_stop_and_keeps_what_is_entered():
    stop, warn = rule('stop'), rule('warn', level=Level.WARN)
    watch = monitor(stop, warn)
    stale = Poses(np.array([0, 1, 0, 0, 0, 0], bool), np.zeros(6, bool))
    (event,) = watch.decide(0.0, stale, NOTHING)
    assert (event.rule, event.why, event.id_A) == ('stop', Why.STALE, 12)
    assert math.isnan(event.distance)
    events = watch.decide(1.0, stale, measured((0, 4, 0.0, 0.0)))
    assert [e.rule for e in events] == ['warn']
    assert watch.decide(2.0, stale, NOTHING) == []  # neither is left blindly
    assert [e.is_entered for e in watch.decide(3.0, FRESH, NOTHING)] == [False, False]


@pytest.mark.parametrize(
    ('field', 'why'),
    [('contested', Why.TWO_SENDERS), ('foreign', Why.OTHER_CLOCK)],
)
def test_poses_that_are_not_to_be_trusted_enter_rules_with_a_reason_of_their_own(field, why):
    stop, slow = rule('stop'), rule('slow', level=Level.SLOW)
    watch = monitor(stop, slow, rule('warn', level=Level.WARN))
    doubted = FRESH._replace(**{field: np.array([0, 1, 0, 0, 0, 0], bool)})
    watch.decide(0.0, FRESH, NOTHING)
    events = watch.decide(1.0, doubted)
    assert [(e.rule, e.why, e.id_A) for e in events] == [('stop', why, 12), ('slow', why, 12)]
    assert watch.speed_scale() == 0.0
    assert [e.is_entered for e in watch.decide(2.0, FRESH)] == [False, False]
    assert watch.speed_scale() == 1.0


def test_a_slow_rule_alone_has_its_least_scale_while_a_pose_is_stale_unless_it_keeps():
    stale = Poses(np.array([0, 1, 0, 0, 0, 0], bool), np.zeros(6, bool))
    for when_stale, least in (('', 0.2), ('enter', 0.2), ('keep', 1.0)):
        scale = ((0.1, 0.2), (0.5, 1.0))
        watch = monitor(rule(level=Level.SLOW, scale=scale, when_stale=when_stale))
        watch.decide(0.0, FRESH, NOTHING)
        assert watch.speed_scale() == 1.0
        watch.decide(1.0, stale)
        assert watch.speed_scale() == least


def test_the_reason_follows_when_what_holds_a_rule_entered_changes():
    watch = monitor(rule(enter_after=5.0))
    absent = Poses(np.zeros(6, bool), np.array([1, 0, 0, 0, 0, 0], bool))
    stale = Poses(np.array([1, 0, 0, 0, 0, 0], bool), np.zeros(6, bool))
    (event,) = watch.decide(0.0, absent, NOTHING)
    changes = watch.changes_of_state
    between = measured((0, 4, 0.15, 0.0))
    assert (event.why, watch.decide(1.0, FRESH, between)) == (Why.NO_POSE, [])
    assert watch.states()[0].why == Why.NEAR
    assert watch.changes_of_state == changes + 1
    watch.decide(2.0, stale)
    assert watch.states()[0].why == Why.STALE
    watch.decide(3.0, FRESH)
    assert watch.states()[0].why == Why.NEAR
    assert watch.changes_of_state == changes + 3
    watch.decide(4.0, FRESH)
    assert watch.changes_of_state == changes + 3


def test_a_pose_that_no_pair_needs_may_be_stale():
    watch = monitor(rule(set_b=('right',)))
    stale = Poses(np.array([0, 0, 0, 0, 1, 0], bool), np.zeros(6, bool))
    assert watch.decide(0.0, stale, NOTHING) == []
    absent = Poses(np.zeros(6, bool), np.array([0, 0, 0, 1, 0, 0], bool))
    (event,) = watch.decide(0.0, absent, NOTHING)
    assert event.why == Why.NO_POSE


def test_filtered_pairs_are_counted():
    watch = monitor(rule(set_a=('left::hand',), set_b=('room',)), filtered=[(0, 4)])
    (state,) = watch.states()
    assert (state.pairs, state.left_out, state.trouble) == (3, 1, '')


@pytest.mark.parametrize(
    ('sets', 'told'),
    [
        ((('lefd',), ('room',)), "'lefd' stands for no geometry.*nearest: 'left'"),
        ((('left',), ('rom',)), "'rom' stands for no geometry"),
        ((('table',), ('wall',)), 'could never be entered: of its 1 pair none'),
        ((('table',), ('table',)), 'two sets have no pair'),
        ((('*',), ()), 'two sets have no pair'),
    ],
)
def test_a_rule_that_no_pair_can_satisfy_is_refused(sets, told):
    watch = monitor(rule('first'))
    with pytest.raises(RuleError, match=told):
        watch.add([rule('good'), rule('bad', *sets)])
    assert [r.name for r in watch.rules] == ['first']
    assert watch.add([rule('bad', *sets)], may_wait=True)
    assert len(watch.rules) == 2


def test_a_rule_waits_for_what_it_names_and_a_stop_stands_meanwhile():
    watch = monitor(rule('room'))
    (told,) = watch.add([rule('later', ('drone',), ('room',))], may_wait=True)
    assert 'drone' in told
    (event,) = watch.decide(0.0, FRESH, NOTHING)
    assert (event.rule, event.why, event.id_A) == ('later', Why.NO_POSE, 0)
    assert watch.speed_scale() == 0.0
    names = [*NAMES, GeometryNames('drone', 'body', 'hull', False)]
    assert watch.bind(scene(names=names)) == []
    fresh = Poses(np.zeros(7, bool), np.zeros(7, bool))
    (event,) = watch.decide(1.0, fresh, NOTHING)
    assert (event.rule, event.is_entered) == ('later', False)


def test_what_is_gone_ends_its_rules_with_an_event_and_filters_end_none():
    watch = monitor(rule('stay'), rule('go', ('right',), ('room',)))
    all_pairs = list(itertools.combinations(range(6), 2))
    assert watch.bind(scene(filtered=all_pairs)) == []
    assert all('could never be entered' in state.trouble for state in watch.states())
    (event,) = watch.bind(scene(names=[n for n in NAMES if n.source != 'right']))
    assert (event.rule, event.is_entered, event.why) == ('go', False, Why.GONE)
    assert [r.name for r in watch.rules] == ['stay']


def test_names_are_taken_once_and_removing_tells_who_was_entered():
    watch = monitor(rule('a'), rule('b', enter=-1.0))
    with pytest.raises(RuleError, match="rule 'a' already"):
        watch.add([rule('a')])
    with pytest.raises(RuleError, match="no proximity rule 'c'"):
        watch.remove('c')
    watch.decide(0.0, FRESH, measured((0, 4, 0.0, 0.0)))
    (event,) = watch.remove('a')
    assert (event.sequence, event.rule, event.is_entered, event.why) == (2, 'a', False, Why.GONE)
    # Who was not entered is told of, too: who listens for it must not wait for ever.
    assert [(e.sequence, e.why) for e in watch.remove('b')] == [(3, Why.GONE)]
    assert watch.rules == ()
    assert watch.next_sequence == 4


def test_a_stale_pose_enters_at_once_though_a_pair_was_not_near_for_long():
    watch = monitor(rule(enter_after=5.0))
    stale = Poses(np.array([1, 0, 0, 0, 0, 0], bool), np.zeros(6, bool))
    (event,) = watch.decide(0.0, stale, measured((1, 4, 0.0, 0.0)))
    assert (event.is_entered, event.why, event.id_A) == (True, Why.STALE, 11)


def test_a_pair_that_was_near_for_long_enough_is_told_though_nothing_is_measured_then():
    watch = monitor(rule(enter_after=0.5, hold=2.0))
    assert not watch.decide(0.0, FRESH, measured((0, 4, 0.05, 0.01)))
    (event,) = watch.decide(0.6, FRESH)
    assert (event.id_A, event.id_B, event.distance, event.error_bound) == (11, 15, 0.05, 0.01)
    assert event.p_WCa.tolist() == [0.0, 1.0, 2.0]
    assert not watch.decide(1.0, FRESH, measured((0, 4, 0.25, 0.0)))
    (event,) = watch.decide(2.7, FRESH)
    assert (event.is_entered, event.distance) == (False, 0.25)


def test_an_event_bears_what_its_bound_was_held_against():
    watch = monitor(rule(min_time_to_contact=0.5))
    (event,) = watch.decide(0.0, FRESH, measured((0, 4, 0.3, 0.0), speeds=[1.0]))
    assert (event.why, event.closing_speed) == (Why.SOON, 1.0)
    assert (event.limit_distance, event.limit_time) == (0.1, 0.5)
    (event,) = watch.decide(1.0, FRESH, measured((0, 4, 0.3, 0.0), speeds=[-1.0]))
    assert (event.is_entered, event.limit_distance) == (False, 0.2)


def test_a_rule_goes_on_with_what_is_left_of_what_it_names():
    watch = monitor(rule('both', ('left',), ('right', 'table')))
    without = scene(names=[n for n in NAMES if n.name != 'table'])
    assert watch.bind(without) == []
    (state,) = watch.states()
    assert (state.pairs, state.trouble) == (3, '')
    watch.bind(scene())
    assert watch.states()[0].pairs == 6
    watch.bind(without)
    (event,) = watch.bind(scene(names=[n for n in NAMES if n.source == 'left']))
    assert (event.rule, event.why) == ('both', Why.GONE)


def test_states_are_kept_when_other_rules_come_and_go():
    watch = monitor(rule('a', enter=-1.0), rule('b'))
    watch.decide(3.0, FRESH, measured((0, 4, 0.0, 0.0)))
    watch.remove('a')
    watch.add([rule('c', enter=-1.0)])
    watch.bind(scene())
    told = {state.rule.name: (state.is_entered, state.since) for state in watch.states()}
    assert told == {'b': (True, 3.0), 'c': (False, -math.inf)}


def test_nothing_is_left_before_anything_was_measured():
    watch = monitor(rule())
    watch.decide(0.0, FRESH, measured((0, 4, 0.0, 0.0)))
    watch.bind(scene())
    assert watch.decide(1.0, FRESH) == []
    assert watch.states()[0].is_entered


def test_speed_is_scaled_between_the_stop_and_the_end_of_slow():
    stop = rule('stop', enter=0.05, leave=0.08)
    slow = rule('slow', level=Level.SLOW, enter=0.2, leave=0.25)
    watch = monitor(stop, slow)
    assert watch.speed_scale() == 0.0  # nothing is known yet
    expected = {1.0: 1.0, 0.25: 1.0, 0.15: 0.5, 0.09: 0.2, 0.04: 0.0, 0.06: 0.0, 0.08: 0.15}
    for now, (distance, scale) in enumerate(expected.items()):
        watch.decide(float(now), FRESH, measured((0, 4, distance, 0.0)))
        assert watch.speed_scale() == pytest.approx(scale)


def test_speed_is_scaled_as_a_rule_says_and_by_the_time_that_is_left():
    points = ((0.1, 0.2), (0.3, 0.4), (0.5, 1.0))
    slow = rule('slow', level=Level.SLOW, scale=points, min_time_to_contact=2.0)
    watch = monitor(slow)
    watch.decide(0.0, FRESH, measured((0, 4, 0.4, 0.0)))
    assert watch.speed_scale() == pytest.approx(0.7)
    watch.decide(1.0, FRESH, measured((0, 4, 0.4, 0.0), speeds=[0.4]))
    assert watch.speed_scale() == pytest.approx(0.5)
    watch.decide(2.0, FRESH, measured((0, 4, 0.0, 0.0), speeds=[-1.0]))
    assert watch.speed_scale() == pytest.approx(0.2)


def test_speed_is_the_least_where_a_pose_never_came():
    slow = rule('slow', level=Level.SLOW, scale=((0.1, 0.2), (0.5, 1.0)))
    watch = monitor(slow)
    absent = Poses(np.zeros(6, bool), np.array([1, 0, 0, 0, 0, 0], bool))
    (event,) = watch.decide(0.0, absent, NOTHING)
    assert event.why == Why.NO_POSE
    assert watch.speed_scale() == 0.2
    watch.decide(1.0, FRESH, NOTHING)
    assert watch.speed_scale() == 1.0


def test_without_a_rule_that_scales_nothing_is_said_of_speed():
    assert monitor(rule(level=Level.WARN)).speed_scale() is None
    assert RuleMonitor(scene()).speed_scale() is None


def test_a_pair_of_another_scene_is_no_pair_of_no_rule():
    watch = monitor(rule())
    with pytest.raises(ValueError, match=r'pair \(11, 17\) is not of the scene'):
        watch.decide(0.0, FRESH, measured((0, 6, 0.15, 0.0)))


def test_one_compiled_version_serves_all_rules():
    for count in (1, 7):
        watch = monitor(*(rule(f'{k}', (PATTERNS[k],), ('*',)) for k in range(count)))
        for saw in (NOTHING, measured((0, 4, 0.15, 0.0)), measured((0, 4, 1, 0), (1, 4, 1, 0))):
            watch.decide(0.0, FRESH, saw)
    for decides in (nearest_pairs._FIND.call, decisions.step, decisions.take_nearest):
        assert len(getattr(decides, 'signatures', [0])) == 1  # no cycle waits for another


@given(st.text('hand*?l/:[]', min_size=1, max_size=6) | st.sampled_from(PATTERNS))
def test_a_set_is_all_that_its_pattern_matches(pattern):
    watched = WatchedPairs([rule(set_a=(pattern,), set_b=('*',))], scene())
    found = [matches(names.found_by, pattern) for names in NAMES]
    assert bool(watched.unknown[0]) == (not any(found))
    if any(found):
        assert (mask(watched) == np.logical_or.outer(found, found)).all()


def mask(watched):
    """Return the pairs that rules watch as a matrix (n, n)."""
    pairs = watched.watched()
    return pairs.watched[np.ix_(pairs.kinds, pairs.kinds)]


sets = st.lists(st.sampled_from(PATTERNS), min_size=1, max_size=2)


@given(st.lists(st.tuples(sets, sets | st.just([])), min_size=1, max_size=9), st.data())
def test_pairs_by_kinds_are_those_of_each_rule_pair_by_pair(drawn, data):
    filtered = data.draw(st.sets(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=4))
    where = scene(filtered)
    rules = [rule(f'{k}', tuple(a), tuple(b)) for k, (a, b) in enumerate(drawn)]
    watched = WatchedPairs(rules, where)
    expected = np.zeros((6, 6), dtype=bool)
    for number, each in enumerate(rules):
        sides = [
            np.array([any(matches(names.found_by, p) for p in patterns) for names in NAMES])
            for patterns in (each.set_a, each.set_b)
        ]
        in_a, in_b = sides if each.set_b else (sides[0], ~sides[0])
        one_way = np.logical_and.outer(in_a, in_b)
        pairs = (one_way | one_way.T) & ~np.eye(6, dtype=bool)
        of_rule = pairs & where.reported.matrix()
        assert watched.pairs[number] == of_rule.sum() // 2
        assert watched.left_out[number] == pairs.sum() // 2 - of_rule.sum() // 2
        assert watched.needed(number).tolist() == of_rule.any(axis=0).tolist()
        watches = watched.watches(watched.groups[number], np.arange(6), np.arange(6))
        assert (watches == (one_way | one_way.T)).all()
        expected |= watches
    assert (mask(watched) == expected).all()


def test_bits_of_many_rules_are_told_apart():
    many = [rule(f'{k}', ('right',) if k % 3 else ('arm',), ('table',)) for k in range(130)]
    watch = monitor(*many)
    events = watch.decide(0.0, FRESH, measured((3, 4, 0.0, 0.0)))
    assert [e.rule for e in events] == [f'{k}' for k in range(130) if k % 3]


numbers = st.floats(0.0, 0.4)
drawn_rules = st.builds(
    lambda a, b, level, enter, room, times, stale, acknowledge: {
        'set_a': tuple(a),
        'set_b': tuple(b),
        'level': level,
        'enter': enter,
        'leave': enter + room,
        'hold': times[0],
        'enter_after': times[1],
        'min_time_to_contact': times[2],
        'when_stale': stale,
        'acknowledge': acknowledge,
    },
    st.lists(st.sampled_from(PATTERNS), min_size=1, max_size=2),
    st.lists(st.sampled_from(PATTERNS), max_size=2),
    st.sampled_from([Level.WARN, Level.SLOW, Level.STOP]),
    numbers,
    st.floats(0.01, 0.2),
    st.tuples(*[st.sampled_from([0.0, 0.0, 0.5, 1.5])] * 3),
    st.sampled_from(['', 'enter', 'keep']),
    st.booleans(),
)
pair = st.tuples(
    st.tuples(st.integers(0, 5), st.integers(0, 5)),
    numbers,
    st.floats(0.0, 0.1),
    st.sampled_from([math.nan, -1.0, 0.0, 0.1, 1.0]),
)
cycles = st.tuples(
    st.sampled_from([0.1, 0.4, 1.0]),  # seconds since the one before
    st.lists(pair, max_size=6),
    st.sets(st.integers(0, 3), max_size=2),
    st.sets(st.integers(0, 3), max_size=1),
    st.sets(st.integers(0, 3), max_size=1),
    st.lists(st.tuples(st.integers(0, 4), st.integers(0, 1)), max_size=4),  # acknowledged
)


def acknowledge(watch, referee, off):
    """Acknowledge the last entering of a rule, or one that is ``off`` by a number."""
    sequence = referee.sequence + off
    if referee.acknowledge(sequence):
        assert watch.acknowledge(referee.rule.name, sequence) == []
        return
    before = watch.states()
    with pytest.raises(RuleError):
        watch.acknowledge(referee.rule.name, sequence)
    assert watch.states() == before


@settings(max_examples=300, deadline=None)
@given(st.lists(drawn_rules, min_size=1, max_size=5), st.lists(cycles, max_size=8), st.data())
def test_a_referee_finds_every_decision_and_no_other(rules, story, data):
    drawn = data.draw(st.sets(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=4))
    where = scene(filtered=drawn)

    def members(pattern):
        return {k for k, names in enumerate(NAMES) if matches(names.found_by, pattern)}

    watch, referees = RuleMonitor(where), []
    for number, fields in enumerate(rules):
        made = ProximityRule(str(number), **fields)
        referee = Referee(made, members)
        matrix = where.reported.matrix()
        reported = list(zip(*np.nonzero(matrix), strict=True))
        if any(referee.concerns(*p) for p in reported):
            watch.add([made])
            referees.append(referee)
        else:
            with pytest.raises(RuleError):
                watch.add([made])
    now, sequence = 0.0, 1
    for seconds, pairs, stale, absent, lost, acknowledged in story:
        now += seconds
        for number, off in acknowledged:
            acknowledge(watch, referees[number % len(referees)], off) if referees else None
        seen = [p for p in pairs if matrix[p[0]]]
        args = [(*p[0], p[1], p[2]) for p in seen]
        speeds = [p[3] for p in seen]
        saw = measured(*args, speeds=speeds) if seen else NOTHING
        saw = saw._replace(unpredicted=np.isin(np.arange(6), list(lost)))
        flags = np.isin(np.arange(6), list(stale)), np.isin(np.arange(6), list(absent))
        events = watch.decide(now, Poses(*flags), saw)
        of_referee = [
            r.rule.name
            for r in referees
            if r.look(
                now, [(a, b, d - e, s) for (a, b, d, e), s in zip(args, speeds, strict=True)],
                reported, stale, absent, lost,
            )
        ]  # fmt: skip
        assert [e.rule for e in events] == of_referee
        entered = {r.rule.name: r.is_entered for r in referees}
        assert all(e.is_entered == entered[e.rule] for e in events)
        for event, referee in itertools.product(events, referees):
            if event.is_entered and event.rule == referee.rule.name:
                referee.sequence = event.sequence
        states = [(s.awaits_acknowledgement, s.entered_sequence) for s in watch.states()]
        assert states == [(r.awaits, r.sequence) for r in referees]
        assert [e.sequence for e in events] == list(range(sequence, sequence + len(events)))
        sequence += len(events)


def test_slow_rules_are_held_against_groups_of_stop_rules_and_not_against_each(monkeypatch):
    looked_at = []
    shared = WatchedPairs.greatest_shared

    def counted(self, numbers, others, values):
        found = shared(self, numbers, others, values)
        looked_at.append((len(numbers), len(others), len(np.unique(self.groups))))
        return found

    monkeypatch.setattr(WatchedPairs, 'greatest_shared', counted)
    levels = (Level.SLOW, Level.STOP)
    many = [rule(f'{k}', level=levels[k % 2], enter=0.01 + 1e-5 * k) for k in range(600)]
    watch = monitor(*many)
    assert looked_at[-1] == (300, 300, 1)
    watch.decide(0.0, FRESH, measured((0, 4, 0.17, 0.0)))
    nearest_stop = max(each.enter for each in many if each.level == Level.STOP)
    slowest = (0.17 - nearest_stop) / (0.2 - nearest_stop)
    assert watch.speed_scale() == pytest.approx(slowest)


@given(st.lists(st.tuples(st.sampled_from(PATTERNS), st.sampled_from(PATTERNS)), min_size=2))
def test_the_greatest_enter_of_what_shares_a_pair_is_that_of_all_pairs_of_rules(sets):
    rules = [rule(f'{k}', (a,), (b,), enter=0.001 * k) for k, (a, b) in enumerate(sets)]
    where, half = scene(), len(sets) // 2
    watched = WatchedPairs(rules, where)
    found = watched.greatest_shared(
        range(half), range(half, len(rules)), np.array([r.enter for r in rules[half:]])
    )

    def members(patterns):
        return {
            k
            for k, names in enumerate(where.geometries.names)
            if any(matches(names.found_by, p) for p in patterns)
        }

    for k in range(half):
        a, b = members(rules[k].set_a), members(rules[k].set_b)
        shared = [
            other.enter
            for other in rules[half:]
            for c, d in [(members(other.set_a), members(other.set_b))]
            if (a & c and b & d) or (a & d and b & c)
        ]
        assert found[k] == max(shared, default=0.0)


def test_nearest_points_are_those_of_the_lowest_bound_and_none_before():
    watch = monitor(rule())
    assert watch.nearest_points() == [None]
    before = watch.measurement
    seen = measured((0, 4, 0.3, 0.0), (1, 5, 0.31, 0.05))
    seen = seen._replace(p_WCa=np.arange(6.0).reshape(2, 3), p_WCb=-np.arange(6.0).reshape(2, 3))
    watch.decide(0.0, FRESH, seen)
    assert watch.measurement is not before
    ((p_WCa, p_WCb),) = watch.nearest_points()
    assert (p_WCa.tolist(), p_WCb.tolist()) == ([3.0, 4.0, 5.0], [-3.0, -4.0, -5.0])
    watch.decide(1.0, FRESH, NOTHING)
    assert watch.nearest_points() == [None]
