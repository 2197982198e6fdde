"""How much faster than a peer each query is meant to be, as ratios of the medians."""

from __future__ import annotations

from bench.peers.scenes import SPREAD, TENTH

PENETRATION_4X = ('spheres-200', 'spheres-1000', 'mixed-1000')
OVER_PYDRAKE = {'candidates': 5.0, 'near': 4.0, 'all': 3.0, 'points': 20.0}
GROWTH = 1.2  # of a cycle's time when there are twice as many anchored boxes


def over_pydrake(scene: str, query: str) -> float:
    """Return what pydrake's time is meant to be at least, in times of ours."""
    if query == 'penetration':
        if scene.endswith(TENTH):
            return 10.0
        return 4.0 if scene in PENETRATION_4X else 2.0
    if query == 'has_collisions':
        return 2.0 if scene.endswith(SPREAD) else 1.0
    return OVER_PYDRAKE[query]


def over_mujoco(query: str) -> float | None:
    """Return the same for MuJoCo, which has one query."""
    return 1.0 if query == 'penetration' else None
