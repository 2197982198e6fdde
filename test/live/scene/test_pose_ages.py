"""How old the poses of frames are."""

import math
from types import SimpleNamespace as Plain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks
from drake_geom_ros.live.scene.pose_ages import PoseAges

WORLD, A, B = (FrameId.get_new_id() for _ in range(3))


def table_of(**frames):
    """Return what a table of names says of the world and of frames by name."""
    names = {frame: name for name, frame in frames.items()}
    values = tuple(frame.get_value() for frame in names)
    return Plain(world=WORLD, frame_names={WORLD: 'world', **names}, frame_values=values)


NAMES = table_of(**{'s::a': A, 's::b': B})


@pytest.fixture
def clocks(clock):
    return Clocks(clock, clock)


@pytest.fixture
def ages(clocks):
    return PoseAges(clocks)


@pytest.fixture
def note(ages, clocks):
    """Return a function that notes a stamp for frames, and returns the newest one."""

    def note(stamp, *frames):
        sec, nanosec = int(stamp), round(stamp % 1 * 1e9)
        since = clocks.arrival().since(stamp)
        posed = frozenset(frame.get_value() for frame in frames)
        told = Plain(sec=sec, nanosec=nanosec)
        ages.note(ages.posed_by(posed, since, told), told)
        return ages.newest_stamp.sec + 1e-9 * ages.newest_stamp.nanosec

    return note


def test_ages_count_from_the_last_pose(ages, clock, note):
    note(99.0, A)
    note(100.0, B)
    clock.now += 2.0
    assert ages.by_name(NAMES) == {'s::a': 3.0, 's::b': 2.0}
    assert ages.oldest(NAMES).age == 3.0
    note(102.0, A)
    assert ages.oldest(NAMES).age == 2.0


def test_a_frame_that_was_never_posed_is_infinitely_old(ages, note):
    note(100.0, A)
    assert ages.by_name(NAMES) == {'s::a': 0.0, 's::b': math.inf}
    assert ages.oldest(NAMES).age == math.inf
    assert ages.unknown(NAMES) == []


def test_what_is_older_or_waits_is_found_whatever_was_asked_before(ages, clock, note):
    a, b = A.get_value(), B.get_value()
    assert ages.older_than(1.0, NAMES) == {a, b}
    assert ages.older_than(1.0, NAMES) is ages.older_than(2.0, NAMES)
    assert ages.older_than(1.0, table_of()) == set()
    note(100.0, A)
    assert ages.older_than(1.0, NAMES) == {b}
    clock.now += 2.0
    assert ages.older_than(1.0, NAMES) == {a, b}
    assert ages.older_than(3.0, NAMES) == {b}
    note(102.0, A, B)
    assert ages.older_than(1.0, NAMES) == set()
    ages.wait([a])
    assert ages.older_than(1.0, NAMES) == {a}
    ages.forget([b])
    assert ages.older_than(1.0, NAMES) == {a, b}
    assert ages.older_than(1.0, table_of(**{'s::b': B})) == {b}


def test_what_holds_for_ever_is_new(ages, note):
    note(100.0, B)
    ages.note({frozenset([A.get_value()]): ALWAYS}, Plain(sec=1, nanosec=0))
    assert ages.by_name(NAMES) == {'s::a': 0.0, 's::b': 0.0}
    assert ages.oldest(NAMES).age == 0.0


def test_without_frames_nothing_is_old(ages):
    assert ages.oldest(table_of()).age == 0.0


def test_the_newest_stamp_is_that_of_the_newest_pose_whoever_came_last(ages, note):
    assert ages.newest_stamp is None
    assert note(7.5, A) == 7.5
    assert note(3, B) == 7.5
    assert note(7.625, B) == 7.625
    assert note(9, A) == 9
    # The sender's time has gone back: the pose of 9 s is not there any more.
    assert note(2, A) == 7.625
    assert note(1, B) == 2


def test_after_a_jump_of_the_clock_what_is_of_before_has_no_age_and_no_say(
    ages, clocks, clock, note
):
    note(100.0, A, B)
    clock.now = 10.0
    clocks.begin_anew()
    assert ages.by_name(NAMES) == {'s::a': math.inf, 's::b': math.inf}
    assert ages.unknown(NAMES) == ['s::a', 's::b']
    assert note(10.0, A) == 10.0
    assert ages.unknown(NAMES) == ['s::b']
    assert ages.oldest(NAMES).age == math.inf
    note(10.0, B)
    assert ages.oldest(NAMES).age == 0.0


def test_what_a_file_poses_rests_until_a_message_comes(ages, clock, note):
    ages.begin([A.get_value(), B.get_value()], {})
    clock.now += 9.0
    assert ages.oldest(NAMES).age == 0.0
    assert ages.static() == {}
    note(108.0, A)
    assert ages.by_name(NAMES) == {'s::a': 1.0, 's::b': 0.0}
    assert ages.static() == {A.get_value(): False}


def test_what_is_declared_to_move_has_no_age_from_the_file(ages, note):
    ages.begin([A.get_value(), B.get_value()], {A.get_value(): False})
    assert ages.by_name(NAMES) == {'s::a': math.inf, 's::b': 0.0}
    note(100.0, A)
    assert ages.oldest(NAMES).age == 0.0


