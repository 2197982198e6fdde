"""What runs in the process of a worker: it keeps jobs, by their digest, and answers blocks."""

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
from drake_geom_ros.geometry.queries.state_queries import StateQueries

# Columns of the answers; None where the worker has no such job; a text where it refuses.
Answer = Columns | str | None

KEPT_JOBS = 4  # that a worker knows at once
_NAME = 'drake_geom_ros'
_jobs: OrderedDict[str, Job] = OrderedDict()
_lock = threading.Lock()
_own = threading.local()  # a thread's queries, for the job that it had last
_NEVER = np.zeros(1, dtype=np.int64)


@functools.cache
def version(rooms: tuple[str, ...] = ('math', 'geometry', 'batch')) -> str:
    """Return the package's version with a digest of the sources that decide about every bit."""
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

    ``asked_by`` is the ``version()`` of whoever asks: only the same gives the same bits.
    The first of the states has the number ``first`` in errors.
    """
    if asked_by != version():
        return (
            f'worker {os.getpid()} on {socket.gethostname()} has {_NAME} {version()}, '
            f'this process has {asked_by}: install the same on both'
        )
    known = _known(digest, job)
    if known is None:
        return None
    if getattr(_own, 'digest', None) != digest:
        _own.digest, _own.queries = digest, StateQueries(known.scene)
    return known.answer(_own.queries, np.array(states, dtype=np.float64), _NEVER, first)


def _known(digest: str, job: Job | None) -> Job | None:
    """Return the job of a digest, which is kept if it is given; None where it is not known."""
    with _lock:
        if job is not None:
            _jobs[digest] = job
        if digest in _jobs:
            _jobs.move_to_end(digest)
            while len(_jobs) > KEPT_JOBS:
                _jobs.popitem(last=False)
        return _jobs.get(digest)
