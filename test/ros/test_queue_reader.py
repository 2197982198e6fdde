"""Which of the messages that wait are read where not all of them can be."""

import re
import time

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.live.conversions.arrivals import waited
from drake_geom_ros.ros.queue_reader import QueueReader, newest


def message(text, publisher=b'one', came=0):
    return text.encode(), {'publisher_gid': {'data': publisher}, 'received_timestamp': came}


def texts(queue):
    return [raw.decode() for raw, _ in queue]


QUEUE = [message(t, p) for t, p in (('a1', b'a'), ('b1', b'b'), ('a2', b'a'), ('a3', b'a'))]


@pytest.mark.parametrize(
    ('room', 'kept'),
    [
        (8, ['a1', 'b1', 'a2', 'a3']),
        (6, ['b1', 'a2', 'a3']),
        (5, ['b1', 'a3']),
        (3, ['a3']),
        (0, ['a3']),
    ],
)
def test_the_newest_of_each_publisher_goes_before_older_ones(room, kept):
    assert texts(newest(QUEUE, room)) == kept


def test_where_nobody_tells_the_publisher_all_are_of_one():
    queue = [(raw, {'received_timestamp': 0}) for raw, _ in QUEUE]
    assert texts(newest(queue, 4)) == ['a2', 'a3']


def test_a_message_waited_since_the_middleware_noted_it():
    now = time.time_ns()
    assert 1.5 <= waited(message('x', came=now - 1_500_000_000)[1]) < 60.0
    # None was noted, the clock was set back, or it was set forward.
    for came in (0, now + 10**10, 1):
        assert waited(message('x', came=came)[1]) == 0.0


def test_before_the_subscription_is_known_a_message_is_taken_alone():
    taken, told = [], []
    together = QueueReader(
        lambda raw, waited, sender: taken.append(raw),
        lambda count, passed_over: told.append((count, passed_over)),
        may_pass_over=True,
    )
    together(*message('x'))
    assert (taken, told) == ([b'x'], [(1, 0)])


def test_nothing_is_imported_that_jazzy_does_not_have():
    """Seen on rclpy 7.1.6: the node did not start, for it names the type of message infos not."""
    texts = {path: path.read_text() for path in (ROOT / 'drake_geom_ros').rglob('*.py')}
    pattern = re.compile(r'^from rclpy\.subscription import .*\bMessageInfo\b', re.MULTILINE)
    assert [path for path, text in texts.items() if pattern.search(text)] == []
