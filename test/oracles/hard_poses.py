"""The hard poses of ``hard_poses.txt`` as pairs with the lower shape type first."""

from pathlib import Path

import numpy as np
from oracles.pairs import Pair

KINDS = {'sphere': 1, 'box': 2, 'capsule': 3, 'cylinder': 4, 'ellipsoid': 5, 'half-space': 6}


def _numbers(text):
    return np.array([float(word) for word in text.split()])


def _rotation(text):
    """The matrix as it stands, or the nearest rotation where a source prints ten digits only."""
    R = _numbers(text).reshape(3, 3)
    if np.allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-14):
        return R
    u, _, v = np.linalg.svd(R)
    return u @ v


def hard_poses():
    """Return {name: (pair, signed distance, tolerance of that)}."""
    poses = {}
    for line in Path(__file__).with_suffix('.txt').read_text().splitlines():
        if line.startswith('#'):
            continue
        name, distance, tolerance, *bodies = (field.strip() for field in line.split(';'))
        a, b = (
            (KINDS[kind], _numbers(size), _rotation(R), _numbers(p))
            for kind, size, R, p in (bodies[:4], bodies[4:])
        )
        if a[0] > b[0]:
            a, b = b, a
        poses[name] = (Pair(*a[:3], *b[:3], b[3] - a[3]), float(distance), float(tolerance))
    return poses
