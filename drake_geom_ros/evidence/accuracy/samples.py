"""Pairs at poses whose signed distance is known: made so, or found by ``truth``.

Apart, near and touching pairs are made from their answer: a direction n is chosen, the points a
and b in which A ends along n and B along -n, and B is put where b lies ``gap`` beyond a. Both
bodies are convex, so no two points of them are nearer. For overlaps that holds only locally;
their truth is the maximum over all directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from zlib import crc32

import numpy as np

from drake_geom_ros.evidence.accuracy.cases import Case
from drake_geom_ros.evidence.accuracy.solids import Solid, random_rotation
from drake_geom_ros.evidence.tolerances import DEEP, NEAR, NO_DIRECTION, SHALLOW, TIE
from drake_geom_ros.evidence.truth import convex as truth
from drake_geom_ros.evidence.truth.supports import Body, Floats, posed

# Name -> gap [m]; None: the origins 1 cm apart, so that one body is inside the other, or nearly.
CONFIGURATIONS: dict[str, float | None] = {
    'apart': 0.2,
    '2 mm apart': NEAR,
    'touching': 0.0,
    '2 mm deep': SHALLOW,
    '2 cm deep': DEEP,
    'contained': None,
}
CONTAINED = 0.01  # [m] between the origins


@dataclass(frozen=True, eq=False)
class Sample:
    """Two solids, their poses (R (3, 3), p (3,) [m]) and the true signed distance [m]."""

    a: Solid
    b: Solid
    X_WA: tuple[Floats, Floats]
    X_WB: tuple[Floats, Floats]
    truth: float
    configuration: str

    @property
    def size(self) -> float:
        """The size [m] of the pair, to which rounding is relative: radii plus offset."""
        apart = float(np.linalg.norm(self.X_WB[1] - self.X_WA[1]))
        return self.a.reach() + self.b.reach() + apart


def stream(name: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a case: its own, whatever else is measured."""
    return np.random.default_rng([seed, crc32(name.encode())])


def sample(case: Case, configuration: str, rng: np.random.Generator) -> Sample:
    """Return a random pair in a configuration."""
    a, b = case.bodies(rng)
    R_WA, R_WB = random_rotation(rng), random_rotation(rng)
    n = _direction(rng, (a, R_WA), (b, R_WB))
    gap = CONFIGURATIONS[configuration]
    if gap is None:
        step = rng.normal(size=3)
        p_WB = CONTAINED * step / np.linalg.norm(step)
    else:
        p_WB = farthest_point(rng, a, R_WA, n) + gap * n - farthest_point(rng, b, R_WB, -n)
    X_WA, X_WB = (R_WA, np.zeros(3)), (R_WB, p_WB)
    pair = a.support(), X_WA, b.support(), X_WB
    known = gap is not None and gap >= 0.0
    phi, _ = truth.near_direction(*pair, n) if known else truth.signed_distance(*pair)
    return Sample(a, b, X_WA, X_WB, phi, configuration)


def _direction(
    rng: np.random.Generator, a: tuple[Solid, Floats], b: tuple[Solid, Floats]
) -> Floats:
    """Return a unit direction out of A: any, or one across an edge, two edges, or a face."""
    for sign, (solid, R) in ((1.0, a), (-1.0, b)):
        if solid.kind == 'HalfSpace':
            normal: Floats = sign * R[:, 2]
            return normal
    bodies = [posed(solid.support(), R, np.zeros(3)) for solid, R in (a, b)]
    edges = [_edges(body) for body in bodies]
    n = rng.normal(size=3)
    across = [rng.choice(side) for side in edges if len(side)]
    match rng.integers(4):
        case 1 if across:
            u = across[-1]
            n = n - (n @ u) * u
        case 2 if len(across) == 2:
            n = np.cross(*across)
        case 3 if across:
            owner = bodies[0] if len(edges[0]) else bodies[1]
            n = _face(rng, owner)
    length = np.linalg.norm(n)
    return n / length if length > NO_DIRECTION else np.array([1.0, 0.0, 0.0])


def _edges(body: Body) -> Floats:
    """Return the unit directions (k, 3) of a body's edges."""
    v = (body.vertices[body.edges[:, 0]] - body.vertices[body.edges[:, 1]]) @ body.R.T
    lengths: Floats = np.linalg.norm(v, axis=1)[:, None]
    return v / lengths


def _face(rng: np.random.Generator, body: Body) -> Floats:
    """Return the normal of a face, or the axis of a body that has one edge only."""
    if len(body.edges) == 1:
        axis: Floats = rng.choice([-1.0, 1.0]) * body.R[:, 2]
        return axis
    i, j = body.edges[rng.integers(len(body.edges))]
    beside = [e for e in body.edges if i in e and j not in e]
    k = next(int(m) for m in beside[rng.integers(len(beside))] if m != i)
    u, v = body.vertices[j] - body.vertices[i], body.vertices[k] - body.vertices[i]
    return body.R @ np.cross(u, v)


def farthest_point(rng: np.random.Generator, solid: Solid, R: Floats, n: Floats) -> Floats:
    """Return a point (3,) in which a solid at the origin ends along a unit n.

    Any of those of an edge or a face.
    """
    if solid.kind == 'HalfSpace':
        return np.zeros(3)
    body = posed(solid.support(), R, np.zeros(3))
    heights = body.vertices @ (n @ R)
    tied = body.vertices[heights >= heights.max() - TIE * (1.0 + body.size)]
    point = body.points(n[None])[0]
    top = body.vertices[np.argmax(heights)]
    weights = rng.dirichlet(np.ones(len(tied)))
    moved: Floats = point + R @ (weights @ tied - top)
    return moved
