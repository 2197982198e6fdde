"""Records of arrays by their addresses: what goes in comes out, and copies have their own."""

import copy
import gc
import time
from typing import NamedTuple

import numpy as np
import pytest
from numba import config
from oracles.engine_calls import signed_distances
from oracles.worlds import filters_of, random_world, shuffle

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Bits,
    Flags,
    Integers,
    Matrices,
    Rows,
    handle_of,
    taker,
)


class Mixed(NamedTuple):
    flags: Flags
    matrices: Matrices
    rows: Rows
    numbers: Integers
    bits: Bits


mixed_of = taker(Mixed)


def mixed(n, width):
    rng = np.random.default_rng(0)
    return Mixed(
        flags=rng.random(n) < 0.5,
        matrices=rng.random((n, 3, 3)),
        rows=rng.random((n, width)),
        numbers=rng.integers(0, 99, n + 1),
        bits=rng.integers(0, 255, (2, n, width), dtype=np.uint8),
    )


@compiled
def read_and_write(handle, sums):
    record = mixed_of(handle)
    sums[0], sums[1], sums[2], sums[3], sums[4] = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(record.flags.size):
        sums[0] += record.flags[k]
        for c in range(record.rows.shape[1]):
            sums[2] += record.rows[k, c]
            for layer in range(2):
                sums[4] += record.bits[layer, k, c]
        for i in range(3):
            for j in range(3):
                sums[1] += record.matrices[k, i, j]
    for k in range(record.numbers.size):
        sums[3] += record.numbers[k]
        record.numbers[k] = k


@pytest.mark.parametrize(('n', 'width'), [(0, 4), (1, 0), (5, 7)])
def test_compiled_code_sees_and_writes_the_arrays_of_the_record(n, width):
    record, sums = mixed(n, width), np.empty(5)
    expected = [float(np.sum(array, dtype=float)) for array in record]
    read_and_write(handle_of(record), sums)
    np.testing.assert_allclose(sums, expected)
    assert record.numbers.tolist() == list(range(n + 1))


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason='uncompiled, a handle is the record')
@pytest.mark.parametrize(
    ('field', 'array'),
    [
        ('flags', np.zeros(3, dtype=np.uint8)),
        ('matrices', np.zeros((3, 3))),
        ('matrices', np.zeros((3, 3, 4))),
        ('rows', np.zeros((3, 8))[:, ::2]),
        ('numbers', np.zeros(3)),
    ],
)
def test_another_type_or_shape_or_one_in_pieces_is_refused(field, array):
    record = mixed(3, 4)
    with pytest.raises(TypeError, match=field):
        handle_of(record._replace(**{field: array}))


@pytest.mark.parametrize('make', [copy.deepcopy, lambda pair: (pair[0].copy(), Engine())])
def test_a_copy_of_an_engine_and_its_world_works_on_arrays_of_its_own(make):
    rng = np.random.default_rng(1)
    world = random_world(rng, 30, types=(1,), spread=0.5)
    filters, engine = filters_of(world), Engine()
    first = signed_distances(engine, world, filters, 'exact', 0.1)
    other_world, other = make((world, engine))
    shuffle(rng, world)
    again = signed_distances(other, other_world, filters, 'exact', 0.1)
    assert (again.ids == first.ids).all()
    assert (again.rows == first.rows).all()
    moved = signed_distances(engine, world, filters, 'exact', 0.1).rows.copy()
    del world, engine
    gc.collect()
    shuffle(rng, other_world)
    assert len(signed_distances(other, other_world, filters, 'exact', 0.1).ids)
    assert moved.shape != first.rows.shape or (moved != first.rows).any()


def test_the_clock_is_steady_and_that_of_python():
    @compiled
    def told(times):
        for k in range(times.size):
            times[k] = now()

    told(np.empty(1))
    before, times = time.perf_counter(), np.empty(100)
    told(times)
    assert before <= times[0] <= times[-1] <= time.perf_counter()
    assert (np.diff(times) >= 0.0).all()
