"""Ids: new ones differ in every thread, and kinds do not mix."""

import threading

import numpy as np
import pytest

from drake_geom_ros.geometry import FilterId, FrameId, GeometryError, GeometryId, SourceId
from drake_geom_ros.geometry.ids import begin_ids_at

KINDS = [SourceId, FrameId, GeometryId, FilterId]


@pytest.mark.parametrize('kind', KINDS)
def test_new_ids_differ_and_grow(kind):
    ids = [kind.get_new_id() for _ in range(5)]
    assert ids == sorted(set(ids))
    assert all(id.is_valid() for id in ids)
    assert [kind(id.get_value()) for id in ids] == ids
    assert repr(ids[0]) == f'<{kind.__name__} value={ids[0].get_value()}>'


def test_new_ids_differ_across_threads():
    found = []
    start = threading.Barrier(8)

    def work():
        start.wait()
        found.append([GeometryId.get_new_id() for _ in range(2000)])

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({id for ids in found for id in ids}) == 8 * 2000
    assert all(ids == sorted(ids) for ids in found)


def test_kinds_count_for_themselves_and_never_compare():
    before = FrameId.get_new_id().get_value()
    GeometryId.get_new_id()
    assert FrameId.get_new_id().get_value() == before + 1
    assert FrameId(7) != GeometryId(7)
    assert FrameId(7) != 7
    assert len({FrameId(7), GeometryId(7), FrameId(7)}) == 2
    for compare in (lambda: FrameId(1) < GeometryId(2), lambda: FrameId(1) <= GeometryId(2)):
        with pytest.raises(TypeError, match='not supported'):
            compare()


def test_order():
    assert FrameId(1) < FrameId(2) > FrameId(1)
    assert FrameId(2) <= FrameId(2) >= FrameId(2)
    assert not FrameId(2) < FrameId(2)


def test_an_invalid_id_has_no_value():
    assert not GeometryId(0).is_valid()
    with pytest.raises(RuntimeError, match='invalid'):
        GeometryId(0).get_value()


def test_values_are_whole_numbers():
    assert type(GeometryId(np.uint64(3)).get_value()) is int
    for bad in (1.0, '1', None):
        with pytest.raises(GeometryError, match='must be an int'):
            GeometryId(bad)
    with pytest.raises(GeometryError, match='>= 0'):
        GeometryId(-1)


@pytest.mark.parametrize('kind', KINDS)
def test_ids_can_begin_at_a_number_and_never_go_back(kind):
    number = kind.get_new_id().get_value() + 1000
    begin_ids_at(number)
    assert kind.get_new_id().get_value() == number
    begin_ids_at(1)
    assert kind.get_new_id().get_value() == number + 1
