"""H52, mujoco#3383: of random hulls none is at 0, or overlaps, that a plane separates.

The report: 3000 seeded pairs, a plane sought among the line of centres and 128 directions.
"""

import numpy as np
from numba import config

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import even_directions, random_rotation
from truth.judging.asking import BodyScene

PAIRS, SHAPES = (50, 8) if config.DISABLE_JIT else (3000, 40)
SEED = 7


DIRECTIONS = even_directions(128)


def widest_gap(a, b):
    """The widest gap between two sets of points along some directions."""
    centres = b.mean(axis=0) - a.mean(axis=0)
    n = np.vstack([DIRECTIONS, centres / np.linalg.norm(centres)])
    return ((b @ n.T).min(axis=0) - (a @ n.T).max(axis=0)).max()


def test_no_pair_that_a_plane_separates_is_at_zero():
    rng = np.random.default_rng(SEED)
    clouds = [rng.normal(size=(rng.integers(5, 40), 3)) * rng.uniform(0.05, 0.3, 3)
              for _ in range(SHAPES)]  # fmt: skip
    scene = BodyScene([Body('Convex', cloud) for cloud in clouds])
    context = scene.new_context()
    query = scene.asked(context)
    separated = 0
    for _ in range(PAIRS):
        i, j = rng.choice(SHAPES, 2, replace=False)
        poses = [(random_rotation(rng), rng.uniform(-0.5, 0.5, 3)) for _ in range(2)]
        values = {scene.frames[k]: RigidTransform(RotationMatrix(R), p)
                  for k, (R, p) in zip((i, j), poses, strict=True)}  # fmt: skip
        context.UpdateFramePoses(FramePoseVector(values))
        found = query.signed_distance_of_pair(scene.ids[i], scene.ids[j])
        a, b = (clouds[k] @ R.T + p for k, (R, p) in zip((i, j), poses, strict=True))
        gap = widest_gap(a, b)
        assert found.distance[0] >= gap - found.error_bound[0] - 1e-14
        assert found.error_bound[0] <= 1e-9
        separated += gap > 0.0
    assert PAIRS / 4 < separated < PAIRS
