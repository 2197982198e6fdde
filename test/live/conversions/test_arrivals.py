"""Messages that never arrived are counted by the numbers of their publishers."""

from drake_geom_ros.live.conversions.arrivals import Gaps


def info(number, publisher=b'a'):
    return {'publication_sequence_number': number, 'publisher_gid': {'data': publisher}}


def test_numbers_that_are_missing_are_counted_by_publisher():
    gaps = Gaps()
    heard = [(7, b'a'), (8, b'a'), (100, b'b'), (11, b'a'), (101, b'b'), (104, b'b')]
    assert [gaps.before(info(*each)) for each in heard] == [0, 0, 0, 2, 0, 2]


def test_a_middleware_without_numbers_and_one_that_begins_anew_miss_nothing():
    gaps = Gaps()
    assert [gaps.before(info(number)) for number in (None, 5, None, 6, 1, 2)] == [0] * 6
    assert gaps.before({}) == 0


def test_as_many_publishers_as_may_be_are_remembered():
    gaps = Gaps()
    for k in range(200):
        assert gaps.before(info(1, bytes([k]))) == 0
    assert gaps.before(info(4, bytes([199]))) == 2
    assert gaps.before(info(4, bytes([0]))) == 0, 'it was forgotten'
