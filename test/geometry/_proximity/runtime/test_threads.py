"""Work that is shared out to threads: all of it is done, and the answer is that of one thread."""

import os
import sys
import threading
import time

import numpy as np
import pytest
from oracles.engine_calls import signed_distances
from oracles.worlds import filters_of, random_rotations, random_world, shuffle

from drake_geom_ros.geometry._proximity.engine import engine as engines
from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.runtime import threads as sharing

PATIENCE = 60.0  # [s] of a busy machine


@pytest.fixture
def threads(monkeypatch):
    """Return what sets the number of threads, for work that takes any time at all."""

    def set_number(number):
        monkeypatch.setattr(sharing, 'THREADS', number)
        monkeypatch.setattr(engines, 'THREADS', number)
        sharing._pool.cache_clear()

    monkeypatch.setattr(engines, 'LONG', -1.0)
    yield set_number
    sharing._pool.cache_clear()


@pytest.mark.parametrize('number', [1, 2, 3, 7])
@pytest.mark.parametrize('count', [0, 1, 2, 100])
def test_each_part_is_done_once_and_in_order(threads, number, count):
    threads(number)
    parts = sharing.share(count, lambda first, last: list(range(first, last)))
    assert len(parts) == number
    assert [k for part in parts for k in part] == list(range(count))


@pytest.mark.clock
def test_what_goes_wrong_is_told_when_all_are_done(threads):
    threads(3)
    done = threading.Event()

    def work(first, last):
        if first == 0:
            raise ValueError('the first part')
        time.sleep(0.05)
        if last == 9:
            done.set()

    with pytest.raises(ValueError, match='the first part'):
        sharing.share(9, work)
    assert done.is_set()


@pytest.mark.clock
@pytest.mark.skipif(sys.platform != 'linux', reason='there niceness is of a whole process')
def test_no_thread_works_for_who_is_more_urgent(threads):
    """Threads that a nice one started are as nice, and do nothing for others."""
    threads(3)

    all_begun = threading.Barrier(3, timeout=PATIENCE)  # so that no thread does two parts

    def niceness(first, last):
        all_begun.wait()
        return os.getpriority(os.PRIO_PROCESS, 0)

    def nicely():
        os.nice(3)
        found.append(sharing.share(3, niceness))

    found, thread = [], threading.Thread(target=nicely)
    thread.start()
    thread.join()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    assert found == [[min(own + 3, 19)] * 3]
    assert sharing.share(3, niceness) == [own] * 3


@pytest.mark.parametrize('accuracy', ['exact', 'bound'])
@pytest.mark.parametrize('number', [2, 5])
def test_answers_are_those_of_one_thread(threads, number, accuracy):
    """To the last bit, also of pairs whose last answer is known, and what is counted as well."""
    rng = np.random.default_rng(0)
    world = random_world(rng, 300, types=(1, 2, 3), spread=0.6)
    filters, shared = filters_of(world), Engine()
    for step in range(4):
        if step != 2:  # nothing moved
            shuffle(rng, world, 0.6)
        threads(number)
        found = signed_distances(shared, world, filters, accuracy, 0.1 + 0.01 * (step % 2))
        threads(1)
        alone = signed_distances(Engine(), world, filters, accuracy, 0.1 + 0.01 * (step % 2))
        assert len(found.ids) > engines.MANY
        np.testing.assert_array_equal(found.ids, alone.ids)
        np.testing.assert_array_equal(found.rows, alone.rows)
    told = shared.effects
    assert told.narrowphase_pairs + told.cached_pairs + told.far_pairs == (
        told.broadphase_pairs - told.filtered_pairs
    )


def test_answers_may_become_few_or_none(threads):
    rng = np.random.default_rng(1)
    world = random_world(rng, 300, types=(1,), spread=0.4)
    filters, engine = filters_of(world), Engine()
    threads(2)
    for spread in (0.4, 0.4, 30.0, 3.0, 0.4, 0.4):
        shuffle(rng, world, spread)
        found = signed_distances(engine, world, filters, 'exact', 0.0, penetrating=True)
        alone = signed_distances(Engine(), world, filters, 'exact', 0.0, penetrating=True)
        np.testing.assert_array_equal(found.rows, alone.rows)


@pytest.mark.clock
@pytest.mark.skipif(not hasattr(os, 'fork'), reason='no process is forked here')
def test_a_forked_process_has_threads_of_its_own(threads):
    threads(2)
    sharing.share(4, lambda first, last: last)
    child = os.fork()
    if child == 0:
        os._exit(0 if sharing.share(4, lambda first, last: last - first) == [2, 2] else 1)
    end, ended = time.monotonic() + PATIENCE, 0
    while not ended and time.monotonic() < end:
        time.sleep(0.05)
        ended, status = os.waitpid(child, os.WNOHANG)
    if not ended:
        os.kill(child, 9)
        os.waitpid(child, 0)
    assert ended
    assert status == 0


@pytest.mark.parametrize('number', [1, 2, 5])
def test_a_world_is_posed_by_threads_as_by_one(threads, number):
    rng = np.random.default_rng(2)
    worlds = [random_world(np.random.default_rng(3), 40, anchored=15) for _ in range(2)]
    threads(number)
    rows = np.arange(1, 26)
    for step in range(4):
        some = rows if step % 2 else rng.choice(rows, 7, replace=False)
        poses = random_rotations(rng, len(some)), rng.normal(size=(len(some), 3))
        for world in worlds:
            world.set_poses(some, *poses)
        shared, alone = worlds
        assert shared.update_shared() == alone.update() == (len(some), len(some))
        assert shared.update_shared() == alone.update() == (0, 0)
        assert shared.revision == alone.revision
        for name in ('R_WFs', 'p_WFs', 'R_WGs', 'p_WGs', 'half_extents', 'stamps', 'travels'):
            np.testing.assert_array_equal(getattr(shared, name), getattr(alone, name))


def test_a_new_world_is_posed_by_threads_as_well(threads):
    threads(3)
    shared, alone = (random_world(np.random.default_rng(4), 9).copy() for _ in range(2))
    fresh = [world.rebuilt(world.frames, world.geometries) for world in (shared, alone)]
    assert fresh[0].update_shared() == fresh[1].update() == (9, 9)
    np.testing.assert_array_equal(fresh[0].p_WGs, fresh[1].p_WGs)
