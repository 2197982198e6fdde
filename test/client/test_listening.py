"""Which result is handed on with which table: no ROS is spun here."""

from types import SimpleNamespace as Some

import pytest

from drake_geom_ros.client import listening
from drake_geom_ros.client.listening import _Arrivals


@pytest.fixture
def taken():
    return []


@pytest.fixture
def arrivals(taken):
    return _Arrivals(lambda message, table: taken.append((message.name, table)))


def result(names_version, name):
    return Some(names_version=names_version, name=name)


def test_results_wait_for_the_table_of_their_names_and_all_are_handed_on(arrivals, taken):
    arrivals.hear(result(2, 'first'), {})
    arrivals.hear(result(2, 'second'), {})
    arrivals.hear(result(3, 'third'), {})
    arrivals.look({1: 'one'})
    assert taken == []
    arrivals.look({1: 'one', 2: 'two'})
    assert taken == [('first', 'two'), ('second', 'two')]
    arrivals.look({1: 'one', 2: 'two', 3: 'three'})
    arrivals.hear(result(2, 'late'), {1: 'one', 2: 'two', 3: 'three'})
    assert taken[2:] == [('third', 'three'), ('late', 'two')]
    assert arrivals.dropped == 0


def test_what_later_names_have_overtaken_is_dropped_and_counted(arrivals, taken):
    arrivals.hear(result(2, 'lost'), {1: 'one'})
    arrivals.hear(result(3, 'kept'), {1: 'one'})
    arrivals.look({1: 'one', 3: 'three'})
    assert (taken, arrivals.dropped) == ([('kept', 'three')], 1)


def test_so_many_wait_and_no_more(arrivals, taken):
    more = listening._MOST_WAITING + 5
    for number in range(more):
        arrivals.hear(result(2, number), {})
    assert arrivals.dropped == 5
    arrivals.look({2: 'two'})
    assert [name for name, _ in taken] == list(range(5, more))
