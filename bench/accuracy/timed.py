"""The time of our queries, on scenes that hold many pairs: poses, query and results.

Times are those of the processor in the one thread that computes, so that other programs of a
busy machine do not count.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros import geometry
from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.math.array_types import Floats
from truth.judging.asking import POINTS, SIGNED_DISTANCE, BodyScene, asked_for

SPACING = 4.0  # [m] between the pairs of a scene of samples: none of them meets its neighbours
FARTHEST = 0.5  # [m] up to which distances are asked for there: all pairs, but no neighbours


class Seconds(NamedTuple):
    """Seconds a pair: of all that a query takes, and of its kernels alone."""

    whole: float
    kernels: float


class TimedScene:
    """A scene that is posed and asked again and again.

    Every cycle turns each group of bodies anew about its cell, at random: no answer and no hint
    of the last cycle helps. ``bodies`` are at their poses in their groups, Points among them are
    query points.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        groups: Sequence[int],
        cells: Floats,
        floor: Sequence[Body] = (),
        farthest: float = FARTHEST,
    ) -> None:
        self._Rs, self._ps = (np.array([getattr(body, x) for body in bodies]) for x in 'Rp')
        self._groups, self._cells = np.array(groups), cells
        self._is_point = np.array([body.kind == 'Point' for body in bodies])
        self._yaw_only, self._farthest = bool(floor), farthest
        scene = BodyScene([body for body in bodies if body.kind != 'Point'], floor)
        self._ids = np.array([frame.get_value() for frame in scene.frames])
        self._context = scene.graph.CreateDefaultContext()
        self._port = scene.graph.get_source_pose_port(scene.source)
        self._asked = scene.asked(self._context)

    def cycle(self, query: str, level: str, rng: np.random.Generator, pairs: int) -> Seconds:
        """Pose, ask, read the arrays; return what that took for each of ``pairs``."""
        angles = rng.uniform(-np.pi, np.pi, (len(self._cells), 3))
        angles[:, :2] *= not self._yaw_only
        turns = Rotation.from_euler('xyz', angles).as_matrix()[self._groups]
        ps = self._cells[self._groups] + np.einsum('kij,kj->ki', turns, self._ps)
        quaternions = Rotation.from_matrix(turns @ self._Rs).as_quat()
        poses = np.hstack([ps, quaternions])[~self._is_point]
        start, clock = time.thread_time(), time.perf_counter()
        vector = geometry.FramePoseVector.FromArrays(self._ids, poses)
        self._port.FixValue(self._context, vector)
        self._ask(query, level, ps[self._is_point])
        passed = time.perf_counter() - clock
        taken = (time.thread_time() - start) / pairs
        # The engine reads the clock: of it, the kernels' share.
        return Seconds(taken, taken * self._asked.effects().seconds['narrowphase'] / passed)

    def found(self, distance: float) -> int:
        """Return how many pairs are no farther apart [m] when all are turned at random."""
        self.cycle(SIGNED_DISTANCE, 'exact', np.random.default_rng(0), 1)
        pairs = self._asked.ComputeSignedDistancePairwiseClosestPoints(distance, accuracy='exact')
        return len(pairs)

    def _ask(self, query: str, level: str, points: Floats) -> tuple[Floats, Floats, Floats]:
        if query == POINTS:
            found = self._asked.ComputeSignedDistanceToPoint(
                points, self._farthest, accuracy=level
            )
            return found.distance, found.p_GN, found.grad_W
        pairs, distances = asked_for(self._asked, query, level, self._farthest)
        return distances, pairs.p_WCa, pairs.nhat_BA_W


def side_by_side(samples: Sequence[Pair]) -> TimedScene:
    """Return a scene of samples of one case, far from each other.

    A half space would meet all neighbours: there is one for all, which does not move, and pairs
    turn about its normal only.
    """
    bodies, groups = list[Body](), list[int]()
    flat = 'HalfSpace' in (samples[0].a.kind, samples[0].b.kind)
    for group, sample in enumerate(samples):
        base = sample.b if sample.b.kind == 'HalfSpace' else sample.a
        for body in (sample.a, sample.b):
            if body.kind != 'HalfSpace':
                bodies.append(body.moved(base.R.T, -base.R.T @ base.p))
                groups.append(group)
    floor = [Body('HalfSpace')] if flat else []
    return TimedScene(bodies, groups, _lattice(len(samples), flat), floor)


def _lattice(count: int, flat: bool) -> Floats:
    """Return places (count, 3) [m] of a cubic, or flat, lattice about the origin."""
    dimensions = 2 if flat else 3
    side = int(np.ceil(round(count ** (1 / dimensions), 6)))
    grid = np.indices((side,) * dimensions).reshape(dimensions, -1).T[:count] - (side - 1) / 2
    places: Floats = SPACING * np.pad(grid, ((0, 0), (0, 3 - dimensions)))
    return places
