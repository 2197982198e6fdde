import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from drake_geom_ros.sensed_maps.cells import MOST_STEPS, Cells, MapError, unique_numbers

points = arrays(np.float64, st.tuples(st.integers(0, 40), st.just(3)), elements=st.floats(-50, 50))
resolutions = st.sampled_from([0.01, 0.05, 0.1, 0.3, 1.0, 7.5])


def test_a_multiple_to_within_rounding_joins_whole_cells():
    fine = Cells.of_keys(np.indices((6, 3, 3)).reshape(3, -1).T, 0.1)
    assert fine.coarser(0.3).keys().tolist() == [[0, 0, 0], [1, 0, 0]]


@given(points.filter(len), st.integers(0, 2**32))
@settings(max_examples=50)
def test_cells_that_are_moved_are_covered(cloud, seed):
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=rng).as_matrix()
    p, cells = rng.uniform(-1, 1, 3), Cells.of_points(cloud, 0.25)
    moved = cells.moved(R, p)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    inside = cells.centres()[:, np.newaxis] + 0.125 * rng.uniform(-0.999, 0.999, (20, 3))
    at_corners = cells.centres()[:, np.newaxis] + 0.125 * 0.999 * corners
    for places in (inside, at_corners):
        seen = Cells.of_points(places.reshape(-1, 3) @ R.T + p, 0.25)
        assert np.isin(seen.packed, moved.packed).all()


@given(points, resolutions, st.randoms(use_true_random=False))
def test_cells_do_not_depend_on_the_order_of_points(cloud, resolution, random):
    order = list(range(len(cloud)))
    random.shuffle(order)
    a, b = Cells.of_points(cloud, resolution), Cells.of_points(cloud[order], resolution)
    assert a.packed.tobytes() == b.packed.tobytes()


@given(points, resolutions)
def test_every_point_lies_in_a_cell_and_every_cell_holds_a_point(cloud, resolution):
    centres = Cells.of_points(cloud, resolution).centres()
    if not len(cloud):
        assert not len(centres)
        return
    reach = np.abs(cloud[:, np.newaxis] - centres).max(axis=2)
    half = resolution / 2 * (1 + 1e-12) + 1e-12
    assert (reach.min(axis=1) <= half).all()
    assert (reach.min(axis=0) <= half).all()


@given(points, resolutions)
def test_thinning_twice_is_thinning_once(cloud, resolution):
    once = Cells.of_points(cloud, resolution)
    twice = Cells.of_points(once.centres(), resolution)
    assert once.packed.tobytes() == twice.packed.tobytes()
    assert Cells.of_keys(once.keys(), resolution).packed.tobytes() == once.packed.tobytes()


@given(points, st.sampled_from([1.0, 1.25, 1.5, 2.0, 2.7, 3.0, 5.0]))
@example(np.array([[20.25, 0.0, 0.0]]), 2.7)
@settings(max_examples=50)
def test_coarser_cells_cover_the_finer_ones_and_touch_no_others(cloud, times):
    fine = Cells.of_points(cloud, 0.125)
    coarse = fine.coarser(0.125 * times)
    if not len(fine):
        assert not len(coarse)
        return
    # Points all over each fine cell, a hair within it or beyond: a border that is the same but for
    # rounding may count either way.
    steps = np.linspace(-1.0, 1.0, 5) * 0.0625
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    covering = [
        Cells.of_points(
            (fine.centres()[:, np.newaxis] + hair * grid).reshape(-1, 3), 0.125 * times
        ).packed
        for hair in (1 - 1e-9, 1 + 1e-9)
    ]
    assert np.isin(covering[0], coarse.packed).all()
    assert np.isin(coarse.packed, covering[1]).all()
    if times in (1.0, 2.0, 3.0, 5.0):  # whole cells, without any rounding
        assert covering[0].tolist() == coarse.packed.tolist()


