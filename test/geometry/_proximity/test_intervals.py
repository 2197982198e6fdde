"""What bounds alone say of a pair holds the truth: in every query, of all shapes, wherever it is.

The truth is the level exact, whose own certificate is trusted.
"""

import math

import numpy as np
import pytest
from numba import config
from oracles.engine_calls import candidates, has_overlap, signed_distances
from oracles.forms import kernel_form
from oracles.solids import solid
from oracles.worlds import (
    filters_of,
    geometry_table,
    random_parameters,
    scaled_parameters,
    shuffle,
)

from drake_geom_ros.geometry._proximity.engine.engine import Engine
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, BOX, CONVEX, SOLID
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World

TYPES = (1, 2, 3, 4, 5, 6, CONVEX, SOLID)
NOTHING = 1e-12  # [s]
BODIES, SEEDS, CYCLES = (8, 2, 3) if config.DISABLE_JIT else (16, 12, 30)
NAMES = ('L', 'U', 'ring')
# What is lost where a row is made: sums of a distance and its error bound, each rounded.
ROUNDING = 4.0 * EPS


def parameters_of(rng, kind, scale):
    """A shape of about 0.2 m times a scale; some are needles, plates or beside their origin."""
    if kind == SOLID:
        name = NAMES[rng.integers(3)]
        return kernel_form(solid(name, float(np.exp2(np.round(np.log2(0.1 * scale))))))[1]
    parameters = scaled_parameters(kind, random_parameters(rng, kind), scale)
    if kind == CONVEX:
        parameters[1:] += np.tile(rng.choice([0, 1]) * scale * rng.normal(size=3), 20)
    elif rng.random() < 0.3:
        parameters *= 10 ** rng.uniform(-6, 0, len(parameters))
    return parameters


def world_of(types, parameters):
    """A world of one frame a geometry."""
    n = len(types)
    frames = FrameTable(np.arange(1, n + 2), np.zeros(n + 1, dtype=np.int64))
    return World(frames, geometry_table(range(1, n + 1), types, parameters))


def any_world(seed):
    """A world of all shapes: small or large, far off or not, on a lattice or not."""
    rng = np.random.default_rng(seed)
    scale = 10 ** rng.uniform(-6, 6) if seed % 2 else 1.0
    types = rng.choice(TYPES, BODIES)
    world = world_of(types, [parameters_of(rng, kind, scale) for kind in types.tolist()])
    shuffle(rng, world, scale * 10 ** rng.uniform(-1.5, 0.3))
    rows = np.arange(1, BODIES + 1)
    R, p = world.R_PFs[rows], world.p_PFs[rows]
    if seed % 3 == 0:
        R, p = np.tile(np.eye(3), (BODIES, 1, 1)), 0.1 * scale * np.round(10.0 * p / scale)
    far = rng.normal(size=3) * scale * 10 ** rng.uniform(-1, 7) if seed % 4 == 1 else np.zeros(3)
    world.set_poses(rows, R, p + far)
    world.update()
    return world, scale


def by_ids(batch):
    return {tuple(ids): row for ids, row in zip(batch.ids.tolist(), batch.rows, strict=True)}


def assert_holds(row, true, case):
    """Check that the interval of a row and that of the truth have a point in common."""
    off = abs(row[DISTANCE] - true[DISTANCE])
    bound = row[ERROR_BOUND] + true[ERROR_BOUND]
    assert off <= bound * (1.0 + ROUNDING), (case, row[DISTANCE], row[ERROR_BOUND], true[DISTANCE])


@pytest.mark.parametrize('seed', range(SEEDS))
def test_every_query_holds_the_truth(seed):
    world, scale = any_world(seed)
    filters = filters_of(world)
    truth = by_ids(signed_distances(Engine(), world, filters, 'exact', math.inf))
    answers = {}
    for level, seconds in (('bound', 0.0), ('exact', NOTHING)):
        for reach in (math.inf, 0.3 * scale, 0.0, -0.03 * scale):
            answer = signed_distances(Engine(), world, filters, level, reach, False, seconds)
            answers[level, reach] = answer, reach
            answers[level, reach, 'depths'] = answer.penetrating(), min(reach, 0.0)
        deep = signed_distances(Engine(), world, filters, level, 0.0, True, seconds).penetrating()
        answers[level, 'penetration'] = deep, 0.0
    for case, (answer, reach) in answers.items():
        found = by_ids(answer)
        for ids, row in found.items():
            assert_holds(row, truth[ids], (case, ids))
            n = row[NORMAL : NORMAL + 3]
            assert abs(n @ n - 1.0) <= 1e-12
            if 'penetration' in case or 'depths' in case:
                assert row[DISTANCE] < 0.0
        for ids, true in truth.items():
            surely = true[DISTANCE] + true[ERROR_BOUND]
            if surely <= reach and (reach != 0.0 or surely < -1e-13 * scale):
                assert ids in found, (case, ids)
    deep = [ids for ids, true in truth.items() if true[DISTANCE] < -true[ERROR_BOUND]]
    ids = world.geometries.ids
    near = {(int(ids[i]), int(ids[j])) for i, j in candidates(Engine(), world, filters, 0.0)}
    assert set(deep) <= near
    assert has_overlap(Engine(), world, filters, 'bound') or not deep
    assert len(truth) > len(deep)


