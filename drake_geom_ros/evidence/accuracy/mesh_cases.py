"""Cases with a mesh as a solid, and their samples: poses from a point of its surface.

A point f of the surface is chosen, in a triangle, on a side or at a vertex, and a direction n out
of the solid there; the other body is put where it ends ``gap`` from f along n. That this is their
distance is asked of ``mesh_truth``: in a dent another wall may be nearer, and then the sample is
drawn again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.cases import PENETRATION, POINTS, SIGNED_DISTANCE
from drake_geom_ros.evidence.accuracy.mesh_bodies import CUTS, MeshBody, mesh_body
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS, Sample, farthest_point, stream
from drake_geom_ros.evidence.accuracy.solids import Solid, random_rotation, random_solid
from drake_geom_ros.evidence.accuracy.timed import TimedScene, side_by_side
from drake_geom_ros.evidence.tolerances import AS_PLACED
from drake_geom_ros.evidence.truth import meshes as mesh_truth
from drake_geom_ros.evidence.truth.supports import Floats, Pose

# Of a case in one scene, each of which brings all its triangles.
TIMED_PAIRS = 12
DEEPEST = 0.04  # [m] that an origin is inside, in what is contained
# What meets which body: boxes tell the truth about the L only.
PARTNERS = {'L': ('Point', 'Sphere', 'Box', 'L'), 'Ball': ('Point', 'Sphere')}


@dataclass(frozen=True)
class MeshCase:
    """A shape, by its public name or that of a mesh body, and a mesh as a solid."""

    a: str
    b: str
    resolution: int

    @property
    def name(self) -> str:
        """How the case is called, as ``Sphere-L1300``."""
        first = f'{self.a}{self.resolution}' if self.a in PARTNERS else self.a
        return f'{first}-{self.b}{self.resolution}'

    @property
    def family(self) -> str:
        """The panel that the case is drawn in."""
        who = 'points to solid meshes' if self.a == 'Point' else 'solid meshes'
        return f'{who}, {self.resolution} triangles'

    def queries(self) -> tuple[str, ...]:
        """Return the queries that the case is asked."""
        return (POINTS,) if self.a == 'Point' else (SIGNED_DISTANCE, PENETRATION)

    def bodies(self, rng: np.random.Generator) -> tuple[Solid, MeshBody]:
        """Return both bodies, the first with random sizes."""
        mesh = mesh_body(self.b, self.resolution)
        if self.a in PARTNERS:
            return mesh_body(self.a, self.resolution), mesh
        return random_solid(rng, self.a), mesh


def mesh_cases() -> list[MeshCase]:
    """Return every body with every partner, in all resolutions."""
    return [
        MeshCase(a, b, resolution)
        for resolution in CUTS
        for b, partners in PARTNERS.items()
        for a in partners
    ]


# What a quick run has time for.
QUICK_CASES = [
    MeshCase('Point', 'L', 1300),
    MeshCase('Box', 'L', 1300),
    MeshCase('Sphere', 'Ball', 1300),
]


class MeshSubject:
    """A shape and a solid mesh; a batch has one sample of each configuration."""

    def __init__(self, case: MeshCase) -> None:
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


def sample(case: MeshCase, configuration: str, rng: np.random.Generator) -> Sample:
    """Return a random pair in a configuration, one whose truth is known."""
    gap = CONFIGURATIONS[configuration]
    while True:
        a, mesh = case.bodies(rng)
        X_WM = random_rotation(rng), rng.uniform(-0.1, 0.1, 3)
        f, n = surface_point(mesh, X_WM, rng)
        R_WA = random_rotation(rng)
        if gap is None:
            p_WA = f - rng.uniform(0.0, DEEPEST) * n
        else:
            p_WA = f + gap * n - farthest_point(rng, a, R_WA, -n)
        phi = mesh_truth.signed_distance(a, (R_WA, p_WA), mesh, X_WM)
        as_placed = gap is None or (phi is not None and abs(phi - gap) <= AS_PLACED)
        if phi is not None and as_placed:
            return Sample(a, mesh, (R_WA, p_WA), X_WM, phi, configuration)


def surface_point(mesh: MeshBody, X_WM: Pose, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return a point [m] of the surface and a unit direction out of it, in World."""
    assert mesh.corners is not None
    triangle = rng.choice(mesh.corners)
    weights = rng.dirichlet(np.ones(3))
    match rng.integers(3):
        case 0:  # at a vertex, between the normals of the triangles around it
            weights = np.array([1.0, 0.0, 0.0])
            around = (mesh.corners == triangle[0]).all(axis=2).any(axis=1)
            normals = _normals(mesh.corners[around])
            n = rng.dirichlet(np.ones(len(normals))) @ normals
        case 1:
            weights[2] = 0.0
            weights /= weights.sum()
            n = _normals(triangle[None])[0]
        case _:
            n = _normals(triangle[None])[0]
    R, p = X_WM
    return p + R @ (weights @ triangle), R @ (n / np.linalg.norm(n))


def _normals(corners: Floats) -> Floats:
    """Return the outward unit normals (k, 3) of triangles."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths: Floats = np.linalg.norm(normals, axis=1)[:, None]
    return normals / lengths
