"""Pairs whose depth is almost the same along a ring of directions, and planes to judge them by."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.evidence.surfaces import support_value_of
from drake_geom_ros.geometry._proximity.kinds import ELLIPSOID


def turned(axis, angle):
    """Return the rotation matrix about an axis."""
    return Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis)).as_matrix()


def almost_coaxial(rng, kinds):
    """Return a pair, (kind, size, R) twice and p, of bodies of revolution almost on one axis."""
    sizes = [_size(rng, kind) for kind in kinds]
    if rng.random() < 0.2:
        sizes[1] *= 10 ** rng.uniform(-8, -1)
    R_WA = turned(rng.normal(size=3), rng.uniform(0, 3)) if rng.random() < 0.5 else np.eye(3)
    tilt = rng.choice([0, 10 ** rng.uniform(-16, -0.5)])
    R_WB = R_WA @ turned([*rng.normal(size=2), 0], tilt)
    aside = rng.choice([0, 10 ** rng.uniform(-16, -1)]) * min(sizes[0].max(), sizes[1].max())
    along = rng.choice([0, rng.uniform(-1, 1)]) * sizes[0][-1]
    p = R_WA @ [*(aside * turned([0, 0, 1], rng.uniform(0, 6.3))[0, :2]), along]
    return kinds[0], sizes[0], R_WA, kinds[1], sizes[1], np.ascontiguousarray(R_WB), p


def _size(rng, kind):
    a, b, c = 10 ** rng.uniform(-1.3, 0, 3)
    if kind != ELLIPSOID:
        return np.array([a, b])
    return np.array([a, a * (1 + rng.choice([0, 1e-12, 1e-9, 1e-6, 1e-3, c])), b])


def widths(pair, ns):
    """Return the widths of the overlap along (m, 3) unit vectors: each is at least the depth."""
    kind_A, size_A, R_WA, kind_B, size_B, R_WB, p = pair
    h_A = support_value_of((kind_A, size_A), ns @ R_WA)
    return h_A + support_value_of((kind_B, size_B), -ns @ R_WB) - ns @ p


def directions(rng, pair, n):
    """Return unit vectors, some maybe better than n: rings through it, next to it, any."""
    found = [rng.normal(size=(1000, 3)), *(R.T for R in (pair[2], pair[5]))]
    for u in (pair[2][:, 0], pair[2][:, 2], pair[5][:, 2]):
        x = np.cross(u, [1, 0, 0] if abs(u[0]) < 0.9 else [0, 1, 0])
        x /= np.linalg.norm(x)
        angles = np.linspace(0, 2 * np.pi, 800)
        across = np.outer(np.cos(angles), x) + np.outer(np.sin(angles), np.cross(u, x))
        for c in (0.0, n @ u, -(n @ u)):
            found.append(math.sqrt(max(1 - c * c, 0)) * across + c * u)
    found += [n + scale * rng.normal(size=(100, 3)) for scale in 10.0 ** np.arange(-8, 0)]
    ns = np.vstack(found)
    return ns / np.linalg.norm(ns, axis=1)[:, None]
