"""Polygons that are extruded, and zones, in scene files."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import Convex, Mesh, Role, SceneGraph
from drake_geom_ros.proximity_rules import SENSOR, zones_in
from drake_geom_ros.scene_files import SceneFileError, load_scene, read_scene, to_yaml
from drake_geom_ros.scene_files.polygons import prism_of

SQUARE = [[0, 0], [2, 0], [2, 2], [0, 2]]
ELL = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
STAR = [[0, 0], [2, 0], [0, 2], [2, 2]]  # crosses itself


def scene(points=SQUARE, height=1, more=''):
    shape = f'{{type: polygon, points: {points}, height: {height}}}'
    return f'geometries: [{{name: zone, shape: {shape}{more}}}]\n'


def bounds(shape):
    vertices = shape.mesh_data().vertices
    return vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()


@pytest.mark.parametrize('points', [SQUARE, SQUARE[::-1], [*SQUARE, SQUARE[0]]])
def test_a_convex_polygon_is_convex(points):
    shape = prism_of(points, [0.5, 1.5])
    assert isinstance(shape, Convex)
    assert bounds(shape) == ([0, 0, 0.5], [2, 2, 1.5])
    assert len(shape.mesh_data().vertices) == 8


@settings(max_examples=30)
@given(
    st.lists(st.floats(0.0, 6.28), min_size=3, max_size=9, unique=True),
    st.lists(st.floats(0.2, 2.0), min_size=9, max_size=9),
)
def test_the_volume_is_the_area_times_the_height(angles, radii):
    angles = np.sort(angles)
    if np.diff([*angles, angles[0] + 2 * np.pi]).max() > 3.0 or np.diff(angles).min() < 0.05:
        return
    outline = np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.c_[radii[: len(angles)]]
    x, y = outline.T
    area = 0.5 * abs(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()))
    data = prism_of(outline.tolist(), 2.0).mesh_data()
    a, b, c = np.moveaxis(data.vertices[data.triangles], 1, 0)
    volume = float(np.einsum('ij,ij->i', a, np.cross(b, c)).sum()) / 6.0
    assert volume == pytest.approx(2.0 * area)


@pytest.mark.parametrize(
    ('role', 'more'), [('kIllustration', ', sensor: true'), ('kProximity', '')]
)
def test_a_polygon_that_is_not_convex_is_a_solid(role, more):
    (geometry,) = read_scene(scene(ELL, more=more)).geometries
    assert isinstance(geometry.shape, Mesh)
    assert geometry.roles[Role[role]].GetProperty('mesh', 'solid') is True


@pytest.mark.parametrize(
    ('text', 'why'),
    [
        (scene(points=[[0, 0], [1, 1], [2, 2]]), 'no area'),
        (scene(height=0), 'a height > 0'),
        (scene(height=[1.0, 0.5]), 'a height > 0'),
        (scene(more=', sensor: true, roles: {proximity: {}}'), 'only rules see it'),
        (scene(more=', sensor: true, roles: {perception: {}}'), 'only rules see it'),
    ],
)
def test_what_is_refused(text, why):
    with pytest.raises(SceneFileError, match=why):
        read_scene(text)


@pytest.mark.parametrize('more', ['', ', sensor: true'])
def test_an_outline_that_crosses_itself_is_refused(more):
    with pytest.raises(SceneFileError):
        load_scene(scene(STAR, more=more), SceneGraph())


@pytest.mark.parametrize('points', [SQUARE, ELL])
def test_a_zone_comes_back(points):
    text = to_yaml(read_scene(scene(points, more=', sensor: true')))
    assert 'sensor: true' in text
    assert SENSOR[0] + ': {' not in text
    assert to_yaml(read_scene(text)) == text
    graph = SceneGraph()
    loaded = load_scene(text, graph)
    inspector = graph.model_inspector()
    assert list(zones_in(inspector)) == list(loaded.geometry_ids)
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 0
