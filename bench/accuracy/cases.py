"""What is measured: pairs of shapes here, solids (``mesh_cases``), whole scenes (``scenes``).

A subject yields its samples batch by batch, tells our answers to one, and makes the scene that
is timed. Another convex shape is one more entry here; what has dents has a truth of its own.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from itertools import combinations_with_replacement
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from bench.accuracy.samples import CONFIGURATIONS, convex_sample, stream
from bench.accuracy.timed import TimedScene, side_by_side
from drake_geom_ros.cross_check.bodies import PRIMITIVES, Body
from drake_geom_ros.geometry import ArgumentError
from truth.bodies.random_bodies import random_body
from truth.hard_cases.cases import Case
from truth.judging.asking import (
    PENETRATION,
    POINTS,
    SIGNED_DISTANCE,
    Certified,
    certified,
)

RESOLUTIONS = (8, 64, 500)  # vertices of a hull
QUICK_RESOLUTIONS = (64,)


class Subject(Protocol):
    """What ``Measurement`` needs to know."""

    name: str
    family: str  # the panel that it is drawn in
    queries: tuple[str, ...]

    def batches(self, seed: int) -> Iterator[list[Case]]:
        """Yield samples with their truth, a few at a time; the same for the same seed."""

    def answers(self, sample: Case, query: str) -> list[Certified | None]:
        """Return our answer at each of ``LEVELS``; None where nothing is reported."""

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

    def answers(self, sample: Case, query: str) -> list[Certified | None]:
        """Return our answers to the pair alone."""
        return certified(sample, query)

    def timed(self, query: str, known: Sequence[Case]) -> tuple[TimedScene, int]:
        """Return the samples side by side, each as often as it takes to be enough of them."""
        samples = [known[k % len(known)] for k in range(self.timed_pairs)]
        return side_by_side(samples), self.timed_pairs


_S = TypeVar('_S', bound=PairSubject)


@dataclass(frozen=True)
class ShapePair(PairSubject):
    """A pair of shapes by their public names; ``corners`` are those of each hull among them."""

    corners: int = 0
    timed_pairs = 120  # what a query costs once is shared by so many

    @property
    def name(self) -> str:
        """How the case is called, as ``Box-Convex64``."""
        return '-'.join(
            f'{kind}{self.corners}' if kind in ('Convex', 'Mesh') else kind
            for kind in (self.a, self.b)
        )

    @property
    def family(self) -> str:
        """The panel that the case is drawn in."""
        kinds = {self.a, self.b}
        if self.a == 'Point':
            return f'points to hulls, {self.corners} vertices' if self.corners else 'points'
        for kind, words in (('Mesh', 'meshes as hulls'), ('Convex', 'hulls')):
            if kind in kinds:
                return f'{words}, {self.corners} vertices'
        for kind, words in (
            ('HalfSpace', 'half spaces'),
            ('Sphere', 'spheres with primitives'),
            ('Ellipsoid', 'ellipsoids'),
            ('Cylinder', 'cylinders'),
        ):
            if kind in kinds:
                return words
        return 'boxes and capsules'

    def bodies(self, rng: np.random.Generator) -> tuple[Body, Body]:
        """Return both bodies, with random sizes."""
        return random_body(rng, self.a, self.corners), random_body(rng, self.b, self.corners)

    def sample(self, configuration: str, rng: np.random.Generator) -> Case:
        """Return both bodies at random poses in a configuration."""
        return convex_sample(*self.bodies(rng), configuration, rng)


def all_cases(resolutions: Sequence[int] = RESOLUTIONS) -> list[ShapePair]:
    """Return every pair of shapes that has a signed distance, hulls in all resolutions."""
    pairs = [p for p in combinations_with_replacement(PRIMITIVES, 2) if p != ('HalfSpace',) * 2]
    cases = [ShapePair(a, b) for a, b in pairs]
    for corners in resolutions:
        cases += [ShapePair(kind, 'Convex', corners) for kind in (*PRIMITIVES, 'Convex')]
    # A mesh is answered as its hull: two pairs tell whether that costs anything.
    cases += [
        ShapePair(kind, 'Mesh', corners) for corners in resolutions for kind in ('Box', 'Mesh')
    ]
    cases += [ShapePair('Point', kind) for kind in PRIMITIVES]
    cases += [ShapePair('Point', 'Convex', corners) for corners in resolutions]
    return cases


def chosen(cases: Sequence[_S], patterns: Sequence[str]) -> list[_S]:
    """Return the cases whose names match one of the patterns (``Box-*``), all without any.

    Raises ArgumentError for a pattern that matches none.
    """
    for pattern in patterns:
        if not any(fnmatch(case.name, pattern) for case in cases):
            names = ', '.join(case.name for case in cases)
            raise ArgumentError(f'--cases {pattern}: no case is called so; there are: {names}')
    return [case for case in cases if not patterns or any(fnmatch(case.name, p) for p in patterns)]


def round_robin(cases: Sequence[_S]) -> list[_S]:
    """Return the cases so that the families take turns: a run cut short has seen all of them."""
    ranks: Counter[str] = Counter()
    ranked = []
    for case in cases:
        ranked.append((ranks[case.family], case))
        ranks[case.family] += 1
    return [case for _, case in sorted(ranked, key=lambda each: each[0])]
