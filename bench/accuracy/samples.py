"""Pairs at poses whose signed distance is known: made so, or found by ``truth``.

Apart, near and touching pairs are made from their answer: a direction n is chosen, the points a
and b in which A ends along n and B along -n, and B is put where b lies ``gap`` beyond a. Both
bodies are convex, so no two points of them are nearer. For overlaps that holds only locally;
their truth is the maximum over all directions.
"""

from __future__ import annotations

from zlib import crc32

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import random_directions, random_rotations
from truth.hard_cases.cases import Case
from truth.references import convex
from truth.references.supports import MinkowskiSum, posed
from truth.tolerances import (
    DEEP,
    NEAR,
    NO_DIRECTION,
    SHALLOW,
    TIE,
    TRUTH_ROUNDING,
)

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


def stream(name: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a case: its own, whatever else is measured."""
    return np.random.default_rng([seed, crc32(name.encode())])


def known(a: Body, b: Body, distance: float, about: str) -> Case:
    """Return a pair with its true distance [m], rounded once, and what it is called."""
    return Case(a, b, distance, TRUTH_ROUNDING * Pair(a, b).extent, about=about)


def convex_sample(a: Body, b: Body, configuration: str, rng: np.random.Generator) -> Case:
    """Return two convex shapes at random poses in a configuration."""
    R_WA, R_WB = random_rotations(rng, 2)
    a, b = a.placed(R_WA, np.zeros(3)), b.placed(R_WB, np.zeros(3))
    n = _direction(rng, a, b)
    gap = CONFIGURATIONS[configuration]
    if gap is None:
        p_WB = CONTAINED * random_directions(rng, 1)[0]
    else:
        p_WB = farthest_point(rng, a, n) + gap * n - farthest_point(rng, b, -n)
    b = b.at(p_WB)
    is_made = gap is not None and gap >= 0.0
    phi, _ = convex.signed_distance(a, b, near=n if is_made else None)
    return known(a, b, phi, configuration)


def _direction(rng: np.random.Generator, a: Body, b: Body) -> Floats:
    """Return a unit direction out of A: any, or one across an edge, two edges, or a face."""
    for sign, body in ((1.0, a), (-1.0, b)):
        if body.kind == 'HalfSpace':
            normal: Floats = sign * body.R[:, 2]
            return normal
    sums = [posed(body.form, *body.X_WG) for body in (a, b)]
    edges = [_edges(each) for each in sums]
    n = rng.normal(size=3)
    across = [rng.choice(side) for side in edges if len(side)]
    match rng.integers(4):
        case 1 if across:
            u = across[-1]
            n = n - (n @ u) * u
        case 2 if len(across) == 2:
            n = np.cross(*across)
        case 3 if across:
            n = _face(rng, sums[0] if len(edges[0]) else sums[1])
    length = np.linalg.norm(n)
    return n / length if length > NO_DIRECTION else np.array([1.0, 0.0, 0.0])


def _edges(body: MinkowskiSum) -> Floats:
    """Return the unit directions (k, 3) of a body's edges."""
    v = (body.vertices[body.edges[:, 0]] - body.vertices[body.edges[:, 1]]) @ body.R.T
    lengths: Floats = np.linalg.norm(v, axis=1)[:, None]
    return v / lengths


def _face(rng: np.random.Generator, body: MinkowskiSum) -> Floats:
    """Return the normal of a face, or the axis of a body that has one edge only."""
    if len(body.edges) == 1:
        axis: Floats = rng.choice([-1.0, 1.0]) * body.R[:, 2]
        return axis
    i, j = body.edges[rng.integers(len(body.edges))]
    beside = [e for e in body.edges if i in e and j not in e]
    k = next(int(m) for m in beside[rng.integers(len(beside))] if m != i)
    u, v = body.vertices[j] - body.vertices[i], body.vertices[k] - body.vertices[i]
    return body.R @ np.cross(u, v)


def farthest_point(rng: np.random.Generator, body: Body, n: Floats) -> Floats:
    """Return a point (3,), from its origin, in which a body ends along a unit n.

    Any of those of an edge or a face.
    """
    if body.kind == 'HalfSpace':
        return np.zeros(3)
    of_origin = posed(body.form, body.R, np.zeros(3))
    heights = of_origin.vertices @ (n @ body.R)
    tied = of_origin.vertices[heights >= heights.max() - TIE * (1.0 + of_origin.size)]
    point = of_origin.points(n[None])[0]
    top = of_origin.vertices[np.argmax(heights)]
    weights = rng.dirichlet(np.ones(len(tied)))
    moved: Floats = point + body.R @ (weights @ tied - top)
    return moved
