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
from drake_geom_ros.evidence.accuracy.cases import PENETRATION, POINTS, SIGNED_DISTANCE
from drake_geom_ros.evidence.accuracy.ours import Build
from drake_geom_ros.evidence.accuracy.samples import Sample
from drake_geom_ros.evidence.accuracy.solids import Solid
from drake_geom_ros.evidence.truth.supports import Floats, Pose

SPACING = 4.0  # [m] between the pairs of a scene of samples: none of them meets its neighbours
FARTHEST = 0.5  # [m] up to which distances are asked for there: all pairs, but no neighbours


class Seconds(NamedTuple):
    """Seconds a pair: of all that a query takes, and of its kernels alone."""

    whole: float
    kernels: float


class TimedScene:
    """A scene that is posed and asked again and again.

    Every cycle turns each group of bodies anew about its cell, at random: no answer and no hint
    of the last cycle helps. ``poses`` are those of the bodies in their groups; ``points`` (n,)
    says which of them are query points.
    """

    def __init__(
        self,
        build: Build,
        poses: Sequence[Pose],
        groups: Sequence[int],
        cells: Floats,
        points: Sequence[bool],
        yaw_only: bool = False,
        farthest: float = FARTHEST,
    ) -> None:
        self._Rs = np.array([R for R, _ in poses])
        self._ps = np.array([p for _, p in poses])
        self._groups, self._cells = np.array(groups), cells
        self._is_point, self._yaw_only, self._farthest = np.array(points), yaw_only, farthest
        self._ids = np.array([frame.get_value() for frame in build.frames])
        self._context = build.graph.CreateDefaultContext()
        self._port = build.graph.get_source_pose_port(build.source)
        self._asked = build.graph.get_query_output_port().Eval(self._context)

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
        if query == PENETRATION:
            overlaps = self._asked.ComputePointPairPenetration(accuracy=level)
            return overlaps.depth, overlaps.p_WCa, overlaps.nhat_BA_W
        pairs = self._asked.ComputeSignedDistancePairwiseClosestPoints(
            self._farthest, accuracy=level
        )
        return pairs.distance, pairs.p_WCa, pairs.nhat_BA_W


def side_by_side(samples: Sequence[Sample]) -> TimedScene:
    """Return a scene of samples of one case, far from each other.

    A half space would meet all neighbours: there is one for all, which does not move, and pairs
    turn about its normal only.
    """
    build, poses, groups, points = Build(), [], [], []
    flat = 'HalfSpace' in (samples[0].a.kind, samples[0].b.kind)
    if flat:
        build.add(Solid('HalfSpace'), anchored=True)
    for group, sample in enumerate(samples):
        bodies = [(sample.a, sample.X_WA), (sample.b, sample.X_WB)]
        base = next((X for solid, X in bodies if solid.kind == 'HalfSpace'), sample.X_WA)
        for solid, X in bodies:
            if solid.kind == 'HalfSpace':
                continue
            if solid.kind != 'Point':
                build.add(solid)
            poses.append(_within(base, X))
            groups.append(group)
            points.append(solid.kind == 'Point')
    return TimedScene(build, poses, groups, _lattice(len(samples), flat), points, flat)


def _within(X_WF: Pose, X_WG: Pose) -> Pose:
    """Return X_FG."""
    (R_WF, p_WF), (R_WG, p_WG) = X_WF, X_WG
    return R_WF.T @ R_WG, R_WF.T @ (p_WG - p_WF)


def _lattice(count: int, flat: bool) -> Floats:
    """Return places (count, 3) [m] of a cubic, or flat, lattice about the origin."""
    dimensions = 2 if flat else 3
    side = int(np.ceil(round(count ** (1 / dimensions), 6)))
    grid = np.indices((side,) * dimensions).reshape(dimensions, -1).T[:count] - (side - 1) / 2
    places: Floats = SPACING * np.pad(grid, ((0, 0), (0, 3 - dimensions)))
    return places
