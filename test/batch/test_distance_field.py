"""Fields of signed distances: queries about each point, closed forms, files."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from batch.conftest import Cell

from drake_geom_ros.batch import sample_sdf, volume_files
from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    PoseError,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

BOUNDS = [[-0.8, -0.7, -0.1], [0.9, 0.8, 1.0]]


@pytest.fixture(scope='module')
def posed():
    cell = Cell()
    context = cell.scene_graph.CreateDefaultContext()
    (poses,) = cell.joints.poses(cell.states(1))
    context.UpdateFramePoses(FramePoseVector.FromArrays(cell.joints.frame_ids, poses))
    cell.context = context
    return cell


def scene_of(shape, X_WG=None, **options):
    graph = SceneGraph()
    body = GeometryInstance(X_WG or RigidTransform(), shape, 'body')
    properties = ProximityProperties()
    for name, value in options.items():
        properties.AddProperty('proximity', name, value)
    body.set_proximity_properties(properties)
    graph.RegisterAnchoredGeometry(graph.RegisterSource('test'), body)
    return graph


def nearest_of(cell, points, ids=None):
    query = cell.scene_graph.get_query_output_port().Eval(cell.context)
    results = query.ComputeSignedDistanceToPoint(points)
    keep = np.isin(results.id_G, ids) if ids is not None else np.ones(len(results), dtype=bool)
    lower = np.full((len(points), results.id_G.max() + 1), np.inf)
    lower[results.point_index[keep], results.id_G[keep]] = results.distance[keep]
    return lower.min(axis=1), lower


@pytest.mark.parametrize('resolution', [0.31, 0.07])
def test_each_point_has_the_distance_of_its_nearest_geometry(posed, resolution):
    field = sample_sdf(posed.context, BOUNDS, resolution)
    points = field.points.reshape(-1, 3)
    expected, every = nearest_of(posed, points)
    np.testing.assert_allclose(field.distance.ravel(), expected, rtol=0, atol=1e-12)
    own = every[np.arange(len(points)), field.id_G.ravel()]
    np.testing.assert_allclose(own, expected, rtol=0, atol=1e-12)
    assert len(np.unique(field.id_G)) > 3
    np.testing.assert_array_equal(points[0], BOUNDS[0])
    assert (points[-1] >= np.array(BOUNDS[1]) - 1e-9).all()
    assert (points[-1] < np.array(BOUNDS[1]) + resolution).all()


def test_bodies_alone_and_threads(posed):
    names = [('things', 'world', name) for name in ('egg', 'pole')]
    ids = [posed.loaded.geometries[name] for name in names]
    field = sample_sdf(posed.context, BOUNDS, 0.1, ids, threads=1)
    values = [id.get_value() for id in ids]
    expected, _ = nearest_of(posed, field.points.reshape(-1, 3), values)
    np.testing.assert_allclose(field.distance.ravel(), expected, rtol=0, atol=1e-12)
    assert set(np.unique(field.id_G)) == set(values)
    again = sample_sdf(posed.context, BOUNDS, 0.1, ids[::-1], threads=3)
    for name in field._fields:
        np.testing.assert_array_equal(getattr(again, name), getattr(field, name))


def test_a_ball_has_its_closed_form():
    field = sample_sdf(scene_of(Sphere(0.3), RigidTransform([0.1, 0.2, 0.3])), BOUNDS, 0.09)
    offsets = field.points - [0.1, 0.2, 0.3]
    lengths = np.linalg.norm(offsets, axis=-1)
    off = np.abs(field.distance - (lengths - 0.3))
    assert (off <= field.error_bound + 1e-16).all()
    assert field.error_bound.max() < 1e-12
    np.testing.assert_allclose(
        field.gradient, offsets / lengths[..., np.newaxis], rtol=0, atol=1e-12
    )
    assert field.is_gradient_unique.all()


def test_a_padded_box_is_larger_and_not_unique_at_its_centre():
    plain, padded = (
        sample_sdf(scene_of(Box(0.2, 0.2, 0.2), **how), [[0, 0, 0], [0.4, 0.4, 0.4]], 0.1)
        for how in ({}, {'padding': 0.05})
    )
    np.testing.assert_allclose(padded.distance, plain.distance - 0.05, rtol=0, atol=1e-12)
    assert not plain.is_gradient_unique[0, 0, 0]
    assert plain.distance[0, 0, 0] == pytest.approx(-0.1)


def test_a_map_of_cells_has_its_field():
    cells = OccupiedCells(0.1, np.array([[0.05, 0.05, 0.05], [0.55, 0.05, 0.05]]))
    field = sample_sdf(scene_of(cells), [[0.05, 0.05, 0.05], [0.55, 0.05, 0.05]], 0.05)
    x = field.points[:, 0, 0, 0]
    expected = np.minimum(np.abs(x - 0.05), np.abs(x - 0.55)) - 0.05
    np.testing.assert_allclose(field.distance[:, 0, 0], expected, rtol=0, atol=1e-12)


def test_no_two_points_differ_by_more_than_their_way(posed):
    field = sample_sdf(posed.context, BOUNDS, 0.1)
    for axis in range(3):
        steps = np.abs(np.diff(field.distance, axis=axis))
        assert steps.max() <= 0.1 + 1e-9


def test_files_hold_the_field(posed, tmp_path):
    field = sample_sdf(posed.context, BOUNDS, 0.2)
    field.save(tmp_path / 'field.npy')
    np.testing.assert_array_equal(np.load(tmp_path / 'field.npy'), field.distance)
    field.save(tmp_path / 'field.npz')
    stored = np.load(tmp_path / 'field.npz')
    for name in field._fields:
        np.testing.assert_array_equal(stored[name], getattr(field, name))
    with pytest.raises(ArgumentError, match=r'\.npz, \.npy, \.nrrd or \.vdb'):
        field.save(tmp_path / 'field.txt')
    assert sorted(path.name for path in tmp_path.iterdir()) == ['field.npy', 'field.npz']


def test_nrrd_files_have_origin_and_spacing(posed, tmp_path):
    nrrd = pytest.importorskip('nrrd', reason='the extra nrrd')
    field = sample_sdf(posed.context, BOUNDS, 0.2)
    field.save(tmp_path / 'field.nrrd')
    distances, header = nrrd.read(str(tmp_path / 'field.nrrd'))
    np.testing.assert_array_equal(distances, field.distance)
    np.testing.assert_array_equal(header['space origin'], field.origin)
    np.testing.assert_array_equal(header['space directions'], 0.2 * np.eye(3))


def openvdb():
    """Return OpenVDB's Python module, if it is there for this NumPy."""
    try:
        return volume_files._openvdb()
    except ImportError:
        pytest.skip("OpenVDB's Python module is not there, or for another NumPy")


