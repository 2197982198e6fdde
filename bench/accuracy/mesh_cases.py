"""Cases with a mesh as a solid: samples at poses from a point of its surface.

A point f of the surface is chosen, in a triangle, on a side or at a vertex, and a direction n out
of the solid there; the other body ends ``gap`` from f along n. Whether this is their distance says
``truth.references``: in a dent another wall may be nearer, and then the sample is drawn again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.accuracy.cases import PairSubject
from bench.accuracy.samples import CONFIGURATIONS, farthest_point, known
from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.math.array_types import Floats
from truth.bodies.mesh_bodies import CUTS, mesh_body
from truth.bodies.random_bodies import random_body, random_rotation
from truth.hard_cases.cases import Case
from truth.references import meshes
from truth.tolerances import AS_PLACED

DEEPEST = 0.04  # [m] that an origin is inside, in what is contained
# What meets which body: boxes tell the truth about the L only.
PARTNERS = {'L': ('Point', 'Sphere', 'Box', 'L'), 'Ball': ('Point', 'Sphere')}


@dataclass(frozen=True)
class MeshPair(PairSubject):
    """A shape, by its public name or that of a mesh body, and a mesh as a solid."""

    resolution: int
    timed_pairs = 12  # each brings all its triangles

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

    def bodies(self, rng: np.random.Generator) -> tuple[Body, Body]:
        """Return both bodies, the first with random sizes."""
        mesh = mesh_body(self.b, self.resolution)
        if self.a in PARTNERS:
            return mesh_body(self.a, self.resolution), mesh
        return random_body(rng, self.a), mesh

    def sample(self, configuration: str, rng: np.random.Generator) -> Case:
        """Return a random pair in a configuration, one whose truth is known."""
        gap = CONFIGURATIONS[configuration]
        while True:
            a, mesh = self.bodies(rng)
            mesh = mesh.placed(random_rotation(rng), rng.uniform(-0.1, 0.1, 3))
            f, n = surface_point(mesh, rng)
            a = a.placed(random_rotation(rng), f)
            if gap is None:
                a = a.at(f - rng.uniform(0.0, DEEPEST) * n)
            else:
                a = a.at(f + gap * n - farthest_point(rng, a, -n))
            phi = meshes.signed_distance(a, mesh)
            as_placed = gap is None or (phi is not None and abs(phi - gap) <= AS_PLACED)
            if phi is not None and as_placed:
                return known(a, mesh, phi, configuration)


def mesh_cases() -> list[MeshPair]:
    """Return every body with every partner, in all resolutions."""
    return [
        MeshPair(a, b, resolution)
        for resolution in CUTS
        for b, partners in PARTNERS.items()
        for a in partners
    ]


# What a quick run has time for.
QUICK_CASES = [
    MeshPair('Point', 'L', 1300),
    MeshPair('Box', 'L', 1300),
    MeshPair('Sphere', 'Ball', 1300),
]


def surface_point(mesh: Body, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return a point [m] of the surface and a unit direction out of it, in World."""
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
    return mesh.p + mesh.R @ (weights @ triangle), mesh.R @ (n / np.linalg.norm(n))


def _normals(corners: Floats) -> Floats:
    """Return the outward unit normals (k, 3) of triangles."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths: Floats = np.linalg.norm(normals, axis=1)[:, None]
    return normals / lengths
