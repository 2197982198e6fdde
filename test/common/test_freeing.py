"""Large lists are freed object by object."""

import weakref

from drake_geom_ros.common.freeing import free_in_pieces


class Thing:
    """An object that can be watched."""


def test_objects_are_freed_one_by_one_and_those_of_others_stay():
    things = [Thing() for _ in range(5)]
    kept, left = things[2], list[int]()
    watched = [weakref.finalize(thing, lambda: left.append(len(things))) for thing in things]
    free_in_pieces(things)
    assert things == []
    assert left == [4, 3, 1, 0], 'each one is gone before the next one is taken'
    assert [each.alive for each in watched] == [False, False, True, False, False]
    assert isinstance(kept, Thing)