def test_what_is_declared_static_does_not_grow_old_whoever_poses_it(ages, clocks, clock, note):
    ages.begin([], {A.get_value(): True, B.get_value(): True})
    assert ages.oldest(NAMES).age == math.inf  # neither has a pose
    assert note(100.0, A, B) == 100.0
    clock.now += 9.0
    clocks.begin_anew()
    assert ages.oldest(NAMES).age == 0.0
    assert ages.static() == {A.get_value(): True, B.get_value(): True}


def test_a_stamp_that_is_repeated_grows_older_beyond_a_minute(ages, clock, note):
    for second in range(200):
        note(99.0, A, B)
        assert ages.oldest(NAMES).age == 1.0 + second
        clock.now += 1.0
    note(299.5, A, B)
    assert ages.oldest(NAMES).age == 0.5


def test_a_stamp_of_another_clock_that_is_repeated_grows_older_by_the_time_that_passes(
    ages, clock, note
):
    clock.now = 1000.0
    note(12.5, A, B)
    clock.now += 2.0
    note(12.5, B)
    assert ages.by_name(NAMES) == {'s::a': 989.5, 's::b': 989.5}
    assert ages.of_other_clocks() == {A.get_value(): 987.5, B.get_value(): 987.5}
    note(1e6, A)
    assert ages.by_name(NAMES)['s::a'] == math.inf
    assert ages.of_other_clocks()[A.get_value()] == 1002.0 - 1e6
    note(1002.0, A, B)
    assert ages.oldest(NAMES).age == 0.0
    assert ages.of_other_clocks() == {}


def test_what_bears_no_stamp_is_new_each_time(ages, clock, note):
    for _ in range(3):
        note(0.0, A, B)
        assert ages.oldest(NAMES).age == 0.0
        clock.now += 40.0


def test_a_repeated_stamp_is_not_older_while_the_nodes_time_rests():
    node, steady = Plain(now=100.0), Plain(now=5.0)
    clocks = Clocks(lambda: node.now, lambda: steady.now)
    ages, stamp = PoseAges(clocks), Plain(sec=100, nanosec=0)
    frames = frozenset([A.get_value()])
    for _ in range(3):
        ages.note(ages.posed_by(frames, clocks.arrival().since(100.0), stamp), stamp)
        assert ages.oldest(table_of(a=A)).age == 0.0
        steady.now += 40.0


class AgesOfEach:
    """Plainly, for each frame by itself, what ``PoseAges`` is to tell."""

    def __init__(self, clocks, static):
        self.clocks, self.static = clocks, static
        self.since, self.stamps, self.newest = {}, {}, None

    def note(self, frames, since, stamp):
        for frame in frames:
            self.since[frame] = ALWAYS if frame in self.static else since
            self.stamps[frame] = stamp
        if self.newest is None or stamp >= self.newest:
            self.newest = stamp
        else:
            self.newest = max(
                self.stamps[f] for f, s in self.since.items() if s.epoch >= since.epoch
            )

    def ages(self):
        return {frame: self.clocks.age(since) for frame, since in self.since.items()}


FRAMES = [FrameId.get_new_id() for _ in range(4)]
VALUES = [frame.get_value() for frame in FRAMES]
NAMES_OF_EACH = table_of(**{str(f.get_value()): f for f in FRAMES})


@given(
    static=st.frozensets(st.sampled_from(VALUES)),
    messages=st.lists(
        st.tuples(
            st.frozensets(st.sampled_from(VALUES), min_size=1),
            st.integers(1, 6),  # stamp
            st.integers(0, 2),  # seconds until it comes
            st.booleans(),  # the clock jumps before
        ),
        min_size=1,
        max_size=12,
    ),
)
def test_what_is_told_does_not_hang_on_who_was_posed_together(static, messages):
    now = [10.0]
    clocks = Clocks(lambda: now[0], lambda: now[0])
    ages, plain = PoseAges(clocks), AgesOfEach(clocks, static)
    ages.begin([], dict.fromkeys(static, True))
    for frames, stamp, seconds, jumps in messages:
        now[0] += seconds
        if jumps:
            clocks.begin_anew()
        since = clocks.arrival().since(stamp)
        ages.note({frames: since}, Plain(sec=stamp, nanosec=0))
        plain.note(frames, since, stamp)
        told = plain.ages()
        assert ages.newest_stamp.sec == plain.newest
        assert ages.by_name(NAMES_OF_EACH) == {
            str(value): told.get(value, math.inf) for value in VALUES
        }
        everybody = max(told.values()) if len(told) == len(VALUES) else math.inf
        assert ages.oldest(NAMES_OF_EACH).age == everybody
        assert ages.unknown(NAMES_OF_EACH) == [
            str(value) for value in VALUES if told.get(value) == math.inf
        ]
        moved = {value for value, since in plain.since.items() if since != ALWAYS}
        assert ages.static() == {**dict.fromkeys(static, True), **dict.fromkeys(moved, False)}
