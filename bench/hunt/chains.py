"""Pairs on chains of frames: the same laws, where poses are compositions.

What the bodies' poses truly are is composed of X_PF, as the scene took them, and X_FG in extended
precision, whose digits reach eleven bits further than those of the engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.hard_cases.cases import Body, Case, Floats
from bench.hunt.scene import PairsScene
from drake_geom_ros.accuracy.solids import random_rotation
from drake_geom_ros.geometry import FrameId, GeometryFrame
from drake_geom_ros.math import RigidTransform, RotationMatrix

LINKS = (1, 2, 4)  # frames between World and the frame that carries the geometry
POSES = 40  # of links, in any order
REACHES = (0.0, 7.0)  # decades [m] of a link's length

Pose = tuple[Floats, Floats]  # R (3, 3), p (3,)


class ChainedScene(PairsScene):
    """A scene in which every body is the tip of a chain of frames of its own."""

    def __init__(self, cases: Sequence[Case], rng: np.random.Generator) -> None:
        self._rng = rng
        self._reach = float(10.0 ** rng.uniform(*REACHES))
        self._poses = [self._any_pose() for _ in range(POSES)]
        self._chains: list[list[FrameId]] = []
        self._tips: list[RigidTransform] = []
        super().__init__(cases)

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

    def pose(self, cases: Sequence[Case]) -> Sequence[Case]:
        """Pose the chains so that bodies are where they should, but for rounding.

        Returns the pairs as they are then, seen from A's origin.
        """
        poses = {}
        bodies = [one for case in cases for one in (case.a, case.b)]
        for body, chain, X_FG in zip(bodies, self._chains, self._tips, strict=True):
            X_WL = RigidTransform()
            for frame in chain[:-1]:
                poses[frame] = self._poses[self._rng.integers(POSES)]
                X_WL = X_WL @ poses[frame]
            last = X_WL.inverse() @ body.pose @ X_FG.inverse()
            R = RotationMatrix.ProjectToRotationMatrix(last.rotation().matrix())
            poses[chain[-1]] = RigidTransform(R, last.translation())
        self._fix(poses)
        truly = [self._true_pose(*each) for each in zip(self._chains, self._tips, strict=True)]
        self.origins[:] = [p for _, p in truly[::2]]
        return [
            _seen_from_a(case, *pair)
            for case, *pair in zip(cases, truly[::2], truly[1::2], strict=True)
        ]

    def _true_pose(self, chain: list[FrameId], X_FG: RigidTransform) -> Pose:
        R, p = np.eye(3, dtype=np.longdouble), np.zeros(3, dtype=np.longdouble)
        for X in (*(self.query.X_PF(frame) for frame in chain), X_FG):
            p = p + R @ X.translation().astype(np.longdouble)
            R = R @ X.rotation().matrix().astype(np.longdouble)
        return R, p


def _seen_from_a(case: Case, X_WA: Pose, X_WB: Pose) -> Case:
    a = replace(case.a, R=X_WA[0].astype(float), p=np.zeros(3))
    b = replace(case.b, R=X_WB[0].astype(float), p=(X_WB[1] - X_WA[1]).astype(float))
    return replace(case, a=a, b=b)
