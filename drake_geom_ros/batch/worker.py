"""The function that runs in a worker's process: it caches jobs by digest and answers blocks."""

from __future__ import annotations

import functools
import hashlib
import os
import socket
import threading
from collections import OrderedDict
from importlib import metadata
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.questions import Columns, Job

# Columns of the answers, None if the worker lacks the job, or the text of a refusal.
Answer = Columns | str | None

MAX_JOBS = 4  # in the cache of a worker
_NAME = 'drake_geom_ros'
_jobs: OrderedDict[str, Job] = OrderedDict()
_lock = threading.Lock()
_own = threading.local()  # a thread's queries, for its last job
_NEVER = np.zeros(1, dtype=np.int64)


@functools.cache
def version(rooms: tuple[str, ...] = ('math', 'geometry', 'batch')) -> str:
    """Return the package's version with a digest of the sources that affect results."""
    digest = hashlib.sha256()
    folder = Path(__file__).parents[1]
    for room in rooms:
        for path in sorted((folder / room).rglob('*.py')):
            digest.update(str(path.relative_to(folder)).encode())
            digest.update(path.read_bytes())
    try:
        number = metadata.version(_NAME)
    except metadata.PackageNotFoundError:
        number = 'not installed as a package'
    return f'{number}, sources {digest.hexdigest()[:16]}'


def answer(
    asked_by: str, digest: str, job: Job | None, states: NDArray[np.float64], first: int
) -> Answer:
    """Return the answers of a job about states; see ``Answer``.

    ``asked_by`` is the ``version()`` of the caller: only equal versions give equal bits. Errors
    count states from ``first``.
    """
    if asked_by != version():
        return (
            f'worker {os.getpid()} on {socket.gethostname()} has {_NAME} {version()}, '
            f'this process has {asked_by}: install the same on both'
        )
    cached = _cached_job(digest, job)
    if cached is None:
        return None
    if getattr(_own, 'digest', None) != digest:
        _own.digest, _own.queries = digest, cached.queries()
    return cached.answer(_own.queries, np.array(states, dtype=np.float64), _NEVER, first)


def _cached_job(digest: str, job: Job | None) -> Job | None:
    """Return the job of a digest, after adding it to the cache if it is not None, or None."""
    with _lock:
        if job is not None:
            _jobs[digest] = job
        if digest in _jobs:
            _jobs.move_to_end(digest)
            while len(_jobs) > MAX_JOBS:
                _jobs.popitem(last=False)
        return _jobs.get(digest)
