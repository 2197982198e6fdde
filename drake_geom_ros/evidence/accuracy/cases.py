"""What is measured: the list of cases. A case is a pair of shapes and a family to be drawn in.

Another convex shape is one more entry here; what has dents is in ``mesh_cases``, with a truth of
its own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from itertools import combinations_with_replacement
from typing import TypeVar

import numpy as np

from drake_geom_ros.evidence.accuracy.samples import convex_sample
from drake_geom_ros.evidence.accuracy.subjects import PairSubject
from drake_geom_ros.evidence.bodies import Body
from drake_geom_ros.evidence.hard_cases.cases import Case
from drake_geom_ros.evidence.random_bodies import random_body
from drake_geom_ros.geometry import ArgumentError

PRIMITIVES = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'HalfSpace')
RESOLUTIONS = (8, 64, 500)  # vertices of a hull
QUICK_RESOLUTIONS = (64,)


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
