"""Pairs on chains of frames: the same laws, where poses are compositions.

What the bodies' poses truly are is composed of X_PF, as the scene took them, and X_FG in extended
precision, whose digits reach eleven bits further than those of the engine.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.searches.hunting.scene import PairsScene
from drake_geom_ros.cross_check.bodies import Body, Pair, Pose
from drake_geom_ros.geometry import FrameId, FramePoseVector, GeometryFrame
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_rotation

LINKS = (1, 2, 4)  # frames between World and the frame that carries the geometry
POSES = 40  # of links, in any order
REACHES = (0.0, 7.0)  # decades [m] of a link's length


class ChainedScene(PairsScene):
    """A scene in which every body is the tip of a chain of frames of its own."""

    def __init__(self, pairs: Sequence[Pair], rng: np.random.Generator) -> None:
        self._rng = rng
        self._reach = float(10.0 ** rng.uniform(*REACHES))
        self._poses = [self._any_pose() for _ in range(POSES)]
        self._chains: list[list[FrameId]] = []
        self._tips: list[RigidTransform] = []
        super().__init__(pairs)

    def _add(self, body: Body) -> None:
        chain, name = [], f'{len(self.ids)}.'
        for link in range(int(self._rng.choice(LINKS)) + 1):
            parent = chain[-1] if chain else self.graph.world_frame_id()
            frame = GeometryFrame(f'{name}{link}')
            chain.append(self.graph.RegisterFrame(self.source, parent, frame))
        X_FG = self._any_pose() if self._rng.random() < 0.5 else RigidTransform()
        self._chains.append(chain)
        self._tips.append(X_FG)
        self._register(chain[-1], body, X_FG)

    def _any_pose(self) -> RigidTransform:
        R = RotationMatrix(random_rotation(self._rng))
        return RigidTransform(R, self._reach * self._rng.normal(size=3))

    def place(self, pairs: Sequence[Pair]) -> Sequence[Pair]:
        """Pose the chains so that bodies are where they should, but for rounding.

        Returns the pairs as they are then, seen from A's origin.
        """
        poses = {}
        bodies = [one for pair in pairs for one in (pair.a, pair.b)]
        for body, chain, X_FG in zip(bodies, self._chains, self._tips, strict=True):
            X_WL = RigidTransform()
            for frame in chain[:-1]:
                poses[frame] = self._poses[self._rng.integers(POSES)]
                X_WL = X_WL @ poses[frame]
            last = X_WL.inverse() @ body.pose @ X_FG.inverse()
            R = RotationMatrix.ProjectToRotationMatrix(last.rotation().matrix())
            poses[chain[-1]] = RigidTransform(R, last.translation())
        port = self.graph.get_source_pose_port(self.source)
        port.FixValue(self._context, FramePoseVector(poses))
        truly = [self._true_pose(*each) for each in zip(self._chains, self._tips, strict=True)]
        self.origins[:] = [p for _, p in truly[::2]]
        return [
            _seen_from_a(pair, *X) for pair, *X in zip(pairs, truly[::2], truly[1::2], strict=True)
        ]

    def _true_pose(self, chain: list[FrameId], X_FG: RigidTransform) -> Pose:
        R, p = np.eye(3, dtype=np.longdouble), np.zeros(3, dtype=np.longdouble)
        for X in (*(self.query.X_PF(frame) for frame in chain), X_FG):
            p = p + R @ X.translation().astype(np.longdouble)
            R = R @ X.rotation().matrix().astype(np.longdouble)
        return R, p


def _seen_from_a(pair: Pair, X_WA: Pose, X_WB: Pose) -> Pair:
    a = pair.a.placed(X_WA[0], np.zeros(3))
    return Pair(a, pair.b.placed(X_WB[0], X_WB[1] - X_WA[1]))
