"""Which cells are held: by ages, and by rays, against brute force."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.sensed_maps import keeping
from drake_geom_ros.sensed_maps.cells import Cells, MapError
from drake_geom_ros.sensed_maps.keeping import KeptCells, seen_through

clouds = st.lists(
    st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=1, max_size=6), min_size=1, max_size=6
)


def cells_of(keys, resolution=1.0):
    return Cells.of_keys(np.array(keys, dtype=np.int64).reshape(-1, 3), resolution)


@given(clouds, st.sampled_from([0.0, 1.0, 2.5, math.inf]))
def test_a_cell_is_held_as_long_as_it_was_seen_that_recently(sequence, keep):
    kept = KeptCells.none(1.0)
    last = {}
    for now, keys in enumerate(sequence):
        kept = kept.and_then(cells_of(keys), float(now), keep)
        last.update(dict.fromkeys(keys, now))
        expected = {key: seen for key, seen in last.items() if seen == now or now - seen <= keep}
        if keep == 0.0:
            expected = dict.fromkeys(keys, now)
        last = expected
        found = dict(zip(map(tuple, kept.cells.keys().tolist()), kept.seen.tolist(), strict=True))
        assert found == expected
        assert (np.diff(kept.cells.packed) > 0).all()


@given(clouds, clouds, st.booleans(), st.sampled_from([1.0, 2.5, math.inf]))
def test_a_point_holds_a_cell_where_it_makes_none(sequence, more, rays, keep):
    kept, last = KeptCells.none(1.0), {}
    for now, keys in enumerate(sequence):
        sparse = set(more[now % len(more)]) - set(keys)
        free = set(more[-1 - now % len(more)]) if rays else set()
        packed = [cells_of(list(some)).packed for some in (free, sparse)]
        kept = kept.and_then(cells_of(keys), float(now), keep, *packed)
        last.update(dict.fromkeys(sparse.intersection(last), now))
        last.update(dict.fromkeys(keys, now))
        last = {
            key: seen
            for key, seen in last.items()
            if seen == now or (now - seen <= keep and key not in free)
        }
        found = dict(zip(map(tuple, kept.cells.keys().tolist()), kept.seen.tolist(), strict=True))
        assert found == last


def test_another_resolution_begins_anew():
    before = KeptCells.none(1.0).and_then(cells_of([(0, 0, 0)]), 0.0, math.inf)
    after = before.and_then(cells_of([(5, 5, 5)], 0.5), 1.0, math.inf)
    assert after.cells.keys().tolist() == [[5, 5, 5]]


def test_no_map_grows_without_end(monkeypatch):
    monkeypatch.setattr(keeping, 'MOST_CELLS', 3)
    before = KeptCells.none(1.0).and_then(cells_of([(0, 0, 0), (1, 0, 0)]), 0.0, math.inf)
    with pytest.raises(MapError, match='may have 3'):
        before.and_then(cells_of([(5, 5, 5), (6, 5, 5)]), 1.0, math.inf)


def crosses(origin, end, low, high):
    """Return whether a segment meets the inside of a box: the slabs' test."""
    way = end - origin
    with np.errstate(divide='ignore', invalid='ignore'):
        first, last = (low - origin) / way, (high - origin) / way
    near = np.nanmax(np.minimum(first, last))
    return near < min(1.0, np.nanmin(np.maximum(first, last)))


@given(
    st.tuples(*[st.floats(-4, 4)] * 3),
    st.lists(st.tuples(*[st.integers(-8, 8)] * 3), min_size=1, max_size=5, unique=True),
)
@settings(max_examples=200)
def test_only_cells_on_the_way_are_free_and_none_that_was_hit(origin, hits):
    origin, hit = np.array(origin), cells_of(hits)
    free = Cells(1.0, seen_through(origin, hit))
    keys = {tuple(key) for key in free.keys().tolist()}
    for key in keys:
        low = np.array(key, dtype=np.float64)
        assert any(crosses(origin, centre, low - 1e-9, low + 1 + 1e-9) for centre in hit.centres())
    # Nor what stands next to where a ray ends, along it.
    for centre, key in zip(hit.centres(), hit.keys(), strict=True):
        one = Cells(1.0, seen_through(origin, cells_of([key.tolist()])))
        gaps = np.linalg.norm(one.centres() - centre, axis=1)
        assert (gaps > 1.0).all()


def test_a_ray_frees_what_stands_in_its_middle():
    held = KeptCells.none(0.1).and_then(cells_of([(20, 0, 0), (0, 20, 0)], 0.1), 0.0, math.inf)
    wall = cells_of([(40, 0, 0)], 0.1)
    free = seen_through(np.array([0.05, 0.05, 0.05]), wall)
    after = held.and_then(wall, 1.0, math.inf, free)
    assert after.cells.keys().tolist() == [[0, 20, 0], [40, 0, 0]]


def test_rays_are_sampled_in_parts_with_the_same_result(monkeypatch):
    origin, hit = (
        np.zeros(3),
        Cells.of_points(np.random.default_rng(1).normal(size=(200, 3)), 0.05),
    )
    whole = seen_through(origin, hit)
    monkeypatch.setattr(keeping, '_MOST_SAMPLES', 50)
    assert seen_through(origin, hit).tolist() == whole.tolist()
    assert len(whole) > 500
