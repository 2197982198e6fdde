"""Whole scenes: bodies of all kinds in a heap, and two arms over a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from bench.accuracy.samples import known
from bench.accuracy.timed import TimedScene
from drake_geom_ros.cross_check.bodies import BOUNDED, Body
from truth.bodies import arms
from truth.bodies.random_bodies import random_body, random_rotation
from truth.hard_cases.cases import Case
from truth.judging.asking import (
    LEVELS,
    PENETRATION,
    SIGNED_DISTANCE,
    BodyScene,
    Certified,
    asked_for,
    rows,
)
from truth.references import convex

NEAR = 0.1  # [m] up to which distances are asked for
BATCH = 10  # pairs
ROOM = 0.06  # [m^3] for each body of a heap: each has a few others within NEAR


class Scene:
    """A whole scene as a subject, of which some pairs are samples; its name is its family.

    Bodies are at their poses in World.
    """

    def __init__(self, name: str, bodies: list[Body]) -> None:
        self.name = self.family = name
        self.queries: tuple[str, ...] = (SIGNED_DISTANCE, PENETRATION)
        self.bodies = bodies
        self._numbers: dict[int, tuple[int, int]] = {}  # of the bodies of a sample
        self._found: dict[str, list[dict[tuple[int, int], Certified]]] = {}

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield pairs whose bounding balls are near, in random order, until there are no more."""
        near = [
            (i, j)
            for (i, a), (j, b) in combinations(enumerate(self.bodies), 2)
            if np.linalg.norm(a.p - b.p) - a.radius - b.radius < NEAR
        ]
        order = np.random.default_rng(seed).permutation(len(near)).tolist()
        for start in range(0, len(order), BATCH):
            yield [self._sample(*near[k]) for k in order[start : start + BATCH]]

    def _sample(self, i: int, j: int) -> Case:
        a, b = self.bodies[i], self.bodies[j]
        phi, _ = convex.signed_distance(a, b)
        pair = known(a, b, phi, self.name)
        self._numbers[id(pair)] = i, j
        return pair

    def answers(self, sample: Case, query: str) -> list[Certified | None]:
        """Return what the query of the whole scene says about the pair."""
        if query not in self._found:
            self._found[query] = [self._answers(query, level) for level in LEVELS]
        key = self._numbers[id(sample)]
        return [found.get(key) for found in self._found[query]]

    def _answers(self, query: str, level: str) -> dict[tuple[int, int], Certified]:
        """Return our answers to the whole scene, by the numbers of the bodies."""
        scene = BodyScene(self.bodies)
        number = {each.get_value(): k for k, each in enumerate(scene.ids)}
        found, distances = asked_for(scene.asked(), query, level)
        keys = [(number[a], number[b]) for a, b in zip(found.id_A, found.id_B, strict=True)]
        return dict(zip(keys, rows(found, distances), strict=True))

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return the scene, which turns as a whole, and its pairs within NEAR, or in contact."""
        one_group, at_origin = [0] * len(self.bodies), np.zeros((1, 3))
        scene = TimedScene(self.bodies, one_group, at_origin, farthest=NEAR)
        return scene, scene.found(NEAR if query != PENETRATION else 0.0)


def heap(count: int) -> Scene:
    """Return bodies of all kinds in turn, at random in a cube."""
    rng = np.random.default_rng(count)
    half = 0.5 * (ROOM * count) ** (1 / 3)
    shapes = [random_body(rng, BOUNDED[k % len(BOUNDED)]) for k in range(count)]
    bodies = [each.placed(random_rotation(rng), rng.uniform(-half, half, 3)) for each in shapes]
    return Scene(f'{count} mixed bodies', bodies)


def two_arms() -> Scene:
    """Return two arms of seven links, bent towards each other over a table with boxes on it."""
    rng = np.random.default_rng(7)
    table = arms.table(rng)
    angles = arms.BENT + rng.uniform(-arms.SWING, arms.SWING, (2, 7))
    return Scene('two arms', [*table, *arms.posed_links(angles)])


SCENES: dict[str, Callable[[], Scene]] = {
    '200 mixed bodies': partial(heap, 200),
    'two arms': two_arms,
}
