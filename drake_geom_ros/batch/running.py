"""Blocks of states by threads of this process, or by an executor: who computes changes no bit.

Threads share nothing but the job: each has queries of its own. Compiled loops run without the
GIL and look at a flag before each state, so Ctrl-C ends them at once.
"""

from __future__ import annotations

import math
import os
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import worker
from drake_geom_ros.batch.questions import Columns, Job
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.geometry.queries.state_queries import StateQueries

Floats = NDArray[np.float64]
Block = tuple[int, int]  # the first state, and the one behind the last
Done = tuple[Block, Columns]
_KILLED = 'KilledWorker'  # Dask: a block that died with several workers; the others go on
_T = TypeVar('_T')
_B = TypeVar('_B')

LEAST_BLOCK = 256  # states: to begin with a block takes as long as two of them
LOCAL_BLOCK = 1024  # states: some hundredths of a second, arrays that stay in the caches
REMOTE_BLOCK = 10_000  # states: what a scheduler takes for a task is nothing beside it
_BLOCKS_A_THREAD = 8  # at least, where states are few: all cores have work until the end
AHEAD = 64  # blocks that are with an executor at once: memory stays flat
_LOOKS = 0.2  # [s] how often a wait for blocks lets Ctrl-C in
_GRACE = 5.0  # [s] that blocks have, one after the other, once their executor is known to be gone


class BatchError(GeometryError):
    """A batch that cannot be computed where it was asked to be."""


def cores() -> int:
    """Return how many cores this process may use."""
    here = getattr(os, 'sched_getaffinity', None)
    return len(here(0)) if here else os.cpu_count() or 1


def blocks_of(count: int, size: int) -> list[Block]:
    """Return the blocks of ``count`` states."""
    return [(first, min(first + size, count)) for first in range(0, count, size)]


def size_for_all(count: int, threads: int, most: int, least: int = 1) -> int:
    """Return how many states a block should have for so many threads (0: one for each core)."""
    share = math.ceil(count / (_BLOCKS_A_THREAD * (threads or cores())))
    return max(least, min(most, share))


def by_threads(job: Job, states: Any, blocks: Iterable[Block], threads: int = 0) -> Iterator[Done]:
    """Yield the answers of blocks as they are done, by threads (0: one for each core).

    Raises PoseError for a state that is none.
    """
    stop, own = np.zeros(1, dtype=np.int64), threading.local()
    shared = (threads or cores()) > 1

    def answer(block: Block) -> Done:
        if not hasattr(own, 'queries'):
            own.queries = StateQueries(job.scene)
        rows = np.asarray(states[block[0] : block[1]], dtype=np.float64)
        return block, job.answer(own.queries, rows, stop, block[0], shared=shared)

    def submit(block: Block) -> Future[Done]:
        return pool.submit(answer, block)

    pool = ThreadPoolExecutor(threads or cores())
    take = partial(next, iter(blocks), None)
    try:
        ahead = 2 * (threads or cores())
        for _, done in _in_flight(submit, take, ahead):
            yield done.result()
    finally:
        stop[0] = 1
        pool.shutdown(wait=True, cancel_futures=True)


def by_executor(
    job: Job, states: Any, blocks: Iterable[Block], executor: Executor, threads: int = 0
) -> Iterator[Done]:
    """Yield the answers of blocks as they are done, by an executor's workers.

    Blocks name the job by its digest; it goes with one only where a worker does not know it yet.
    Blocks that are lost with a worker, or with the executor, are computed here, by ``threads`` (0:
    one for each core): a RuntimeWarning says why. Nothing more is given to an executor that is
    gone: it may never answer. Raises BatchError for a worker of other sources, PoseError for a
    state that is none.
    """
    mine, digest, waiting, gone = worker.version(), job.digest, iter(blocks), threading.Event()
    unknown: list[Block] = []  # blocks of which a worker did not know the job
    lost: list[Block] = []
    causes: dict[str, None] = {}

    def take() -> tuple[Block, Job | None] | None:
        if unknown:
            return unknown.pop(), job
        block = next(waiting, None)
        return block and (block, None)

    def submit(task: tuple[Block, Job | None]) -> Future[worker.Answer]:
        (first, last), sent = task
        rows = np.array(states[first:last], dtype=np.float64)
        try:
            return executor.submit(worker.answer, mine, digest, sent, rows, first)
        except (RuntimeError, OSError) as error:  # it takes no more tasks
            return _cancelled(f'{type(error).__name__}: {error}')

    for (block, _), done in _in_flight(submit, take, AHEAD, gone.is_set):
        error = CancelledError() if done.cancelled() else done.exception()
        if error is None:
            answer = done.result()
            if answer is None:
                unknown.append(block)
            elif isinstance(answer, str):
                raise BatchError(answer)
            else:
                yield block, answer
        elif is_loss(error):
            lost.append(block)
            causes[f'{type(error).__name__}: {error}'] = None
            if type(error).__name__ != _KILLED:
                gone.set()
        else:
            raise error
    lost += [*unknown, *waiting]  # if it is gone; else there are none
    if lost:
        warnings.warn(
            f'{len(lost)} blocks of states were lost and are computed by this process: '
            + '; '.join(causes),
            RuntimeWarning,
            stacklevel=2,
        )
        yield from by_threads(job, states, sorted(lost), threads)


def is_loss(error: BaseException) -> bool:
    """Tell whether an error says that whoever computed is gone, and not that it found one."""
    ours = isinstance(error, GeometryError)
    gone = isinstance(error, (BrokenExecutor, CancelledError, OSError))
    return not ours and (gone or type(error).__module__.split('.')[0] == 'distributed')


def _in_flight(
    submit: Callable[[_B], Future[_T]],
    take: Callable[[], _B | None],
    most: int,
    is_gone: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[_B, Future[_T]]]:
    """Yield what is taken and its future as it is done; at most so many are under way.

    Once whoever computes ``is_gone`` no more is taken, and what gets no answer is cancelled.
    """
    under_way: dict[Future[_T], _B] = {}
    last = time.monotonic()
    try:
        while True:
            while not is_gone() and len(under_way) < most and (block := take()) is not None:
                under_way[submit(block)] = block
            if not under_way:
                return
            for future in wait(under_way, _LOOKS, FIRST_COMPLETED).done:
                yield under_way.pop(future), future
                last = time.monotonic()
            if is_gone() and time.monotonic() - last > _GRACE:
                for block in list(under_way.values()):
                    yield block, _cancelled('no answer any more')
                return
    finally:
        for future in under_way:
            future.cancel()


def _cancelled(why: str) -> Future[Any]:
    """Return a future that was cancelled, and says why."""
    future: Future[Any] = Future()
    future.set_exception(CancelledError(why))
    return future
