"""The neighbour list: it holds whatever is near, stands while it can, and remembers by pair."""

import math

import numpy as np
import pytest
from oracles.worlds import filters_of, geometry_table, random_rotations, random_world, shuffle

from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SLOT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.near.arrays import MADE_AT
from drake_geom_ros.geometry._proximity.near.making import FEW
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.near.skins import PATIENCE
from drake_geom_ros.geometry._proximity.pairs.slots import empty_memory
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World

EXCLUDE_WITHIN, EXCLUDE_BETWEEN, ALLOW_WITHIN, ALLOW_BETWEEN = FilterOperation


def near_pairs(world, distance):
    """Return the pairs whose boxes come within a distance, less those of two anchored bodies."""
    i, j = np.triu_indices(world.geometry_count, k=1)
    gaps = np.abs(world.p_WGs[i] - world.p_WGs[j]) - world.half_extents[i] - world.half_extents[j]
    near = np.linalg.norm(np.maximum(gaps, 0.0), axis=1) <= distance
    keep = near & ~(world.anchored[i] & world.anchored[j])
    return set(zip(i[keep].tolist(), j[keep].tolist(), strict=True))


def listed(near):
    pairs = [tuple(pair) for pair in near.pairs.tolist()]
    assert pairs == sorted(set(pairs))
    return set(pairs)


def creep(rng, world, frames, length):
    """Move some frames a little and bring the world up to date."""
    ps = world.p_PFs[frames] + rng.uniform(-length, length, (len(frames), 3))
    world.set_poses(frames, world.R_PFs[frames], ps)
    world.update()


@pytest.mark.parametrize('anchored', [0, 30])
@pytest.mark.parametrize('moving', [40, 4])
def test_whatever_is_near_is_listed_and_the_list_stands_for_a_while(anchored, moving):
    rng = np.random.default_rng(anchored + moving)
    world = random_world(rng, 80, anchored=anchored)
    filters, near = filters_of(world), NeighbourList(world)
    frames = np.arange(1, 1 + moving)
    made = 0
    for step in range(3 * PATIENCE):
        distance = (0.0, 0.05)[step % 2]
        made += near.bring_up_to_date(world, filters, distance)
        assert near_pairs(world, distance) <= listed(near)
        creep(rng, world, frames, 0.002)
    assert 3 <= made <= PATIENCE
    # Nobody else than who moves costs anything, and nobody is forgotten when they wake up.
    shuffle(rng, world)
    assert near.bring_up_to_date(world, filters, 0.05)
    assert near_pairs(world, 0.05) <= listed(near)


# By a look at each pair, and by grids.
@pytest.mark.parametrize(('count', 'anchored'), [(50, 0), (50, 25), (50, 49), (300, 0), (300, 25)])
@pytest.mark.parametrize('distance', [0.0, 0.3])
def test_boxes_without_margins_are_padded_by_the_distance_and_no_more(count, anchored, distance):
    """Whoever came from afar just now, or rests, gets no margin."""
    rng = np.random.default_rng(anchored)
    world = random_world(rng, count, anchored=anchored)
    assert (count > FEW) == (count == 300)
    filters = filters_of(world)
    i, j = np.triu_indices(count, k=1)
    for updates in (0, PATIENCE, 1):
        for _ in range(updates):  # all but the first frame come to rest
            world.set_poses(np.array([1]), world.R_PFs[1:2], rng.uniform(-1.0, 1.0, (1, 3)))
            world.update()
        near = NeighbourList(world)
        near.bring_up_to_date(world, filters, distance)
        sizes = world.half_extents[i] + world.half_extents[j] + distance
        wanted = (np.abs(world.p_WGs[i] - world.p_WGs[j]) <= sizes).all(axis=1)
        wanted &= ~(world.anchored[i] & world.anchored[j])
        assert listed(near) == set(zip(i[wanted].tolist(), j[wanted].tolist(), strict=True))


def test_a_list_for_more_serves_for_less_and_grows_when_it_must():
    world = random_world(np.random.default_rng(0), 40)
    filters, near = filters_of(world), NeighbourList(world)
    assert near.bring_up_to_date(world, filters, 0.2)
    assert not near.bring_up_to_date(world, filters, 0.0)
    assert not near.bring_up_to_date(world, filters, -1.0)
    assert near.bring_up_to_date(world, filters, 0.3)
    assert near_pairs(world, 0.3) <= listed(near)