@pytest.mark.parametrize('lower', [[-0.5, -0.4, -0.3], [0.1, 0.2, 0.3]])
def test_vdb_files_are_level_sets_with_the_places_of_their_points(tmp_path, lower):
    vdb = openvdb()
    ball = scene_of(Sphere(0.3), RigidTransform([0.1, 0.2, 0.3]))
    field = sample_sdf(ball, [lower, [0.5, 0.45, 0.61]], 0.1)
    field.save(tmp_path / 'field.vdb')
    (grid,), _ = vdb.readAll(str(tmp_path / 'field.vdb'))
    assert (grid.name, grid.gridClass) == ('distance', vdb.GridClass.LEVEL_SET)
    assert grid.activeVoxelCount() == field.distance.size
    assert grid.background > np.abs(field.distance).max()
    values = grid.getConstAccessor()
    assert 0 < grid['error_bound'] < 1e-7
    lowest, highest = grid.evalActiveVoxelBoundingBox()
    assert lowest == (0, 0, 0)
    assert highest == tuple(n - 1 for n in field.distance.shape)
    for place in np.ndindex(field.distance.shape):
        point = grid.transform.indexToWorld(place)
        np.testing.assert_allclose(point, field.points[place], rtol=0, atol=1e-12)
        true = np.linalg.norm(np.subtract(point, [0.1, 0.2, 0.3])) - 0.3
        assert abs(values.getValue(place) - true) <= grid['error_bound']


@pytest.mark.parametrize(('suffix', 'module'), [('.nrrd', 'nrrd'), ('.vdb', 'openvdb')])
def test_a_missing_library_is_named_and_no_file_is_left(tmp_path, monkeypatch, suffix, module):
    for name in (module, 'pyopenvdb'):
        monkeypatch.setitem(sys.modules, name, None)  # as if it were not installed
    advice = {'.nrrd': r'drake_geom_ros\[nrrd\]', '.vdb': 'apt-get install python3-openvdb'}[
        suffix
    ]
    with pytest.raises(ImportError, match=advice):
        sample_sdf(scene_of(Sphere(0.3)), BOUNDS, 0.5).save(tmp_path / f'field{suffix}')
    assert list(tmp_path.iterdir()) == []


def test_a_module_for_another_numpy_is_refused(tmp_path, monkeypatch):
    """It would end the process."""
    boost = type('class', (type,), {'__module__': 'Boost.Python'})
    module = SimpleNamespace(
        FloatGrid=boost('FloatGrid', (), {}), __name__='pyopenvdb', __file__='pyopenvdb.so'
    )
    monkeypatch.setitem(sys.modules, 'openvdb', None)
    monkeypatch.setitem(sys.modules, 'pyopenvdb', module)
    monkeypatch.setattr(np, '__version__', '2.4.6')
    with pytest.raises(ImportError, match=r'made for NumPy 1, and this is NumPy 2\.4\.6'):
        sample_sdf(scene_of(Sphere(0.3)), BOUNDS, 0.5).save(tmp_path / 'field.vdb')
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (([[0, 0, 0], [1, 1, np.inf]], 0.1), 'bounds='),
        (([[0, 0], [1, 1]], 0.1), 'bounds='),
        (([[0, 0, 1], [1, 1, 0]], 0.1), 'above the upper'),
        ((BOUNDS, 0.0), 'resolution=0.0'),
        ((BOUNDS, np.nan), 'resolution=nan'),
        ((BOUNDS, 0.5, [-5]), 'geometries has -5'),
        ((BOUNDS, 0.5, []), 'no distance to sample'),
        ((BOUNDS, 0.5, None, -1), 'threads=-1'),
    ],
)
def test_bad_arguments_are_refused(posed, arguments, words):
    with pytest.raises(ArgumentError, match=words):
        sample_sdf(posed.context, *arguments)


def test_scenes_without_bodies_or_poses_are_refused():
    graph = SceneGraph()
    with pytest.raises(ArgumentError, match='no distance to sample'):
        sample_sdf(graph, BOUNDS, 0.5)
    source = graph.RegisterSource('test')
    frame = graph.RegisterFrame(source, GeometryFrame('frame'))
    body = GeometryInstance(RigidTransform(), Sphere(0.1), 'body')
    body.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(source, frame, body)
    with pytest.raises(PoseError, match='frame'):
        sample_sdf(graph, BOUNDS, 0.5)
