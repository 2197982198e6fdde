"""FCL in a process that it may end or hang, and what becomes of its answers."""

from __future__ import annotations

import contextlib
import functools
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from drake_geom_ros.cross_check.judging import judged
from drake_geom_ros.cross_check.question import (
    LOST,
    SILENT,
    Asked,
    Batch,
    Pose,
    Question,
    Verdict,
)
from drake_geom_ros.evidence import peers
from drake_geom_ros.evidence.bodies import Body, Pair
from drake_geom_ros.evidence.lost_process import ANSWER, LostProcess
from drake_geom_ros.evidence.peers.measures import kind_of, measures
from drake_geom_ros.geometry import MeshFileError
from drake_geom_ros.math import RigidTransform, RotationMatrix

LIBRARY = 'python-fcl'
LIMIT = 2.0  # [s] of processor time for a question, which takes a millisecond at most
MOST_LOST = 3  # processes that a pair of geometries may cost; it is not asked about any more
_PREPARED_PAIRS = 1024  # whose objects FCL keeps

Bodies = dict[int, Body]
Ask = Callable[[str, int, int, Pose, Pose, Mapping[int, Body]], Any]


def body_of(asked: Asked) -> Body:
    """Return a shape of the scene as ``evidence`` has it, at the origin."""
    if asked.is_solid:
        vertices, triangles = asked.shape.surface()  # type: ignore[attr-defined]
        return Body('Solid', vertices, triangles=triangles)
    kind = kind_of(asked.shape)
    if kind == 'Convex':
        return Body(kind, asked.shape.hull_surface()[0])  # type: ignore[attr-defined]
    return Body(kind, measures(asked.shape))


class SecondOpinion:
    """Asks FCL about answers of ours, about one version of a scene at a time."""

    def __init__(self, make: Callable[[Bodies], Ask] | None = None, limit: float = LIMIT) -> None:
        """``make(bodies)`` returns what asks, in the process where it is called; default: FCL."""
        made = make or _Fcl
        self.library = LIBRARY if make else f'{LIBRARY} {peers.version(LIBRARY)}'
        self._limit = limit
        self._version = -1
        self._bodies: Bodies = {}
        self._there: set[int] = set()  # whose bodies the process has
        self._losses: Counter[tuple[int, int]] = Counter()  # processes, by pair
        self._process = LostProcess(lambda: made(dict(self._bodies)))

    def judge(self, batch: Batch) -> list[Verdict]:
        """Return the verdicts on the questions of a batch."""
        if batch.version != self._version:
            self.close()
            self._version, self._bodies, self._losses = batch.version, {}, Counter()
        for value, asked in batch.shapes.items():
            with contextlib.suppress(MeshFileError):  # of a file that is not what it was
                self._bodies[value] = body_of(asked)
        return [self._judged(question) for question in batch.questions]

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def _judged(self, ours: Question) -> Verdict:
        if not self._bodies.keys() >= set(ours.ids):
            return Verdict(SILENT, text='a mesh file cannot be read')
        if self._losses[ours.ids] >= MOST_LOST:
            return Verdict(SILENT, text=f'not asked: it was lost {MOST_LOST} times')
        a, b = (
            self._bodies[value].placed(*pose)
            for value, pose in zip(ours.ids, (ours.X_WA, ours.X_WB), strict=True)
        )
        # FCL's signed distance ends the process for each half space; a contact it can tell.
        flat = 'HalfSpace' in (a.kind, b.kind)
        query = peers.PENETRATION if flat else peers.SIGNED_DISTANCE
        if not self._process.is_running:
            self._there = set(self._bodies)  # it is a copy of this one
        new = {value: self._bodies[value] for value in ours.ids if value not in self._there}
        self._there |= new.keys()
        outcome = self._process.ask(self._limit, query, *ours.ids, ours.X_WA, ours.X_WB, new)
        if outcome.is_lost:
            self._losses[ours.ids] += 1
            return Verdict(LOST, text=f'{outcome.end} ({outcome.value})')
        if outcome.end != ANSWER:
            return Verdict(SILENT, text=str(outcome.value))
        return judged(Pair(a, b), ours, outcome.value, self.library)


class _Fcl:
    """What is asked in the process: keeps bodies, and FCL's objects for pairs of them."""

    def __init__(self, bodies: Bodies) -> None:
        peer = peers.load(LIBRARY)
        self._bodies = bodies

        @functools.lru_cache(maxsize=_PREPARED_PAIRS)
        def prepared(query: str, a: int, b: int) -> peers.Ask:
            return peer.pair(query, bodies[a].shape, bodies[b].shape)

        self._prepared = prepared

    def __call__(
        self, query: str, a: int, b: int, X_WA: Pose, X_WB: Pose, new: Mapping[int, Body]
    ) -> peers.PairAnswer | None:
        self._bodies.update(new)
        return self._prepared(query, a, b)(_transform(X_WA), _transform(X_WB))


def _transform(X: Pose) -> RigidTransform:
    R, p = X
    return RigidTransform(RotationMatrix(np.array(R)), p)
