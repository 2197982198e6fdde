"""Structured starts: where minima tie, vanish, or hide from random poses."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import QhullError
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.bodies import BOUNDED, COUNTS, Body, Pair, as_tuples
from drake_geom_ros.cross_check.surfaces import height
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import (
    box_corners,
    random_directions,
    random_rotation,
)
from truth.judging.asking import BodyScene
from truth.tolerances import ACCEPTED_SKEW, RATIONAL_STEPS

KINDS = (*BOUNDED, 'Convex', 'HalfSpace')
OFTEN = ('Sphere', *2 * KINDS[1:-1])  # as the first body, and half of the others
LATTICE = (0.25, 0.5, 1.0, 2.0)
# (m, 3) cosine and sine of angles with exact sides.
RATIONAL = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25), (20, 21, 29))
NEAREST, FARTHEST = -16.0, -1.0  # decades of what is nearly aligned
MOST_RATIO = 8.0  # decades between sizes
FAR = 7.0  # decades [m] from the world's origin


def random_pair(rng: np.random.Generator) -> Pair:
    """Return a pair in a structured pose."""
    kind_a, kind_b = (
        str(rng.choice(OFTEN)),
        str(rng.choice(KINDS if rng.random() < 0.5 else OFTEN)),
    )
    scale = float(10.0 ** rng.choice([0.0, 0.0, 0.0, -3.0, -6.0, 4.0]))
    size_a = _sizes(rng, kind_a, scale)
    if kind_a == kind_b and rng.random() < 0.3:
        size_b = size_a
    else:
        u = rng.uniform(0.0, MOST_RATIO) if rng.random() < 0.25 else 0.0
        size_b = _sizes(rng, kind_b, scale * 10.0**-u)
    a = Body(kind_a, shape_sizes(rng, kind_a, size_a), rotation(rng))
    b = Body(kind_b, shape_sizes(rng, kind_b, size_b), rotation_beside(rng, a))
    b = b.at(offset(rng, a, b))
    pair = Pair(a, b) if rng.random() < 0.5 else Pair(b, a)
    return far(rng, pair) if rng.random() < 0.2 else pair


def valid(pair: Pair) -> bool:
    """Return whether the bodies can be made, and judged: a hull may be too thin."""
    if max(pair.a.skew, pair.b.skew) > ACCEPTED_SKEW:
        return False
    try:
        BodyScene((pair.a, pair.b))
        return all(math.isfinite(height(one, one.p)) for one in (pair.a, pair.b))
    except (RuntimeError, QhullError):
        return False


def far(rng: np.random.Generator, pair: Pair) -> Pair:
    """Return a pair moved away from the world's origin."""
    return pair.moved(np.eye(3), 10.0 ** rng.uniform(0.0, FAR) * rng.normal(size=3))


def _sizes(rng: np.random.Generator, kind: str, scale: float) -> Floats:
    """Return lengths (3,): on a lattice, any, or of needles and coins."""
    match rng.integers(4):
        case 0:
            lengths = rng.choice(LATTICE, 3)
        case 1:
            lengths = 10.0 ** rng.uniform(-2.0, 0.0, 3)
        case 2:
            lengths = np.round(rng.uniform(0.02, 1.0, 3), 2)
        case _:
            lengths = np.where(rng.random(3) < 0.5, 10.0 ** rng.uniform(-6.0, -1.0), 1.0)
            lengths = lengths * rng.choice([1.0, 1.0, rng.uniform(0.5, 1.5)])
    return scale * lengths


def shape_sizes(rng: np.random.Generator, kind: str, lengths: Floats) -> tuple:
    """Return the size of a shape as its constructor takes it."""
    if kind == 'HalfSpace':
        return ()
    if kind != 'Convex':
        return tuple(float(x) for x in lengths[: COUNTS[kind]])
    if rng.random() < 0.5:
        corners = box_corners()
        corners = corners[rng.permutation(8)[: rng.integers(4, 9)]]
        if np.linalg.matrix_rank(corners[1:] - corners[0]) < 3:
            corners = box_corners()
    else:
        corners = random_directions(rng, int(rng.integers(4, 11)))
    return as_tuples(corners * lengths)


def rotation(rng: np.random.Generator) -> Floats:
    """Return a rotation: none, on the lattice, of rational angles, or any."""
    match rng.integers(5):
        case 0 | 1:
            return np.eye(3)
        case 2:
            turn = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)[:, None]
            return turn * np.array([1.0, 1.0, np.linalg.det(turn)])
        case 3:
            return rational(rng)
        case _:
            return random_rotation(rng)


def rational(rng: np.random.Generator) -> Floats:
    """Return a rotation about one of the axes by an angle of a Pythagorean triangle."""
    x, y, r = RATIONAL[rng.integers(len(RATIONAL))]
    c, s = x / r, rng.choice([-1.0, 1.0]) * y / r
    j, k = rng.permutation(3)[:2]
    R = np.eye(3)
    R[j, j], R[j, k], R[k, j], R[k, k] = c, -s, s, c
    return R


def tilt(rng: np.random.Generator) -> Floats:
    """Return a small rotation about some axis."""
    axis = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
    angle = 10.0 ** rng.uniform(NEAREST, FARTHEST)
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()


def rotation_beside(rng: np.random.Generator, a: Body) -> Floats:
    """Return a rotation of B that is that of A, nearly so, or its own."""
    match rng.integers(5):
        case 0:
            return a.R
        case 1:
            return a.R @ tilt(rng)
        case 2:
            return a.R @ rotation(rng) @ tilt(rng)
        case 3:
            return a.R @ rotation(rng)
        case _:
            return rotation(rng)


def offset(rng: np.random.Generator, a: Body, b: Body) -> Floats:
    """Return p_AB: along axes, in shared planes, flush, rational, nested or any."""
    reach = a.radius + b.radius or 1.0
    frame = (a.R, b.R, np.eye(3))[rng.integers(3)]
    match rng.integers(6):
        case 0:
            d = np.zeros(3)
        case 1:  # along an axis, or in a plane of two
            d = frame[:, : rng.integers(1, 3)] if rng.random() < 0.3 else frame[:, 2:]
            d = d @ (reach * rng.uniform(-1.0, 1.0, d.shape[1]))
        case 2:  # a rational part of the size along an axis
            d = frame[:, rng.integers(3)] * reach * rng.integers(-8, 9) / rng.choice([8, 10, 100])
        case 3:  # flush
            d = _half(a) * rng.choice([-1, 0, 1], 3) + _half(b) * rng.choice([-1, 0, 1], 3)
            d = frame @ d
        case 4:  # rational directions
            x, y, _ = RATIONAL[rng.integers(len(RATIONAL))]
            d = rng.permutation([0.0, x, y]) * rng.choice(RATIONAL_STEPS) * reach
        case _:
            d = reach * rng.uniform(-1.0, 1.0, 3)
    if rng.random() < 0.4:
        aside = rng.normal(size=3) if rng.random() < 0.5 else frame[:, rng.integers(3)]
        d = d + reach * 10.0 ** rng.uniform(NEAREST, FARTHEST) * aside
    return a.p + d


def _half(one: Body) -> Floats:
    """Return half the lengths (3,) of a body along its axes."""
    _, s = one.form
    match one.kind:
        case 'Box' | 'Ellipsoid':
            return s
        case 'Capsule':
            return np.array([s[0], s[0], s[0] + s[1]])
        case 'Cylinder':
            return np.array([s[0], s[0], s[1]])
        case 'Sphere':
            return np.full(3, s[0])
        case 'Convex':
            return np.abs(one.size).max(axis=0)
    return np.zeros(3)