def test_teleports_are_met_by_a_list_without_margins():
    rng = np.random.default_rng(1)
    world = random_world(rng, 40)
    filters, near = filters_of(world), NeighbourList(world)
    for _ in range(20):
        shuffle(rng, world)
        assert near.bring_up_to_date(world, filters, 0.0)
        assert near_pairs(world, 0.0) <= listed(near)
    assert len(near.pairs) <= 2 * len(near_pairs(world, 0.0))


def boxes_within(near, world, distance):
    """Return the pairs whose boxes, as the list has them, are within a distance."""
    i, j = np.triu_indices(world.geometry_count, k=1)
    lowers, uppers = near.arrays.lowers, near.arrays.uppers
    meet = (lowers[i] - distance <= uppers[j]) & (lowers[j] - distance <= uppers[i])
    keep = meet.all(axis=1) & ~(world.anchored[i] & world.anchored[j])
    return set(zip(i[keep].tolist(), j[keep].tolist(), strict=True))


@pytest.mark.parametrize('far', [0.0, 1e5])
@pytest.mark.parametrize('moving', [1, 6, 15, 40])
@pytest.mark.parametrize('length', [0.002, 0.3])
def test_a_list_has_the_pairs_whose_boxes_meet(moving, length, far):
    """Less those that the filters of now leave out."""
    rng = np.random.default_rng(moving)
    world = random_world(rng, 60, anchored=10)
    world.set_poses(np.arange(1, 51), world.R_PFs[1:51], world.p_PFs[1:51] + far)
    world.update()
    filters, near = filters_of(world), NeighbourList(world)
    keys = world.geometries.ids.tolist()
    for step in range(100):
        distance = (0.0, 0.05)[step // 50]
        if step % 9 == 0:
            sides = [tuple(rng.choice(keys, 8, replace=False).tolist()) for _ in range(2)]
            filters.apply([((EXCLUDE_BETWEEN, ALLOW_BETWEEN)[step % 2], *sides)])
        near.bring_up_to_date(world, filters, distance)
        met = boxes_within(near, world, near.list_cutoff)
        assert near_pairs(world, distance) <= met
        assert near.considered == len(met)
        assert listed(near) == {(i, j) for i, j in met if not filters.filtered(keys[i], keys[j])}
        frames = 1 + rng.choice(50, moving, replace=False)
        creep(rng, world, frames, length)
        if step % 10 == 0:
            creep(rng, world, frames[:1], 30.0)


def test_a_list_is_made_again_with_the_room_that_it_lacks():
    """Somebody who comes from afar into a crowd has more pairs than there is room for."""
    rng = np.random.default_rng(6)
    world = random_world(rng, 250, spread=50.0)
    filters, near = filters_of(world), NeighbourList(world)
    near.bring_up_to_date(world, filters, 0.0)
    for first in range(1, 240, 40):
        frames = np.arange(first, first + 40)
        world.set_poses(frames, world.R_PFs[frames], rng.uniform(-0.1, 0.1, (40, 3)))
        world.update()
        assert near.bring_up_to_date(world, filters, 0.0)
        assert listed(near) == boxes_within(near, world, 0.0)
    assert near.count > 240 * 239 / 2 * 0.9


def test_all_pairs():
    world = random_world(np.random.default_rng(2), 20, anchored=5)
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters_of(world), math.inf)
    assert listed(near) == near_pairs(world, math.inf)
    assert len(near.pairs) == 190 - 10


def test_filtered_pairs_are_not_listed():
    world = random_world(np.random.default_rng(3), 10, spread=0.01)
    filters, near = filters_of(world), NeighbourList(world)
    near.bring_up_to_date(world, filters, 1.0)
    assert (near.considered, len(near.pairs)) == (45, 45)
    keys = tuple(world.geometries.ids.tolist())
    filters.apply([(EXCLUDE_WITHIN, keys[:5], keys[:5])])
    assert near.bring_up_to_date(world, filters, 1.0)
    assert (near.considered, len(near.pairs)) == (45, 35)
    assert not (near.pairs < 5).all(axis=1).any()


