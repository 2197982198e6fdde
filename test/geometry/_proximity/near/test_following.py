"""The list of a changed world has what is near, from the former list, without a broad phase."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.worlds import filters_of, geometry_table, random_parameters, random_world

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.near.arrays import LIST_CUTOFF, MADE_AT
from drake_geom_ros.geometry._proximity.near.following import following
from drake_geom_ros.geometry._proximity.near.making import FEW
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import PointShapes

EXAMPLES = 3 if config.DISABLE_JIT else 12
MOVING, REACH = 60, 0.05  # bodies, each on a frame of its own; [m]
EDITS = 'anchor', 'attach', 'remove', 'reshape', 'swap'


def edited(rng, world, edit, kinds=(1, 2, 3)):
    """Return a world with a few changed geometries, and the change of its rows."""
    table = world.geometries
    count = int(rng.integers(1, 4))
    known = np.sort(rng.choice(table.ids, count, replace=False))
    new = int(table.ids.max()) + 1 + np.arange(count)
    changed = known if edit in ('remove', 'reshape') else new
    if edit == 'swap':  # of some that stay, some that go, and some that come
        changed = np.concatenate((known, new))
    has_row = np.full(len(changed), edit != 'remove')
    if edit == 'swap':
        has_row[: len(known)] = rng.random(len(known)) < 0.5
    change = RowChange.of(table.ids, changed, has_row)
    k = int(has_row.sum())
    frames = rng.integers(1, MOVING + 1, k) if edit in ('attach', 'swap') else np.zeros(k, int)
    types = rng.choice(kinds, k)
    of_new = geometry_table(
        frames,
        types,
        [random_parameters(rng, kind) for kind in types.tolist()],
        p_FGs=rng.uniform(-1.0, 1.0, (k, 3)) * np.where(frames == 0, 1.0, 0.1)[:, None],
    )._replace(ids=changed[has_row])
    points = PointShapes.of(of_new.types, of_new.starts, of_new.pool)
    return world.changed(world.frames, of_new, change, points), change


def required(world, distance):
    """Return the pairs of bodies on different frames whose boxes are within a distance."""
    p, half, frames = world.p_WGs, world.half_extents, world.geometries.frames
    gaps = np.abs(p[:, None] - p) - half[:, None] - half
    is_near = (gaps <= distance).all(axis=2) & (frames[:, None] != frames)
    return set(zip(*np.nonzero(np.triu(is_near, 1)), strict=True))


def assert_lists(near, world, distance):
    pairs = near.pairs
    assert (np.diff(pairs[:, 0] * len(world.anchored) + pairs[:, 1]) > 0).all()
    assert required(world, distance) <= set(map(tuple, pairs.tolist()))
    slots = near.slots.tolist()
    assert len(set(slots)) == len(slots)


@settings(max_examples=EXAMPLES, deadline=None)
@given(st.integers(0, 999), st.lists(st.sampled_from(EDITS), min_size=1, max_size=6))
def test_a_list_follows_any_changes_and_is_not_made_again(seed, edits):
    rng = np.random.default_rng(seed)
    world = random_world(rng, FEW + 50, (1, 2, 3), anchored=FEW + 50 - MOVING)
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters_of(world), REACH)
    made_at = near.arrays.numbers[MADE_AT]
    for edit in edits:
        world, change = edited(rng, world, edit)
        near = following(near, world, change)
        assert near.list_cutoff == REACH
        world.update()
        slots = len(near.arrays.slots)
        near.bring_up_to_date(world, filters_of(world), REACH)
        if len(near.arrays.slots) == slots:  # a list that lacks them is made again
            assert near.arrays.numbers[MADE_AT] == made_at
        made_at = near.arrays.numbers[MADE_AT]
        assert_lists(near, world, REACH)
    # The boxes of bodies that came hold while these are in them, and no longer.
    for _ in range(3):
        rows = np.arange(1, MOVING + 1)
        step = rng.uniform(-0.02, 0.02, (MOVING, 3))
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows] + step)
        world.update()
        near.bring_up_to_date(world, filters_of(world), REACH)
        assert_lists(near, world, REACH)


def test_a_half_space_that_comes_is_near_everything():
    rng = np.random.default_rng(0)
    world = random_world(rng, FEW + 50, (1, 2, 3), anchored=FEW + 50 - MOVING)
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters_of(world), REACH)
    for kinds in ((HALF_SPACE,), (1, 2)):  # after it others come
        world, change = edited(rng, world, 'anchor', kinds)
        near = following(near, world, change)
        assert (near.arrays.lengths[LIST_CUTOFF] == REACH) == (HALF_SPACE not in kinds)
        world.update()
        near.bring_up_to_date(world, filters_of(world), REACH)
        planes = np.flatnonzero(world.geometries.types == HALF_SPACE)
        listed = set(map(tuple, near.pairs.tolist()))
        for plane in planes.tolist():
            for other in np.flatnonzero(~world.anchored).tolist():
                assert (min(plane, other), max(plane, other)) in listed
        assert_lists(near, world, REACH)
