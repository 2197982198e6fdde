"""What can be measured: cases, and whole scenes (``scenes``), seen alike.

A subject yields its samples batch by batch, tells our answers to one, and makes the scene that
is timed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.cases import ShapePair
from drake_geom_ros.evidence.accuracy.mesh_cases import MeshPair
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS, stream
from drake_geom_ros.evidence.accuracy.timed import TimedScene, side_by_side
from drake_geom_ros.evidence.hard_cases.cases import Case


class Subject(Protocol):
    """What ``Measurement`` needs to know."""

    name: str
    family: str
    queries: tuple[str, ...]

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield samples with their truth, a few at a time; the same for the same seed."""

    def answers(self, sample: Case, query: str) -> list[ours.Answer | None]:
        """Return our answer at each of ``ours.LEVELS``; None where nothing is reported."""

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return a scene to be timed, and how many pairs its query answers."""


class CaseSubject:
    """A pair of shapes; a batch has one sample of each configuration."""

    def __init__(self, case: ShapePair | MeshPair) -> None:
        self.name, self.family, self.queries = case.name, case.family, case.queries()
        self._case = case

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield one pair of each configuration a time."""
        rng = stream(self.name, seed)
        while True:
            yield [self._case.sample(configuration, rng) for configuration in CONFIGURATIONS]

    def answers(self, sample: Case, query: str) -> list[ours.Answer | None]:
        """Return our answers to the pair alone."""
        return ours.answers(sample, query)

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return the samples side by side, each as often as it takes to be enough of them."""
        pairs = self._case.timed_pairs
        return side_by_side([known[k % len(known)] for k in range(pairs)]), pairs
