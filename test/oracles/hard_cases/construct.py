"""Pairs that are known by construction, and what every generated case is made of.

Of A take the point that is extreme along a unit n, of B the one that is extreme against it, and
place B so that they are a gap g >= 0 apart along n: two parallel planes keep the bodies g apart,
and two of their points are no farther. So the distance is g, for any shapes and any n.
"""

import itertools

import numpy as np
from oracles import body_truth as truth

from drake_geom_ros.cross_check.bodies import BOUNDED, COUNTS, Body, as_tuples
from truth.bodies.random_bodies import (
    box_corners,
    random_directions,
    random_rotation,
)
from truth.hard_cases.cases import Case
from truth.tolerances import EPS

SOLIDS = (*BOUNDED, 'Convex')
PAIRS = tuple(itertools.combinations_with_replacement(SOLIDS, 2))
UNIQUE = 1e-3  # of the extent: gaps from here on have a normal worth storing


def body(kind, size, R=None, p=(0.0, 0.0, 0.0)):
    R = np.eye(3) if R is None else np.array(R, dtype=float)
    return Body(kind, tuple(size), R, np.array(p, dtype=float))


def placing(a, b, n):
    """Return the rounding [m] of such a placement."""
    extent = a.radius + b.radius + np.abs(a.p).max() + np.abs(b.p).max()
    return 8.0 * EPS * extent


def gap_case(about, a, b, n, gap):
    """Return the case of a pair `gap` apart along n; a negative gap is answered by the truth.

    The engine may only be given what floats can hold: B's rounded position is what counts.
    """
    n = np.asarray(n, dtype=float)
    b = truth.apart(a, b, n, gap)
    if gap < 0.0:
        return case(about, a, b)
    distance, tolerance = gap, placing(a, b, n)
    if truth.is_closed(a, b):
        distance, tolerance = truth.signed_distance(a, b)
    known = gap > UNIQUE * (a.radius + b.radius)
    witnesses = None
    if known and (single(a, n) or single(b, -n)):
        p_WCa = truth.support_point(a, n) if single(a, n) else truth.support_point(b, -n) - gap * n
        witnesses = np.array([p_WCa, p_WCa + gap * n])
    normals = -np.array([n], dtype=float) if known else None
    return Case(a, b, distance, tolerance, normals, witnesses, about=about)


def case(about, a, b, distance=None, tolerance=None, normals=None):
    """Return the case of a pair as it stands; without a distance the truth is asked."""
    if distance is None:
        distance, tolerance = truth.signed_distance(a, b)
    normals = None if normals is None else np.array(normals, dtype=float)
    return Case(a, b, float(distance), float(tolerance), normals, about=about)


def single(one, n):
    """Return whether one point of the body alone is extreme along n, with a margin."""
    d = np.abs(one.R.T @ n)
    if one.kind in ('Sphere', 'Ellipsoid'):
        return True
    if one.kind == 'Capsule':
        return bool(d[2] > 0.1)
    if one.kind == 'Cylinder':
        return bool(0.1 < d[2] < 0.99)
    return bool(one.kind == 'Box' and d.min() > 0.1)


def sizes(kind, rng, scale=1.0):
    """Return sizes of a shape of about `scale`, lengths differing by up to 10^0.5."""
    if kind == 'Convex':
        return hull_vertices(rng, scale)
    return tuple((scale * 10.0 ** rng.uniform(-0.5, 0.0, COUNTS[kind])).tolist())


def hull_vertices(rng, scale=1.0, count=10):
    """Return points on a sphere, each a vertex of their hull."""
    return as_tuples(scale * random_directions(rng, count))


def box_vertices(size):
    """Return the corners of a box of a size."""
    return as_tuples(box_corners(size))


def unit(v):
    v = np.asarray(v, dtype=float)
    return v / np.linalg.norm(v)


def turned(rng, kind):
    """Return a body of a kind, about 1 m, in a random orientation."""
    return body(kind, sizes(kind, rng), random_rotation(rng))


def outward(one, rng, feature):
    """Return a unit direction, in World, out of a face, an edge or anywhere of a body's frame."""
    if one.kind == 'HalfSpace':
        return one.R[:, 2]
    local = rng.permutation(np.eye(3))[0] * rng.choice([-1.0, 1.0])
    if feature == 'edge':
        local = unit([rng.choice([-1.0, 1.0]), rng.choice([-1.0, 1.0]), 0.0])
        local = local[rng.permutation(3)]
    if feature == 'vertex':
        local = unit(rng.choice([-1.0, 1.0], 3) * rng.uniform(0.3, 1.0, 3))
    return one.R @ local
