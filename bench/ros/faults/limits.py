"""Faults of the machine: no descriptor, no room on the disk, no memory, no processor."""

from __future__ import annotations

import os
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from drake_geom_msgs import srv
from rclpy.serialization import serialize_message

from bench.ros.faults.site import LOST, Site
from drake_geom_ros.live.services.saved_file import MARK

SPARE_MEMORY = (8, 32, 128)  # [MiB] that the node may take on top of what it has
POINTS = 6000  # asked about: 48 MB with two arms
SMALL_FILE = 100  # [bytes]
LONGEST_STOP = 1.5  # [s]


@contextmanager
def limited(pid: int, what: int, value: int) -> Iterator[None]:
    """Lower a limit of a running process, and put it back."""
    soft, hard = resource.prlimit(pid, what)
    resource.prlimit(pid, what, (value, hard))
    try:
        yield
    finally:
        with suppress(ProcessLookupError):
            resource.prlimit(pid, what, (soft, hard))


def few_descriptors(site: Site) -> str:
    """Let the node open no file: saving and loading are refused, and work again later."""
    used = {int(name) for name in os.listdir(f'/proc/{site.pid}/fd')}
    free = next(number for number in range(len(used) + 1) if number not in used)
    path = site.folder / 'few.yaml'
    with site.alone():
        with limited(site.pid, resource.RLIMIT_NOFILE, free):
            answer = _save(site, path)
            if answer.success or 'open files' not in answer.message:
                return f'without descriptors save_scene says {answer.success}, {answer.message}'
            if problem := site.trouble():
                return problem
        answer = _save(site, path)
    return '' if answer.success else f'with descriptors save_scene says {answer.message}'


def full_disk(site: Site) -> str:
    """Let the node write a few bytes only: what was saved before stays whole."""
    path = site.folder / 'full.yaml'
    with site.alone():
        path.write_text(before := f'{MARK}sources: [before]\n')
        with limited(site.pid, resource.RLIMIT_FSIZE, SMALL_FILE):
            answer = _save(site, path)
        if answer.success or path.read_text() != before:
            return f'on a full disk save_scene says {answer.success}, {answer.message}'
        left = [name for name in os.listdir(site.folder) if name.endswith('.part')]
        if left:
            return f'half written files are left: {left}'
        answer = _save(site, path)
    return '' if answer.success else f'with room again save_scene says {answer.message}'


def little_memory(site: Site) -> str:
    """Let the node have little more memory than it has, and ask for what takes more."""
    spare = site.random.choice(SPARE_MEMORY) * 2**20
    pages = int(Path(f'/proc/{site.pid}/statm').read_text().split()[0])
    room = pages * resource.getpagesize() + spare
    service = f'{site.server}/compute_signed_distance_to_point'
    client = site.client(srv.ComputeSignedDistanceToPoint, service)
    points = [site.random.uniform(-1.0, 1.0) for _ in range(3 * POINTS)]
    request = srv.ComputeSignedDistanceToPoint.Request(points=points)
    with site.alone():
        with limited(site.pid, resource.RLIMIT_AS, room):
            # What came of it is the node's to say; that it lives and serves is what counts.
            site.answer(client, request)
            if problem := site.trouble():
                return problem
        answer = site.answer(client, request, LOST)
    if answer is None or not answer.success:
        return f'with memory again {service} says {answer and answer.message}'
    return '' if len(serialize_message(answer)) > 10**6 else 'the answer is small'


def stopped_node(site: Site) -> str:
    """Stop the node as one stops who suspends a machine; calls that wait are answered later."""
    client = site.client(srv.HasCollisions, f'{site.server}/has_collisions')
    os.kill(site.pid, signal.SIGSTOP)
    try:
        futures = [client.call_async(srv.HasCollisions.Request()) for _ in range(10)]
        site.spin(site.random.uniform(0.1, LONGEST_STOP))
    finally:
        os.kill(site.pid, signal.SIGCONT)
    site.wait_for(lambda: all(f.done() for f in futures), 'answers of a node that goes on')
    return ''


def _save(site: Site, path: Path) -> Any:
    return site.ask(srv.SaveScene, f'{site.server}/save_scene', path=str(path))
