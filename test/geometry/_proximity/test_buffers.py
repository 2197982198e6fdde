"""Memory of answers is used again, and never while somebody holds a part of one."""

import gc

import numpy as np
import pytest
from oracles.worlds import filters_of, random_world, shuffle

from drake_geom_ros.geometry._proximity.buffers import MOST_KEPT, SMALL, Buffers
from drake_geom_ros.geometry._proximity.engine import Engine

LARGE = SMALL // 8, 3


def address(array):
    return array.__array_interface__['data'][0]


def test_what_is_let_go_is_given_out_again():
    buffers = Buffers()
    first = address(buffers.empty(LARGE))
    assert address(buffers.empty(LARGE)) == first
    assert address(buffers.empty((LARGE[0], 2), np.int64)) == first


@pytest.mark.parametrize('part', [lambda a: a, lambda a: a[5:], lambda a: a[:, 1], lambda a: a.T])
def test_what_somebody_holds_a_part_of_is_not(part):
    buffers = Buffers()
    held = [part(buffers.empty(LARGE)) for _ in range(9)]
    for number, array in enumerate(held):
        array[...] = number
    buffers.empty(LARGE)[...] = -1.0
    assert [array.min() == array.max() == k for k, array in enumerate(held)] == [True] * 9


def test_small_and_huge_arrays_are_the_allocators_and_few_are_kept():
    buffers = Buffers()
    for size in (0, 1, SMALL // 8 - 1, MOST_KEPT // 8 + 1):
        assert buffers.empty((size,)).shape == (size,)
    assert not buffers._kept
    held = [buffers.empty(LARGE) for _ in range(20)]
    assert len(buffers._kept) < len(held)


@pytest.mark.parametrize('points', [False, True])
def test_answers_that_are_held_do_not_change_and_others_make_room(points):
    rng = np.random.default_rng(0)
    world = random_world(rng, 80, types=(1,))
    filters, engine, p_WQs = filters_of(world), Engine(), rng.normal(size=(100, 3))

    def asked():
        if points:
            return engine.point_distances(world, p_WQs, np.inf)
        return engine.signed_distances(world, filters, 'exact', np.inf)

    assert asked().rows.nbytes > SMALL
    held, copies = [], []
    for _ in range(8):
        shuffle(rng, world)
        held.append(asked())
        copies.append([array.copy() for array in held[-1]])
    for batch, copied in zip(held, copies, strict=True):
        for array, its_copy in zip(batch, copied, strict=True):
            np.testing.assert_array_equal(array, its_copy)
    held.clear()
    del batch, array
    gc.collect()
    places = set()
    for _ in range(8):
        shuffle(rng, world)
        places.add(address(asked().rows))
    assert len(places) <= 3