def test_cells_tell_how_many_points_they_hold():
    cloud = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [3.1, 0.0, 0.0]]
    cells, counts = Cells.counted(cloud, 1.0)
    assert cells.packed.tolist() == Cells.of_points(cloud, 1.0).packed.tolist()
    found = dict(zip(map(tuple, cells.keys().tolist()), counts.tolist(), strict=True))
    assert sum(found.values()) == len(cloud)
    assert found[0, 0, 0] == 2


@pytest.mark.parametrize('bad', [np.nan, np.inf, -np.inf, 1e300, 0.1 * MOST_STEPS])
def test_a_point_that_is_nowhere_is_refused_by_its_number(bad):
    with pytest.raises(MapError, match='point 1 is'):
        Cells.of_points([[0.0, 0.0, 0.0], [0.0, bad, 0.0]], 0.1)


@pytest.mark.parametrize('resolution', [0.0, -1.0, np.nan, np.inf, 1e-9, 1e9])
def test_a_resolution_that_is_none_is_refused(resolution):
    with pytest.raises(MapError, match='must lie in'):
        Cells.of_points([[0.0, 0.0, 0.0]], resolution)


def test_a_finer_grid_is_refused():
    with pytest.raises(MapError, match='finer than the map'):
        Cells.of_points([[0.0, 0.0, 0.0]], 0.1).coarser(0.05)


@pytest.mark.parametrize(
    ('points', 'told'),
    [
        (np.zeros((3, 2)), r'\(3, 2\) must be \(n, 3\)'),
        (np.zeros(6), r'\(6,\) must be \(n, 3\)'),
        (np.zeros((2, 2, 3)), r'\(2, 2, 3\) must be \(n, 3\)'),
        (0.0, r'\(\) must be \(n, 3\)'),
        ([['a', 'b', 'c']], r'no numbers \(n, 3\)'),
        ([[1, 2, 3], [4, 5]], r'no numbers \(n, 3\)'),
        (None, r'must be \(n, 3\)|no numbers'),
    ],
)
def test_what_are_no_points_is_refused(points, told):
    with pytest.raises(MapError, match=told):
        Cells.of_points(points, 0.1)
    if isinstance(points, np.ndarray):
        with pytest.raises(MapError, match='must be'):
            Cells.of_keys(points.astype(np.int64), 0.1)


@pytest.mark.parametrize('resolution', ['x', '0.1', None, [0.1], 0.0, -1.0, np.nan, np.inf, 1e9])
def test_what_is_no_resolution_is_refused(resolution):
    for make in (
        lambda: Cells.of_points([[0.0, 0.0, 0.0]], resolution),
        lambda: Cells.of_keys(np.zeros((1, 3), dtype=np.int64), resolution),
        lambda: Cells.of_points([[0.0, 0.0, 0.0]], 0.1).coarser(resolution),
    ):
        with pytest.raises(MapError, match=r'resolution is .* m; it must lie in'):
            make()
    assert len(Cells.of_points([[0.0, 0.0, 0.0]], np.float32(0.1))) == 1


@given(values=st.lists(st.integers(-(2**62), 2**62)))
def test_unique_numbers_are_those_of_a_set(values):
    assert unique_numbers(np.array(values, dtype=np.int64)).tolist() == sorted(set(values))


def test_cells_stand_for_columns_between_two_heights():
    cells = Cells.of_points([[0.05, 0.05, 3.05], [0.05, 0.05, 0.15], [-0.05, 0.25, 0.05]], 0.1)
    columns = cells.extruded(0.05, 0.25)
    points = [[x, y, z] for x, y in ((0.05, 0.05), (-0.05, 0.25)) for z in (0.05, 0.15, 0.25)]
    expected = Cells.of_points([*points, [0.05, 0.05, 3.05]], 0.1)
    assert columns.packed.tolist() == expected.packed.tolist()


def test_columns_of_too_many_cells_are_refused():
    cells = Cells.of_points([[0.1 * k, 0.0, 0.0] for k in range(100)], 0.002)
    with pytest.raises(MapError, match='100 columns of 500000 cells'):
        cells.extruded(0.0, 1000.0)
