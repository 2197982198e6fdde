"""Libraries take turns on the same poses; who cannot keep up is left out with a reason."""

import time

import pytest

from bench.peers.timing import (
    FEWEST_CYCLES,
    MOST_CYCLES,
    TURN_CYCLES,
    WARM_CYCLES,
    Turn,
    back_and_forth,
    interleave,
)

NO_LIMITS = {'a': 10.0, 'b': 10.0}


class Library:
    """Writes down what it is asked, into a list that it shares."""

    def __init__(self, name, calls, pause=0.0):
        self.turn = Turn([10, 11, 12], self._set_poses, self._query)
        self._name, self._calls, self._pause = name, calls, pause

    def _set_poses(self, poses):
        self._calls.append((self._name, poses))

    def _query(self):
        time.sleep(self._pause)
        return 2


def test_all_see_the_same_poses_and_begin_in_turn():
    calls = []
    turns = {name: Library(name, calls, pause=1e-3).turn for name in 'ab'}
    taken = interleave(turns, 0.12, NO_LIMITS)
    cycles = len(taken['a'].seconds)
    timed = calls[-2 * cycles :]
    for name in 'ab':
        assert [poses for who, poses in timed if who == name] == [
            10 + back_and_forth(WARM_CYCLES + k, 3) for k in range(cycles)
        ]
    assert cycles > 2 * TURN_CYCLES
    order = [who for who, _ in timed[: 4 * TURN_CYCLES]]
    assert order == [who for who in 'abba' for _ in range(TURN_CYCLES)]


def test_a_cycle_at_a_time_after_a_pause(monkeypatch):
    calls = []
    turns = {name: Library(name, calls).turn for name in 'ab'}
    monkeypatch.setattr(time, 'sleep', lambda seconds: calls.append(('sleep', seconds)))
    taken = interleave(turns, 0.0, NO_LIMITS, in_a_row=1, pause=0.25)
    timed = [who for who, what in calls if what != 0.0][2 * WARM_CYCLES :]
    assert timed[:8] == ['sleep', 'a', 'sleep', 'b', 'sleep', 'b', 'sleep', 'a']
    assert timed.count('sleep') == 2 * len(taken['a'].seconds) == 2 * FEWEST_CYCLES
    assert {what for who, what in calls if who == 'sleep'} == {0.0, 0.25}


def test_a_slow_query_has_few_cycles():
    taken = interleave({name: Library(name, []).turn for name in 'ab'}, 0.0, NO_LIMITS)
    assert [len(t.seconds) for t in taken.values()] == [FEWEST_CYCLES] * 2
    assert taken['a'].found == [2] * FEWEST_CYCLES
    assert taken['a'].mean_found() == 2


def test_there_is_an_end_to_the_cycles_of_a_fast_query():
    taken = interleave({'a': Library('a', []).turn}, 1e3, NO_LIMITS)
    assert len(taken['a'].seconds) == MOST_CYCLES


def test_a_slow_library_is_left_out():
    turns = {'a': Library('a', []).turn, 'b': Library('b', [], pause=0.02).turn}
    taken = interleave(turns, 0.0, {'a': 10.0, 'b': 0.01})
    assert 'more than 0.01 s' in taken['b'].left_out
    assert taken['b'].median() is None
    assert taken['a'].median() is not None


def test_a_library_that_raises_is_left_out():
    def refuse():
        raise RuntimeError('no such pair\nand more')

    turns = {'a': Library('a', []).turn, 'b': Turn([0], lambda _: None, refuse)}
    taken = interleave(turns, 0.0, NO_LIMITS)
    assert taken['b'].left_out == 'raised: no such pair'
    assert taken['b'].mean_found() is None


@pytest.mark.parametrize(('length', 'walk'), [(1, [0] * 6), (3, [0, 1, 2, 1, 0, 1])])
def test_poses_go_back_and_forth(length, walk):
    assert [back_and_forth(number, length) for number in range(6)] == walk
