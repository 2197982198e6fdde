"""Small random worlds for the tests of the engine, built from plain arrays."""

import numpy as np
from oracles.forms import KINDS

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import BoundedBodies
from drake_geom_ros.geometry._proximity.world.pose_rounding import taken_roundings
from drake_geom_ros.geometry._proximity.world.world import FrameTable, GeometryTable, World
from truth.bodies.random_bodies import random_body, random_rotations


def random_parameters(rng, kind):
    """Return the kernel parameters of a random shape of about 0.2 m."""
    return random_body(rng, KINDS[kind], 20).form[1]


def scaled_parameters(kind, parameters, scale):
    """Return the kernel parameters of a shape that is ``scale`` times as large."""
    scaled = scale * np.asarray(parameters)
    if kind == CONVEX:
        scaled[0] = parameters[0]
    return scaled


def geometry_table(frames, types, parameters, R_FGs=None, p_FGs=None):
    """Pack geometries: one frame row, type and parameter list each."""
    n = len(types)
    R_FGs = np.tile(np.eye(3), (n, 1, 1)) if R_FGs is None else R_FGs
    return GeometryTable(
        ids=np.arange(10, 10 + n, dtype=np.int64),
        frames=np.asarray(frames, dtype=np.int64),
        R_FGs=R_FGs,
        p_FGs=np.zeros((n, 3)) if p_FGs is None else p_FGs,
        roundings=taken_roundings(R_FGs),
        types=np.asarray(types, dtype=np.int64),
        starts=np.cumsum([0, *map(len, parameters)], dtype=np.int64),
        pool=np.concatenate([np.zeros(0), *map(np.asarray, parameters)]),
    )


def random_world(rng, n, types=(1, 2, 3, 4, 5), anchored=0, spread=1.0):
    """Return a world of n posed geometries, the last ``anchored`` of them on the world frame."""
    moving = n - anchored
    frames = FrameTable(np.arange(1, moving + 2), np.zeros(moving + 1, dtype=np.int64))
    kinds = rng.choice(types, n)
    parameters = [random_parameters(rng, k) for k in kinds.tolist()]
    on = [*range(1, moving + 1), *[0] * anchored]
    R_FGs, p_FGs = random_rotations(rng, n), rng.uniform(-0.1, 0.1, (n, 3))
    p_FGs[moving:] = rng.uniform(-spread, spread, (anchored, 3))
    world = World(frames, geometry_table(on, kinds, parameters, R_FGs, p_FGs))
    shuffle(rng, world, spread)
    return world


def shuffle(rng, world, spread=1.0):
    """Pose every frame of the world anew and bring it up to date."""
    n = len(world.frames.ids) - 1
    rows = np.arange(1, n + 1)
    world.set_poses(rows, random_rotations(rng, n), rng.uniform(-spread, spread, (n, 3)))
    world.update()


def filters_of(world):
    """Return filters that know the world's geometries, each on a frame of its own."""
    filters = FilterState()
    table = world.geometries
    for key, frame, anchored in zip(table.ids, table.frames, world.anchored, strict=True):
        filters.add(int(key), int(frame) + 100, bool(anchored))
    return filters


def bounded(world):
    """Return what is known of a world's bodies beside their shapes."""
    poses = world.R_WGs, world.p_WGs, world.roundings, world.half_extents
    return BoundedBodies(world.geometries.types, *poses, world.outer_radii)
