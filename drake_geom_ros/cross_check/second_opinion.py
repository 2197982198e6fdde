"""FCL in a process that it may end or hang, and what becomes of its answers."""

from __future__ import annotations

import contextlib
import functools
from collections import Counter
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import Any

import numpy as np

from drake_geom_ros.cross_check import answers, fcl_peer
from drake_geom_ros.cross_check.answers import kind_of, measures
from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.judging import judged
from drake_geom_ros.cross_check.lost_process import ANSWER, LostProcess
from drake_geom_ros.cross_check.question import (
    LOST,
    SILENT,
    PairQuestion,
    Pose,
    QuestionBatch,
    QuestionedShape,
    Verdict,
)
from drake_geom_ros.geometry import MeshFileError, OccupiedCells, PointCloud
from drake_geom_ros.math import RigidTransform, RotationMatrix

LIBRARY = 'python-fcl'
LIMIT = 2.0  # [s] of processor time for a question, which takes a millisecond at most
MOST_LOST = 3  # processes that a pair of geometries may cost; it is not asked about any more
# Edge of a box that stands for a half space, in radii of the other body: 2 hold what is nearest,
# and of wider ones FCL is less sure (spheres and capsules: 8e-5 m off with 3, 1e-3 m with 20).
_BOX = 3.0
_PREPARED_PAIRS = 1024  # whose objects FCL keeps

Bodies = dict[int, Body]
Ask = Callable[[str, int, int, Pose, Pose, Mapping[int, Body]], Any]


def why_silent(asked: QuestionedShape) -> str:
    """Return why FCL cannot be asked about a sensed map, or nothing."""
    if isinstance(asked.shape, PointCloud):
        return 'FCL has no balls of a cloud'
    if isinstance(asked.shape, OccupiedCells):
        if asked.is_grown:
            return "FCL knows nothing of ('map', 'margin')"
        if not fcl_peer.is_octree(asked.shape):
            return 'the cells do not lie on the grid of an octree'
    return ''


def body_of(asked: QuestionedShape) -> Body:
    """Return a shape of the scene as a body, at the origin."""
    if isinstance(asked.shape, OccupiedCells):
        return Body('OccupiedCells', (asked.shape.resolution(), asked.shape.centres()))
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
        self.library = LIBRARY if make else f'{LIBRARY} {metadata.version(LIBRARY)}'
        self._limit = limit
        self._version = -1
        self._bodies: Bodies = {}
        self._silent: dict[int, str] = {}  # why there is no body of a geometry
        self._there: set[int] = set()  # whose bodies the process has
        self._losses: Counter[tuple[int, int]] = Counter()  # processes, by pair
        self._process = LostProcess(lambda: made(dict(self._bodies)))

    def judge(self, batch: QuestionBatch) -> list[Verdict]:
        """Return the verdicts on the questions of a batch."""
        if batch.version != self._version:
            self.close()
            self._version, self._bodies, self._losses = batch.version, {}, Counter()
            self._silent = {}
        for value, asked in batch.shapes.items():
            if reason := why_silent(asked):
                self._silent[value] = reason
                continue
            with contextlib.suppress(MeshFileError):  # of a file that is not what it was
                self._bodies[value] = body_of(asked)
        return [self._judged(question) for question in batch.questions]

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def _judged(self, ours: PairQuestion) -> Verdict:
        for reason in (self._silent[value] for value in ours.ids if value in self._silent):
            return Verdict(SILENT, text=reason)
        if not self._bodies.keys() >= set(ours.ids):
            return Verdict(SILENT, text='a mesh file cannot be read')
        if self._losses[ours.ids] >= MOST_LOST:
            return Verdict(SILENT, text=f'not asked: it was lost {MOST_LOST} times')
        pair = Pair(
            self._bodies[ours.ids[0]].placed(*ours.X_WA),
            self._bodies[ours.ids[1]].placed(*ours.X_WB),
        )
        if pair.has_map and 'HalfSpace' in (pair.a.kind, pair.b.kind):
            return Verdict(SILENT, text='FCL tells nothing of an octree and a half space')
        query, ids, poses = self._asked(pair, ours)
        if not self._process.is_running:
            self._there = set(self._bodies)  # it is a copy of this one
        new = {value: self._bodies[value] for value in ids if value not in self._there}
        self._there |= new.keys()
        outcome = self._process.ask(self._limit, query, *ids, *poses, new)
        if outcome.is_lost:
            self._losses[ours.ids] += 1
            return Verdict(LOST, text=f'{outcome.end} ({outcome.value})')
        if outcome.end != ANSWER:
            return Verdict(SILENT, text=str(outcome.value))
        return judged(pair, ours, outcome.value, self.library)

    def _asked(self, pair: Pair, ours: PairQuestion) -> tuple[str, list[int], list[Pose]]:
        """Return what FCL is asked: the query, ids of bodies, and their poses.

        FCL's signed distance ends the process for each half space. It can tell a contact with one;
        where we say that there is none, a box stands for the half space, below the other body.
        """
        ids, poses = list(ours.ids), [ours.X_WA, ours.X_WB]
        bodies = pair.a, pair.b
        flat = [k for k, body in enumerate(bodies) if body.kind == 'HalfSpace']
        if not flat:
            return answers.SIGNED_DISTANCE, ids, poses
        if ours.distance <= 0.0:
            return answers.PENETRATION, ids, poses
        k = flat[0]
        box = _box_below(bodies[1 - k], bodies[k])
        ids[k] = -ids[1 - k]  # ids of geometries are positive
        self._bodies.setdefault(ids[k], box)
        poses[k] = box.R, box.p
        return answers.SIGNED_DISTANCE, ids, poses


def _box_below(other: Body, flat: Body) -> Body:
    """Return a box whose top lies in the plane of a half space, and holds what is nearest."""
    normal, size = flat.R[:, 2], _BOX * (other.radius or 1.0)
    top = other.p - ((other.p - flat.p) @ normal) * normal
    return Body('Box', [size] * 3, R=flat.R, p=top - 0.5 * size * normal)


class _Fcl:
    """What is asked in the process: keeps bodies, and FCL's objects for pairs of them."""

    def __init__(self, bodies: Bodies) -> None:
        peer = fcl_peer.FclPeer(None)
        self._bodies = bodies

        @functools.lru_cache(maxsize=_PREPARED_PAIRS)
        def prepared(query: str, a: int, b: int) -> answers.Ask:
            return peer.pair(query, bodies[a].shape, bodies[b].shape)

        self._prepared = prepared

    def __call__(
        self, query: str, a: int, b: int, X_WA: Pose, X_WB: Pose, new: Mapping[int, Body]
    ) -> answers.PairAnswer | None:
        self._bodies.update(new)
        return self._prepared(query, a, b)(_transform(X_WA), _transform(X_WB))


def _transform(X: Pose) -> RigidTransform:
    R, p = X
    return RigidTransform(RotationMatrix(np.array(R)), p)