def test_the_depth_of_bodies_that_may_be_apart():
    """Two boxes turned by 45 degrees about z, 2 cm apart along a diagonal and not in line."""
    world = world_of([BOX, BOX], [np.full(3, 0.1)] * 2)
    h = math.sqrt(0.5)
    R = np.array([[h, -h, 0.0], [h, h, 0.0], [0.0, 0.0, 1.0]])
    apart = R @ [0.22, 0.15, 0.0]
    world.set_poses(np.array([1, 2]), np.stack((R, R)), np.stack((np.zeros(3), apart)))
    world.update()
    filters = filters_of(world)
    (true,) = signed_distances(Engine(), world, filters, 'exact', math.inf).rows
    query = world, filters, 'bound'
    (row,) = signed_distances(Engine(), *query, 0.0, True).penetrating().rows
    assert true[DISTANCE] == pytest.approx(0.02, abs=1e-15)
    assert row[METHOD] == BOUND_ONLY
    assert row[DISTANCE] < 0.0
    assert abs(row[DISTANCE] - true[DISTANCE]) <= row[ERROR_BOUND]
    # It holds what the distance query says of the pair, and is no wider than it must be.
    (whole,) = signed_distances(Engine(), *query, 0.0).rows
    least, most = (whole[DISTANCE] + side * whole[ERROR_BOUND] for side in (-1, 1))
    assert row[DISTANCE] == 0.5 * least
    assert row[DISTANCE] + row[ERROR_BOUND] == pytest.approx(most, rel=1e-14)
    span = row[WITNESS_B : WITNESS_B + 3] - row[WITNESS_A : WITNESS_A + 3]
    assert span @ row[NORMAL : NORMAL + 3] == pytest.approx(-row[DISTANCE], abs=1e-15)


@pytest.mark.parametrize('seed', range(4))
def test_whoever_moves_under_a_budget_stays_in_the_interval(seed):
    world, scale = any_world(seed + 100)
    rng, rows = np.random.default_rng(seed), np.arange(1, BODIES + 1)
    engine, filters = Engine(), filters_of(world)
    for cycle in range(CYCLES):
        query = world, filters, 'exact', (math.inf, 0.2 * scale)[seed % 2]
        answer = by_ids(
            signed_distances(engine, *query, time_budget=NOTHING if cycle % 4 else 0.0)
        )
        for ids, true in by_ids(signed_distances(Engine(), *query)).items():
            if ids in answer:
                assert_holds(answer[ids], true, (cycle, ids))
        turns = np.einsum('nij,njk->nik', small_turns(rng, BODIES), world.R_PFs[rows])
        steps = scale * rng.uniform(-0.01, 0.01, (BODIES, 3))
        world.set_poses(rows, turns, world.p_PFs[rows] + steps)


def small_turns(rng, n):
    """Rotations (n, 3, 3) by some hundredths of a radian about the axes, one after the other."""
    x = np.tile(np.eye(3), (n, 1, 1))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        c, s = np.cos(a := rng.uniform(-0.03, 0.03, n)), np.sin(a)
        turn = np.tile(np.eye(3), (n, 1, 1))
        turn[:, i, i], turn[:, j, j], turn[:, i, j], turn[:, j, i] = c, c, -s, s
        x = turn @ x
    return x


@pytest.fixture
def peg(monkeypatch):
    """A box in the hole of a ring, a millimetre from each wall, and an engine without time."""
    ring = kernel_form(solid('ring'))[1]
    world = world_of([BOX, SOLID], [np.array([0.499, 0.499, 0.5]), ring])
    places = np.array([[1.5, 1.5, 0.5], [0.0, 0.0, 0.0]])
    world.set_poses(np.array([1, 2]), np.tile(np.eye(3), (2, 1, 1)), places)
    world.update()
    engine = Engine()
    monkeypatch.setattr(
        engine._steps.pace, 'spend', lambda distances, *rest: np.arange(len(distances))
    )
    return world, filters_of(world), engine


def turn_peg(world, angle):
    c, s = math.cos(angle), math.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    world.set_poses(np.array([1]), R[None], world.p_PFs[1:2])


# Turned so far the peg sticks: wherever in the hole it goes, it is in a wall. The way up is 1 m.
STUCK = 0.01  # [rad]
PEG = {0.0: 0.001, STUCK: -1.0}


@pytest.mark.parametrize('angles', [(0.0, STUCK), (STUCK, 0.0)])
def test_a_turn_may_change_the_depth_in_a_solid_by_more_than_it_moves_anything(peg, angles):
    world, filters, engine = peg
    turn_peg(world, angles[0])
    signed_distances(engine, world, filters, 'exact', math.inf)
    turn_peg(world, angles[1])
    (row,) = signed_distances(engine, world, filters, 'exact', math.inf, time_budget=NOTHING).rows
    assert engine.effects.unrefined_pairs == 1
    assert abs(row[DISTANCE] - PEG[angles[1]]) <= row[ERROR_BOUND] + 1e-12


def test_what_was_free_is_not_taken_for_shallow(peg):
    world, filters, engine = peg
    for angle, found in ((0.0, 0), (STUCK, 1)):
        turn_peg(world, angle)
        assert len(signed_distances(engine, world, filters, 'exact', -0.5).ids) == found
        signed_distances(engine, world, filters, 'exact', 1.0)
