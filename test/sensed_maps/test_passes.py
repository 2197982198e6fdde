"""Passes over the points of a cloud, against NumPy on whole arrays."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from drake_geom_ros.sensed_maps import passes
from drake_geom_ros.sensed_maps.cells import Cells

numbers = st.one_of(st.floats(-4, 4, width=32), st.sampled_from([np.nan, np.inf, -np.inf]))
clouds = arrays(np.float32, st.tuples(st.integers(0, 9), st.just(3)), elements=numbers)
# In single precision these two are at one distance from the origin.
ALIKE = np.array([[1e-4, 1.0, 1.0], [0.0, 1.0, 1.0]], np.float32)
boxes = arrays(np.float64, (2, 3), elements=st.floats(-4, 4))


def within_reach(cloud, reach, R, p, rows=1):
    """Return the points that are kept, and how many were finite."""
    grid = np.zeros((rows, len(cloud) // rows, 5), cloud.dtype)
    grid[..., 1:4] = cloud.reshape(rows, -1, 3)
    columns = passes.as_columns((grid[..., 1], grid[..., 2], grid[..., 3]))
    room = np.empty((len(cloud), 3))
    reached = passes.put_within_reach(columns, R, p, reach, room)
    return room[: reached.kept], reached.finite


@pytest.mark.parametrize('kind', ['<f4', '<f8', '>f4', '>f8'])
@given(cloud=clouds, reach=st.floats(0.01, 8), seed=st.integers(0, 2**32 - 1))
@example(cloud=ALIKE, reach=1.0, seed=0)
def test_points_within_reach_are_those_and_the_nearest_is_one(kind, cloud, reach, seed):
    rng = np.random.default_rng(seed)
    R, p = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-1, 1, 3)
    found, finite = within_reach(cloud.astype(kind), reach, R, p)
    some = cloud[np.isfinite(cloud).all(axis=1)].astype(float)
    assert finite == len(some)
    away = np.linalg.norm(some, axis=1)
    kept = some[away <= max(reach, away.min(initial=np.inf))]
    assert len(found) == len(kept)
    np.testing.assert_allclose(found, kept @ R.T + p, atol=1e-12, rtol=0)


def test_a_grid_of_points_is_read_row_by_row():
    cloud = np.arange(36.0).reshape(12, 3)
    for rows in (1, 2, 3, 12):
        found, _ = within_reach(cloud, 1e3, np.eye(3), np.zeros(3), rows)
        assert found.tolist() == cloud.tolist()


@pytest.mark.parametrize('shape', [(0, 0), (1, 1), (1, 3), (3, 1), (2, 2)])
@pytest.mark.parametrize('kind', ['<f4', '>f4', '<f8', '>f8'])
@pytest.mark.parametrize('room', [1, 4])
def test_for_all_arrays_there_are_two_versions(shape, kind, room):
    column = np.arange(np.prod(shape) * room).astype(kind).reshape(*shape, room)[..., 0]
    shown = passes.as_columns((column, column, column))
    for each in shown:
        assert not each.flags.forc
        assert not each.flags.writeable
        assert each.dtype == kind.replace('>', '<')
        assert each[: shape[0], : shape[1]].tolist() == column.tolist()
        assert np.isfinite(each).sum() == column.size
    assert column.flags.writeable  # what is given is left as it is


@given(clouds, st.floats(0.1, 2), st.integers(0, 2**32 - 1))
def test_points_in_cubes_are_found(cloud, edge, seed):
    rng, points = (
        np.random.default_rng(seed),
        np.nan_to_num(cloud, posinf=4.0, neginf=-4.0).astype(float),
    )
    flags, low = rng.uniform(size=(3, 4, 5)) < 0.5, rng.uniform(-2, 0, 3)
    found = np.empty(len(points), dtype=np.int64)
    count = passes.find_in_cubes(points, passes.Cubes(low, edge, flags), found)
    cubes = np.floor((points - low) / edge).astype(int)
    inside = ((cubes >= 0) & (cubes < flags.shape)).all(axis=1)
    expected = [k for k in np.flatnonzero(inside) if flags[tuple(cubes[k])]]
    assert found[:count].tolist() == expected


@given(clouds, boxes, st.integers(0, 2**32 - 1))
def test_points_in_a_box_are_kept_or_the_nearest_to_it(cloud, box, seed):
    points = np.nan_to_num(cloud, posinf=4.0, neginf=-4.0).astype(float)
    left_out = np.random.default_rng(seed).uniform(size=len(points)) < 0.3
    low, high = np.sort(box, axis=0)
    some = points[~left_out]
    room = points.copy()
    away = passes.keep_in_box(room, left_out, low, high)
    assert away.finite == len(some)
    beyond = np.maximum(low - some, some - high).max(axis=1, initial=0.0)
    kept = some[beyond == 0.0]
    if len(some) and not len(kept):
        kept = some[np.argmin(beyond)][None]
    assert room[: away.kept].tolist() == kept.tolist()


@given(clouds, st.sampled_from([0.01, 0.3, 1.0]))
def test_cells_are_counted_as_by_sorting_all_keys(cloud, resolution):
    points = np.nan_to_num(cloud, posinf=4.0, neginf=-4.0).astype(float)
    cells, counts = Cells.counted(points, resolution)
    keys, expected = np.unique(
        np.floor(points / resolution).astype(int), axis=0, return_counts=True
    )
    assert cells.keys().tolist() == keys.tolist()
    assert counts.tolist() == expected.tolist()


def test_more_cells_than_the_first_table_has_room_for():
    rng = np.random.default_rng(0)
    points = np.concatenate([np.zeros((100_000, 3)), rng.uniform(-5.0, 5.0, (200_000, 3))])
    cells, counts = Cells.counted(points, 0.001)
    assert counts.sum() == len(points)
    assert len(cells) > 190_000
    assert (np.diff(cells.packed) > 0).all()
    assert counts.max() >= 100_000


def test_a_point_that_is_nowhere_is_told_where_tables_grow():
    points = np.random.default_rng(0).uniform(-5.0, 5.0, (200_000, 3))
    points[150_000, 1] = np.nan
    with pytest.raises(ValueError, match='point 150000 is'):
        Cells.counted(points, 0.001)
