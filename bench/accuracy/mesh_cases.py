"""Cases with a mesh as a solid: the meshes, and samples at poses from a point of their surfaces.

``L``
    Two boxes that share a corner. However finely its faces are cut, it is the same body, so that
    boxes tell the truth about it.
``Ball``
    An icosphere with six bumps and dents between them; every resolution is a body of its own.

A point f of the surface is chosen, in a triangle, on a side or at a vertex, and a direction n out
of the solid there; the other body is put where it ends ``gap`` from f along n. That this is their
distance is asked of ``truth.meshes``: in a dent another wall may be nearer, and then the sample is
drawn again.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull

from bench.accuracy.cases import PairSubject
from bench.accuracy.samples import CONFIGURATIONS, farthest_point, known
from drake_geom_ros.cross_check.bodies import Body, Floats
from truth.bodies import grids
from truth.bodies.random_bodies import random_body, random_rotation
from truth.hard_cases.cases import Case
from truth.references import meshes
from truth.tolerances import AS_PLACED

UNIT = 0.1  # [m] the width of the L's arms
L_LINES = [np.array(line) * UNIT for line in ((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (-0.5, 0.5))]
RADIUS = 0.12  # [m] of the ball
DENTS = 0.5  # [-] a ball with less than 0.25 is convex
# About so many triangles -> how often each side of the L is cut, each triangle of the ball halved.
CUTS = {100: (2, 1), 1300: (7, 3), 20000: (27, 5)}
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


@functools.cache
def mesh_body(name: str, resolution: int) -> Body:
    """Return a body by its name and resolution, of ``MAKERS`` and ``CUTS``."""
    body = MAKERS[name](resolution)
    return replace(body, size=np.array(body.size), triangles=np.array(body.triangles))


def l_body(resolution: int) -> Body:
    """Return an L about its inner edge."""
    return grids.solid(grids.L, L_LINES, cuts=CUTS[resolution][0])


def ball(resolution: int) -> Body:
    """Return an icosphere with dents."""
    golden = (1.0 + 5.0**0.5) / 2.0
    points = np.array(
        [np.roll([0.0, s, t * golden], k) for s in (1, -1) for t in (1, -1) for k in range(3)]
    )
    points /= np.linalg.norm(points[0])
    hull = ConvexHull(points)
    outward = np.linalg.det(points[hull.simplices]) > 0.0
    corners = points[np.where(outward[:, None], hull.simplices, hull.simplices[:, ::-1])]
    for _ in range(CUTS[resolution][1]):
        corners = _quartered(corners)
    radii = RADIUS * (1.0 + DENTS * ((corners**4).sum(axis=2, keepdims=True) - 0.6))
    vertices, triangles = np.unique((radii * corners).reshape(-1, 3), axis=0, return_inverse=True)
    return Body('Solid', vertices, triangles=triangles.reshape(-1, 3))


def _quartered(corners: Floats) -> Floats:
    """Return four triangles for each, with the middles of its sides brought to radius 1."""
    middles = corners + np.roll(corners, -1, axis=1)
    middles /= np.linalg.norm(middles, axis=2, keepdims=True)
    (a, b, c), (ab, bc, ca) = np.swapaxes(corners, 0, 1), np.swapaxes(middles, 0, 1)
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(part, axis=1) for part in parts])


MAKERS: dict[str, Callable[[int], Body]] = {'L': l_body, 'Ball': ball}