@pytest.mark.parametrize('distance', [0.1, math.inf])
@pytest.mark.parametrize('count', [50, 300])
def test_other_filters_are_asked_of_the_pairs_that_were_found(count, distance):
    world = random_world(np.random.default_rng(5), count)
    assert (count > FEW) == (count == 300)
    filters, near = filters_of(world), NeighbourList(world)
    near.bring_up_to_date(world, filters, distance)
    met, made_at = listed(near), near.arrays.numbers[MADE_AT]
    keys = world.geometries.ids.tolist()
    for operation in (EXCLUDE_WITHIN, ALLOW_WITHIN):
        filters.apply([(operation, tuple(keys[: count // 2]), ())])
        assert near.bring_up_to_date(world, filters, distance)
        assert near.considered == len(met)
        expected = {(i, j) for i, j in met if not filters.filtered(keys[i], keys[j])}
        assert listed(near) == expected
        assert (expected == met) == (operation == ALLOW_WITHIN)
    assert near.arrays.numbers[MADE_AT] == made_at


def test_a_pair_keeps_its_slot_for_as_long_as_it_is_near():
    rng = np.random.default_rng(4)
    world = random_world(rng, 60)
    filters, near = filters_of(world), NeighbourList(world)
    known: dict[tuple[int, int], list[float]] = {}
    (nothing,) = empty_memory(1).tolist()
    for _ in range(60):
        near.bring_up_to_date(world, filters, 0.0)
        slots = dict(zip(map(tuple, near.pairs.tolist()), near.slots.tolist(), strict=True))
        assert len(set(slots.values())) == len(slots)
        for pair, slot in slots.items():
            # A new pair knows nothing, whoever had the slot before.
            expected = known.get(pair, nothing)
            assert near.memory[slot].tolist() == expected
            near.memory[slot] = rng.random(len(expected))
        known = {pair: near.memory[slot].tolist() for pair, slot in slots.items()}
        creep(rng, world, np.arange(1, 61), 0.03)


def slots_of(near):
    return dict(zip(map(tuple, near.pairs.tolist()), near.slots.tolist(), strict=True))


def test_slots_are_used_to_the_last_one_and_keep_what_they_hold_when_they_grow():
    """58 pairs are given room for 136, which come next; then there are 153."""
    world = random_world(np.random.default_rng(6), 18)
    filters, near = filters_of(world), NeighbourList(world)
    keys = tuple(world.geometries.ids.tolist())
    filters.apply([(EXCLUDE_WITHIN, keys[:13], ()), (EXCLUDE_BETWEEN, keys[17:], keys[:17])])
    sizes, before = [], {}
    for allowed in (keys[:1], keys[:17], keys):
        filters.apply([(ALLOW_WITHIN, allowed, ())])
        near.bring_up_to_date(world, filters, math.inf)
        after = slots_of(near)
        sizes.append((len(after), len({*after.values()}), len(near.memory)))
        assert before.items() <= after.items()
        for (i, j), slot in before.items():
            assert near.memory[slot].tolist() == list(range(100 * i + j, 100 * i + j + SLOT_WIDTH))
        for (i, j), slot in after.items():
            near.memory[slot] = range(100 * i + j, 100 * i + j + SLOT_WIDTH)
        before = after
    assert sizes == [(58, 58, 136), (136, 136, 136), (153, 153, 255)]


@pytest.mark.parametrize('moving_plane', [False, True])
def test_every_body_is_paired_with_every_plane(moving_plane):
    frames = FrameTable(np.arange(1, 7), np.zeros(6, dtype=np.int64))
    on = [int(moving_plane), 2, 3, 4, 0, 5]
    table = geometry_table(on, [HALF_SPACE, 1, 1, 2, 1, HALF_SPACE], [[], *[[0.1] * 3] * 4, []])
    world = World(frames, table)
    rng = np.random.default_rng(5)
    world.set_poses(np.arange(1, 6), random_rotations(rng, 5), rng.uniform(-9, 9, (5, 3)))
    world.update()
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters_of(world), 0.0)
    bodies = [1, 2, 3, 4] if moving_plane else [1, 2, 3]
    expected = {(0, g) for g in bodies} | {(g, 5) for g in (1, 2, 3, 4)}
    assert listed(near) == expected
    # A plane may turn as it likes: the list stands.
    world.set_poses(np.array([5]), random_rotations(rng, 1), np.zeros((1, 3)))
    world.update()
    assert not near.bring_up_to_date(world, filters_of(world), 0.0)


@pytest.mark.parametrize('count', [0, 1])
def test_scenes_without_a_pair(count):
    world = random_world(np.random.default_rng(0), count)
    for distance in (0.0, math.inf):
        near = NeighbourList(world)
        near.bring_up_to_date(world, filters_of(world), distance)
        assert near.pairs.shape == (0, 2)
