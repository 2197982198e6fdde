"""Second opinion by FCL in a process that it may crash or hang, with verdicts."""

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
MOST_LOST = 3  # processes that a pair may cost before it is not checked any more
# Edge of a box in place of a half space, in radii of the other body: 2 include the nearest point,
# and FCL is less accurate for wider ones (spheres, capsules: 8e-5 m off with 3, 1e-3 m with 20).
_BOX = 3.0
_PREPARED_PAIRS = 1024  # pairs whose FCL objects are cached

Bodies = dict[int, Body]
Ask = Callable[[str, int, int, Pose, Pose, Mapping[int, Body]], Any]


def why_silent(questioned: QuestionedShape) -> str:
    """Return why FCL does not support a sensed map; empty if it does."""
    if isinstance(questioned.shape, PointCloud):
        return 'FCL has no balls of a cloud'
    if isinstance(questioned.shape, OccupiedCells):
        if questioned.is_grown:
            return "FCL knows nothing of ('map', 'margin')"
        if not fcl_peer.is_octree(questioned.shape):
            return 'the cells do not lie on the grid of an octree'
    return ''


def body_of(questioned: QuestionedShape) -> Body:
    """Return the body of a shape, at the origin."""
    shape = questioned.shape
    if isinstance(shape, OccupiedCells):
        return Body('OccupiedCells', (shape.resolution(), shape.centres()))
    if questioned.is_solid:
        vertices, triangles = shape.surface()  # type: ignore[attr-defined]
        return Body('Solid', vertices, triangles=triangles)
    kind = kind_of(shape)
    if kind == 'Convex':
        return Body(kind, shape.hull_surface()[0])  # type: ignore[attr-defined]
    return Body(kind, measures(shape))


class SecondOpinion:
    """Checks answers by FCL, for one version of a scene at a time."""

    def __init__(self, make: Callable[[Bodies], Ask] | None = None, limit: float = LIMIT) -> None:
        """Make the querying function by ``make(bodies)`` in the child process; default: FCL."""
        made = make or _Fcl
        self.library = LIBRARY if make else f'{LIBRARY} {metadata.version(LIBRARY)}'
        self._limit = limit
        self._version = -1
        self._bodies: Bodies = {}
        self._silent: dict[int, str] = {}  # reasons why geometries have no body
        self._sent: set[int] = set()  # ids whose bodies the process has
        self._losses: Counter[tuple[int, int]] = Counter()  # lost processes by pair
        self._process = LostProcess(lambda: made(dict(self._bodies)))

    def judge(self, batch: QuestionBatch) -> list[Verdict]:
        """Return the verdicts on the questions of a batch."""
        if batch.version != self._version:
            self.close()
            self._version, self._bodies, self._losses = batch.version, {}, Counter()
            self._silent = {}
        for value, questioned in batch.shapes.items():
            if reason := why_silent(questioned):
                self._silent[value] = reason
                continue
            with contextlib.suppress(MeshFileError):  # a mesh file that has changed
                self._bodies[value] = body_of(questioned)
        return [self._judged(question) for question in batch.questions]

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def _judged(self, question: PairQuestion) -> Verdict:
        for reason in (self._silent[value] for value in question.ids if value in self._silent):
            return Verdict(SILENT, text=reason)
        if not self._bodies.keys() >= set(question.ids):
            return Verdict(SILENT, text='a mesh file cannot be read')
        if self._losses[question.ids] >= MOST_LOST:
            return Verdict(SILENT, text=f'not asked: it was lost {MOST_LOST} times')
        pair = Pair(
            self._bodies[question.ids[0]].placed(*question.X_WA),
            self._bodies[question.ids[1]].placed(*question.X_WB),
        )
        if pair.has_map and 'HalfSpace' in (pair.a.kind, pair.b.kind):
            return Verdict(SILENT, text='FCL tells nothing of an octree and a half space')
        query, ids, poses = self._query(pair, question)
        if not self._process.is_running:
            self._sent = set(self._bodies)  # the process is forked from this one
        new = {value: self._bodies[value] for value in ids if value not in self._sent}
        self._sent |= new.keys()
        outcome = self._process.ask(self._limit, query, *ids, *poses, new)
        if outcome.is_lost:
            self._losses[question.ids] += 1
            return Verdict(LOST, text=f'{outcome.end} ({outcome.value})')
        if outcome.end != ANSWER:
            return Verdict(SILENT, text=str(outcome.value))
        return judged(pair, question, outcome.value, self.library)

    def _query(self, pair: Pair, question: PairQuestion) -> tuple[str, list[int], list[Pose]]:
        """Return the query for FCL, with ids of bodies and their poses.

        FCL's signed distance crashes the process for half spaces, but its contacts work. If the
        bodies are apart, a box below the other body replaces the half space.
        """
        ids, poses = list(question.ids), [question.X_WA, question.X_WB]
        bodies = pair.a, pair.b
        flat = [k for k, body in enumerate(bodies) if body.kind == 'HalfSpace']
        if not flat:
            return answers.SIGNED_DISTANCE, ids, poses
        if question.distance <= 0.0:
            return answers.PENETRATION, ids, poses
        k = flat[0]
        box = _box_below(bodies[1 - k], bodies[k])
        ids[k] = -ids[1 - k]  # ids of geometries are positive
        self._bodies.setdefault(ids[k], box)
        poses[k] = box.R, box.p
        return answers.SIGNED_DISTANCE, ids, poses


def _box_below(other: Body, flat: Body) -> Body:
    """Return a box with its top in the plane of a half space, which includes the nearest point."""
    normal, size = flat.R[:, 2], _BOX * (other.radius or 1.0)
    top = other.p - ((other.p - flat.p) @ normal) * normal
    return Body('Box', [size] * 3, R=flat.R, p=top - 0.5 * size * normal)


class _Fcl:
    """Querying function in the child process, with caches of bodies and FCL objects."""

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
