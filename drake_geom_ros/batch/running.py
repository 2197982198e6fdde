"""Execution of blocks of states, by threads of this process or by an executor, with equal results.

Threads share only the job: each has its own queries. Compiled loops run without the GIL and check
a flag before each state, so Ctrl-C ends them at once.
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

from drake_geom_ros.batch import worker
from drake_geom_ros.batch.questions import Columns, Job
from drake_geom_ros.geometry import GeometryError

Block = tuple[int, int]  # the first state, and the one after the last
Done = tuple[Block, Columns]
_KILLED = 'KilledWorker'  # Dask: a block whose workers died several times; others are unaffected
_T = TypeVar('_T')
_B = TypeVar('_B')

LEAST_BLOCK = 256  # states: the overhead of a block is that of two of them
LOCAL_BLOCK = 1024  # states: some hundredths of a second, arrays that stay in the caches
REMOTE_BLOCK = 10_000  # states: a scheduler's overhead is negligible for a task of this size
_BLOCKS_A_THREAD = 8  # minimum for few states, so that all cores have work until the end
AHEAD = 64  # blocks submitted to an executor at once, which limits memory
_LOOKS = 0.2  # [s] period in which a wait for blocks handles Ctrl-C
_GRACE = 5.0  # [s] time limit between blocks after their executor was lost


class BatchError(GeometryError):
    """Raised for a batch that cannot be computed, resumed or written."""


def cores() -> int:
    """Return the number of cores that this process may use."""
    here = getattr(os, 'sched_getaffinity', None)
    return len(here(0)) if here else os.cpu_count() or 1


def blocks_of(count: int, size: int) -> list[Block]:
    """Return the blocks of ``count`` states."""
    return [(first, min(first + size, count)) for first in range(0, count, size)]


def size_for_all(count: int, threads: int, most: int, least: int = 1) -> int:
    """Return a number of states per block for some threads (0: one for each core)."""
    share = math.ceil(count / (_BLOCKS_A_THREAD * (threads or cores())))
    return max(least, min(most, share))


def by_threads(job: Job, states: Any, blocks: Iterable[Block], threads: int = 0) -> Iterator[Done]:
    """Yield the answers of blocks when they are done, by threads (0: one for each core).

    Raises PoseError for an invalid state.
    """
    stop, own = np.zeros(1, dtype=np.int64), threading.local()
    shared = (threads or cores()) > 1

    def answer(block: Block) -> Done:
        if not hasattr(own, 'queries'):
            own.queries = job.queries()
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
    """Yield the answers of blocks when they are done, by an executor's workers.

    Blocks refer to the job by its digest; the job itself is sent only if a worker lacks it. Blocks
    that are lost with a worker, or with the executor, are computed here, by ``threads`` (0: one
    for each core), with a RuntimeWarning that gives the reason. A lost executor gets no more
    blocks, since it may never answer. Raises BatchError for a worker with other sources, PoseError
    for an invalid state.
    """
    version, digest, waiting, gone = worker.version(), job.digest, iter(blocks), threading.Event()
    unknown: list[Block] = []  # blocks whose worker lacked the job
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
            return executor.submit(worker.answer, version, digest, sent, rows, first)
        except (RuntimeError, OSError) as error:  # it accepts no more tasks
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
    lost += [*unknown, *waiting]  # none unless the executor was lost
    if lost:
        warnings.warn(
            f'{len(lost)} blocks of states were lost and are computed by this process: '
            + '; '.join(causes),
            RuntimeWarning,
            stacklevel=2,
        )
        yield from by_threads(job, states, sorted(lost), threads)


def is_loss(error: BaseException) -> bool:
    """Return whether an error is the loss of a worker or executor, and not an error of the job."""
    of_job = isinstance(error, GeometryError)
    gone = isinstance(error, (BrokenExecutor, CancelledError, OSError))
    return not of_job and (gone or type(error).__module__.split('.')[0] == 'distributed')


def _in_flight(
    submit: Callable[[_B], Future[_T]],
    take: Callable[[], _B | None],
    most: int,
    is_gone: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[_B, Future[_T]]]:
    """Yield blocks with their futures when they are done, with at most ``most`` in flight.

    When ``is_gone`` returns True no more blocks are taken, and those without an answer are
    cancelled.
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
    """Return a cancelled future with a reason."""
    future: Future[Any] = Future()
    future.set_exception(CancelledError(why))
    return future
