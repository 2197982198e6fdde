"""Pairs as the kernels of cores take them, and how wide they overlap along any direction."""

import math

import numpy as np
from oracles.forms import PARAMETERS
from oracles.kernel_calls import call_for_pair
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.surfaces import support_value_of
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import NORMAL, PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes import supports
from drake_geom_ros.geometry._proximity.kinds import ELLIPSOID
from drake_geom_ros.geometry._proximity.tolerances import EPS, PROMISED_ROUNDING
from truth.bodies.random_bodies import random_rotation


def turned(axis, angle):
    """Return the rotation matrix about an axis."""
    return Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis)).as_matrix()


def core_pair(kind_A, size_A, R_WA, kind_B, size_B, R_WB, p):
    """Return a pair of any numbers."""
    size_A, size_B = np.array(size_A, dtype=float), np.array(size_B, dtype=float)
    R_WA, R_WB = np.ascontiguousarray(R_WA), np.ascontiguousarray(R_WB)
    return CorePair(kind_A, size_A, R_WA, kind_B, size_B, R_WB, tuple(map(float, p)))


def random_core_pair(rng, kinds, lengths=(0.1, 1.0), reach=1.0):
    """Return a pair of primitives by their kinds, with half sizes between two lengths."""
    sizes = [rng.uniform(*lengths, PARAMETERS[k]) for k in kinds]
    R_WA, R_WB = random_rotation(rng), random_rotation(rng)
    p = reach * rng.normal(size=3)
    return core_pair(kinds[0], sizes[0], R_WA, kinds[1], sizes[1], R_WB, p)


def answer_of(pair, hint=(0.0, 0.0, 0.0)):
    """Return the row of a pair and the promised bound of it."""
    out = np.zeros(PAIR_WIDTH)
    out[NORMAL : NORMAL + 3] = hint
    radii = [supports.bounding_radius(*pair[k : k + 2]) for k in (0, 3)]
    tolerance = 1e-9 * min(1, *radii)
    call_for_pair(convex.signed_distance_of_cores, *pair, tolerance, math.inf, out)
    rounding = PROMISED_ROUNDING * EPS * (sum(radii) + np.linalg.norm(pair.p_AB))
    return out, tolerance + rounding


def almost_coaxial(rng, kinds):
    """Return a pair of bodies of revolution almost on one axis."""
    sizes = [_size(rng, kind) for kind in kinds]
    if rng.random() < 0.2:
        sizes[1] *= 10 ** rng.uniform(-8, -1)
    R_WA = turned(rng.normal(size=3), rng.uniform(0, 3)) if rng.random() < 0.5 else np.eye(3)
    tilt = rng.choice([0, 10 ** rng.uniform(-16, -0.5)])
    R_WB = R_WA @ turned([*rng.normal(size=2), 0], tilt)
    aside = rng.choice([0, 10 ** rng.uniform(-16, -1)]) * min(sizes[0].max(), sizes[1].max())
    along = rng.choice([0, rng.uniform(-1, 1)]) * sizes[0][-1]
    p = R_WA @ [*(aside * turned([0, 0, 1], rng.uniform(0, 6.3))[0, :2]), along]
    return core_pair(kinds[0], sizes[0], R_WA, kinds[1], sizes[1], R_WB, p)


def _size(rng, kind):
    a, b, c = 10 ** rng.uniform(-1.3, 0, 3)
    if kind != ELLIPSOID:
        return np.array([a, b])
    return np.array([a, a * (1 + rng.choice([0, 1e-12, 1e-9, 1e-6, 1e-3, c])), b])


def widths(pair, ns):
    """Return the widths of the overlap along unit vectors (..., 3): each is at least the depth."""
    ns = np.asarray(ns)
    kind_A, size_A, R_WA, kind_B, size_B, R_WB, p = pair
    h_A = support_value_of((kind_A, size_A), ns @ R_WA)
    return h_A + support_value_of((kind_B, size_B), -ns @ R_WB) - ns @ p


def core_widths(pair, ns):
    """Return the widths of the overlap of the cores: without the balls that they are grown by."""
    return widths(pair, ns) - radius_of(pair)


def radius_of(pair):
    """Return the radii [m] of the balls that the cores are grown by, in all."""
    return sum(supports.core_radius(*pair[k : k + 2]) for k in (0, 3))


def circle(x, y, angles):
    """Return unit vectors (m, 3) at angles [rad] from x towards y."""
    return np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y)


def ring(u, angles):
    """Return unit vectors (m, 3) at right angles to u."""
    x = np.cross(u, [1, 0, 0] if abs(u[0]) < 0.9 else [0, 1, 0])
    x /= np.linalg.norm(x)
    return circle(x, np.cross(u, x), angles)


def directions(rng, pair, n):
    """Return unit vectors, some maybe better than n: rings through it, next to it, any."""
    found = [rng.normal(size=(1000, 3)), *(R.T for R in (pair.R_WA, pair.R_WB))]
    for u in (pair.R_WA[:, 0], pair.R_WA[:, 2], pair.R_WB[:, 2]):
        across = ring(u, np.linspace(0, 2 * np.pi, 800))
        for c in (0.0, n @ u, -(n @ u)):
            found.append(math.sqrt(max(1 - c * c, 0)) * across + c * u)
    found += [n + scale * rng.normal(size=(100, 3)) for scale in 10.0 ** np.arange(-8, 0)]
    ns = np.vstack(found)
    return ns / np.linalg.norm(ns, axis=1)[:, None]
