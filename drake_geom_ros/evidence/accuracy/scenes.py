"""Whole scenes: bodies of all kinds in a heap, and two arms over a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.cases import PENETRATION, SIGNED_DISTANCE
from drake_geom_ros.evidence.accuracy.samples import Sample
from drake_geom_ros.evidence.accuracy.solids import Solid, random_rotation, random_solid
from drake_geom_ros.evidence.accuracy.timed import TimedScene
from drake_geom_ros.evidence.tolerances import EASY
from drake_geom_ros.evidence.truth import convex as truth
from drake_geom_ros.evidence.truth.supports import Floats, Pose

NEAR = 0.1  # [m] up to which distances are asked for
ROOM = 0.06  # [m^3] for each body of a heap: each has a few others within NEAR
KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid')
LINKS = (0.22, 0.24, 0.22, 0.2, 0.2, 0.14, 0.12)  # [m] from each joint to the next
WIDTH = 0.09  # [m] of each link
BENT = np.array([0.0, 1.0, 0.0, 1.0, 0.0, 0.9, 0.0])  # [rad] over the table


@dataclass(frozen=True, eq=False)
class Scene:
    """Solids at poses in World; ``name`` is what it is called, and its own family."""

    name: str
    solids: list[Solid]
    poses: list[Pose]
    queries: tuple[str, ...] = field(default=(SIGNED_DISTANCE, PENETRATION))

    def build(self) -> ours.Build:
        """Return the scene graph."""
        build = ours.Build()
        for solid in self.solids:
            build.add(solid)
        return build

    def timed(self) -> TimedScene:
        """Return the scene to be timed: it turns as a whole."""
        count = len(self.solids)
        return TimedScene(
            self.build(), self.poses, [0] * count, np.zeros((1, 3)), [False] * count, farthest=NEAR
        )

    def pairs(self, seed: int) -> Iterator[tuple[int, int, Sample]]:
        """Yield the pairs whose bounding balls are within NEAR, with their truth, in any order.

        Each comes with the numbers of its two solids.
        """
        reach = [solid.reach() for solid in self.solids]
        near = [
            (i, j)
            for i, j in combinations(range(len(self.solids)), 2)
            if np.linalg.norm(self.poses[i][1] - self.poses[j][1]) - reach[i] - reach[j] < NEAR
        ]
        for k in np.random.default_rng(seed).permutation(len(near)):
            i, j = near[k]
            yield i, j, self._sample(i, j)

    def answers(self, query: str, level: str) -> dict[tuple[int, int], ours.Answer]:
        """Return our answers to the whole scene, by the numbers of the solids."""
        build = self.build()
        asked = build.asked(self.poses)
        number = {each.get_value(): k for k, each in enumerate(build.ids)}
        if query == PENETRATION:
            found = asked.ComputePointPairPenetration(accuracy=level)
            distances = -found.depth
        else:
            found = asked.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            distances = found.distance
        keys = [(number[a], number[b]) for a, b in zip(found.id_A, found.id_B, strict=True)]
        columns = distances, found.error_bound, found.method
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return {key: ours.Answer(*row) for key, row in zip(keys, rows, strict=True)}

    def _sample(self, i: int, j: int) -> Sample:
        (a, b), (X_WA, X_WB) = (
            (self.solids[i], self.solids[j]),
            (self.poses[i], self.poses[j]),
        )
        phi, _ = truth.signed_distance(a.support(), X_WA, b.support(), X_WB)
        return Sample(a, b, X_WA, X_WB, phi, self.name)


def heap(count: int) -> Scene:
    """Return bodies of all kinds in turn, at random in a cube."""
    rng = np.random.default_rng(count)
    half = 0.5 * (ROOM * count) ** (1 / 3)
    solids = [random_solid(rng, KINDS[k % len(KINDS)]) for k in range(count)]
    poses = [(random_rotation(rng), rng.uniform(-half, half, 3)) for _ in range(count)]
    return Scene(f'{count} mixed bodies', solids, poses)


def two_arms() -> Scene:
    """Return two arms of seven links, bent towards each other over a table with boxes on it."""
    rng = np.random.default_rng(7)
    solids = [Solid('Box', (2.0, 1.4, 0.1))]
    poses: list[Pose] = [(np.eye(3), np.array([0.0, 0.0, -0.05]))]
    for _ in range(20):
        sizes = rng.uniform(0.05, 0.15, 3)
        turn = Rotation.from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)]).as_matrix()
        place = np.array([*rng.uniform((-0.9, -0.6), (0.9, 0.6)), sizes[2] / 2 + EASY])
        solids.append(Solid('Box', tuple(sizes.tolist())))
        poses.append((turn, place))
    for side in (-1.0, 1.0):
        angles = -side * BENT + rng.uniform(-0.25, 0.25, 7)
        poses += _arm(np.array([0.45 * side, 0.0, 0.06]), angles)
        solids += [
            Solid('Box', (WIDTH, WIDTH, length))
            if k % 2
            else Solid('Capsule', (WIDTH / 2, length))
            for k, length in enumerate(LINKS)
        ]
    return Scene('two arms', solids, poses)


def _arm(base: Floats, angles: Floats) -> list[Pose]:
    """Return the poses of the links' centres; joints turn about z and y in turn."""
    R, joint, poses = np.eye(3), base, []
    for k, (length, angle) in enumerate(zip(LINKS, angles, strict=True)):
        axis = np.array([0.0, 1.0, 0.0] if k % 2 else [0.0, 0.0, 1.0])
        R = R @ Rotation.from_rotvec(angle * axis).as_matrix()
        along = R @ [0.0, 0.0, length]
        poses.append((R, joint + 0.5 * along))
        joint = joint + along
    return poses


SCENES: dict[str, Callable[[], Scene]] = {
    '200 mixed bodies': partial(heap, 200),
    'two arms': two_arms,
}
