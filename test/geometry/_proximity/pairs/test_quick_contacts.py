"""Contacts seen without a kernel: never one that the penetrations do not report."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.engine_calls import has_overlap, signed_distances
from oracles.worlds import filters_of, geometry_table, random_world, shuffle
from scipy.spatial import ConvexHull

from drake_geom_ros.geometry import Convex, MeshData
from drake_geom_ros.geometry._proximity.engine.engine import ACCURACY_LEVELS, Engine
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import balls_inside
from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.tolerances import PLAIN_DEPTH
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from drake_geom_ros.geometry.shapes.primitives import for_queries

KINDS = (1, 2, 3, 4, 5, HALF_SPACE, CONVEX)


def reports(world, filters, level):
    """Return whether an engine that was never asked reports a penetration."""
    return len(signed_distances(Engine(), world, filters, level, 0.0, True).ids) > 0


def allowed(world, filters, engine):
    pair = engine._report.summary[-2:]
    a, b = sorted(world.geometries.ids[pair].tolist())
    return not (world.anchored[pair].all() or filters.filtered(a, b))


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.sampled_from(ACCURACY_LEVELS), st.floats(0.05, 3.0))
def test_whoever_looks_for_one_contact_answers_as_the_penetrations_do(seed, level, spread):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 14))
    world = random_world(rng, count, types=KINDS, spread=spread, anchored=int(rng.integers(0, 2)))
    filters, engine = filters_of(world), Engine()
    keys = tuple(world.geometries.ids.tolist())
    for _ in range(4):
        some = tuple(rng.choice(keys, max(1, count // 2), replace=False).tolist())
        filters.apply([(FilterOperation.EXCLUDE_WITHIN, some, some)])
        for _ in range(3):
            expected = reports(world, filters, level)
            assert has_overlap(engine, world, filters, level) == expected
            if expected:
                assert allowed(world, filters, engine)
            shuffle(rng, world)


@pytest.mark.parametrize('level', ACCURACY_LEVELS)
@pytest.mark.parametrize('share', [2.0**-20, 2.0**-11, 2.0**-9, 0.1])
def test_near_touch_kernels_decide_and_from_a_plain_depth_on_nobody_asks_them(level, share):
    frames = FrameTable(np.array([0, 1, 2]), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [SPHERE, SPHERE], [[0.5], [0.5]]))
    ps = np.array([[0.0, 0.0, 0.0], [1.0 - 0.5 * share, 0.0, 0.0]])
    world.set_poses(np.array([1, 2]), np.tile(np.eye(3), (2, 1, 1)), ps)
    engine, filters = Engine(), filters_of(world)
    assert has_overlap(engine, world, filters, level)
    assert (engine.effects.broadphase_pairs == 0) == (share > PLAIN_DEPTH)


def test_a_pair_that_waits_or_is_filtered_is_no_contact():
    world = random_world(np.random.default_rng(1), 3, types=(SPHERE,), spread=0.0)
    filters, engine = filters_of(world), Engine()
    keys = tuple(world.geometries.ids.tolist())
    assert has_overlap(engine, world, filters, 'exact')
    assert engine.effects.broadphase_pairs == 0
    filters.apply([(FilterOperation.EXCLUDE_WITHIN, keys, keys)])
    assert not has_overlap(engine, world, filters, 'exact')
    filters.apply([(FilterOperation.EXCLUDE_BETWEEN, keys[:2], ())])
    world.waiting[:] = True
    assert not has_overlap(Engine(), world, filters, 'exact')


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 5, 8, 30]), st.floats(-4.0, 0.0))
def test_the_ball_in_a_hull_is_inside_each_of_its_facets(seed, count, flatness):
    """Facets by Qhull, through scipy. Only a flat hull has none."""
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(count, 3)) * [1.0, 1.0, 10.0**flatness] + rng.normal(size=3)
    hull = ConvexHull(vertices)
    pool = for_queries(Convex.FromMeshData(MeshData(vertices))).in_pairs.parameters
    one = np.array([CONVEX]), np.array([0, len(pool)]), pool
    (centre,), (radius,) = balls_inside(*one, np.zeros(1))
    room = -(hull.equations[:, :3] @ centre + hull.equations[:, 3])
    assert radius <= room.min() + 1e-6 * PLAIN_DEPTH
    assert radius > 0.0 or flatness < -1.5 or count < 30
    assert radius == 0.0 or radius >= (1.0 - 1e-9) * room.min()
