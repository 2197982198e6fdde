"""What can be measured: pairs (``cases``, ``mesh_cases``), and whole scenes (``scenes``), alike.

A subject yields its samples batch by batch, tells our answers to one, and makes the scene that
is timed.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.ours import PENETRATION, POINTS, SIGNED_DISTANCE
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS, stream
from drake_geom_ros.evidence.accuracy.timed import TimedScene, side_by_side
from drake_geom_ros.evidence.bodies import Body
from drake_geom_ros.evidence.hard_cases.cases import Case


class Subject(Protocol):
    """What ``Measurement`` needs to know."""

    name: str
    family: str  # the panel that it is drawn in
    queries: tuple[str, ...]

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield samples with their truth, a few at a time; the same for the same seed."""

    def answers(self, sample: Case, query: str) -> list[ours.Answer | None]:
        """Return our answer at each of ``ours.LEVELS``; None where nothing is reported."""

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return a scene to be timed, and how many pairs its query answers."""


@dataclass(frozen=True)
class PairSubject:
    """A pair of shapes by name; a batch has one sample of each configuration."""

    a: str
    b: str
    timed_pairs: ClassVar[int]  # in one scene

    @property
    def queries(self) -> tuple[str, ...]:
        """The queries that the pair is asked."""
        return (POINTS,) if self.a == 'Point' else (SIGNED_DISTANCE, PENETRATION)

    @abstractmethod
    def bodies(self, rng: np.random.Generator) -> tuple[Body, Body]:
        """Return both bodies, with random sizes."""

    @abstractmethod
    def sample(self, configuration: str, rng: np.random.Generator) -> Case:
        """Return both bodies at random poses in a configuration, with their truth."""

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield one pair of each configuration a time."""
        rng = stream(self.name, seed)
        while True:
            yield [self.sample(configuration, rng) for configuration in CONFIGURATIONS]

    def answers(self, sample: Case, query: str) -> list[ours.Answer | None]:
        """Return our answers to the pair alone."""
        return ours.answers(sample, query)

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return the samples side by side, each as often as it takes to be enough of them."""
        samples = [known[k % len(known)] for k in range(self.timed_pairs)]
        return side_by_side(samples), self.timed_pairs
