"""What can be measured: cases and whole scenes, seen alike.

A subject yields its samples batch by batch, tells our answers to one, and makes the scene that
is timed. Meshes as solids are one more class like these (``mesh_cases``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.cases import PENETRATION, Case
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS, Sample, sample, stream
from drake_geom_ros.evidence.accuracy.scenes import NEAR, Scene
from drake_geom_ros.evidence.accuracy.timed import TimedScene, side_by_side

TIMED_PAIRS = 120  # of a case in one scene: what a query costs once is shared by so many
SCENE_BATCH = 10  # pairs


class Subject(Protocol):
    """What ``Measurement`` needs to know."""

    name: str
    family: str
    queries: tuple[str, ...]

    def batches(self, seed: int) -> Iterator[list[Sample]]:
        """Yield samples with their truth, a few at a time; the same for the same seed."""

    def answers(self, sample: Sample, query: str) -> list[ours.Answer | None]:
        """Return our answer at each of ``ours.LEVELS``; None where nothing is reported."""

    def timed(self, query: str, known: Sequence[Sample]) -> tuple[TimedScene, int]:
        """Return a scene to be timed, and how many pairs its query answers."""


class CaseSubject:
    """A pair of shapes; a batch has one sample of each configuration."""

    def __init__(self, case: Case) -> None:
        self.name, self.family, self.queries = case.name, case.family, case.queries()
        self._case = case

    def batches(self, seed: int) -> Iterator[list[Sample]]:
        """Yield one pair of each configuration a time."""
        rng = stream(self.name, seed)
        while True:
            yield [sample(self._case, configuration, rng) for configuration in CONFIGURATIONS]

    def answers(self, sample: Sample, query: str) -> list[ours.Answer | None]:
        """Return our answers to the pair alone."""
        return ours.answers(sample, query)

    def timed(self, query: str, known: Sequence[Sample]) -> tuple[TimedScene, int]:
        """Return the samples side by side, each as often as it takes to be TIMED_PAIRS."""
        repeated = [known[k % len(known)] for k in range(TIMED_PAIRS)]
        return side_by_side(repeated), TIMED_PAIRS


class SceneSubject:
    """A whole scene, of which some pairs are samples."""

    def __init__(self, scene: Scene) -> None:
        self.name = self.family = scene.name
        self.queries = scene.queries
        self._scene = scene
        self._numbers: dict[int, tuple[int, int]] = {}
        self._found: dict[str, list[dict[tuple[int, int], ours.Answer]]] = {}

    def batches(self, seed: int) -> Iterator[list[Sample]]:
        """Yield pairs whose bounding balls are near, in random order, until there are no more."""
        batch: list[Sample] = []
        for i, j, pair in self._scene.pairs(seed):
            self._numbers[id(pair)] = i, j
            batch.append(pair)
            if len(batch) == SCENE_BATCH:
                yield batch
                batch = []
        if batch:
            yield batch

    def answers(self, sample: Sample, query: str) -> list[ours.Answer | None]:
        """Return what the query of the whole scene says about the pair."""
        if query not in self._found:
            self._found[query] = [self._scene.answers(query, level) for level in ours.LEVELS]
        key = self._numbers[id(sample)]
        return [found.get(key) for found in self._found[query]]

    def timed(self, query: str, known: Sequence[Sample]) -> tuple[TimedScene, int]:
        """Return the scene, which turns as a whole, and its pairs within NEAR, or in contact."""
        scene = self._scene.timed()
        return scene, scene.found(NEAR if query != PENETRATION else 0.0)
