"""Pictures of a scene in a notebook's cell: what they show, and what they refuse."""

import io

import numpy as np
import pytest
from PIL import Image

from drake_geom_ros.batch import Joints
from drake_geom_ros.geometry import ArgumentError, GeometryError, PoseError, Role, SceneGraph
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.viewing import snapshot
from drake_geom_ros.viewing.notebook import show
from drake_geom_ros.viewing.snapshot import looking

# A big box with a small ball in it, of another source, and a second ball beside.
SCENE = """
sources: [outer, inner]
frames: [{name: f, source: inner, pose: {position: [0, 0, 0]}}]
geometries:
- {name: box, source: outer, shape: {type: box, size: [1, 1, 1]}}
- {name: in, source: inner, frame: f, shape: {type: sphere, radius: 0.2}}
- {name: beside, source: outer, pose: {position: [0.8, 0, 0]}, shape: {type: sphere, radius: 0.2}}
"""
VIEW = {'from_W': [0, -5, 0], 'at_W': [0, 0, 0], 'size': (200, 100)}


@pytest.fixture
def scene_graph():
    found = SceneGraph()
    load_scene(SCENE, found)
    return found


def test_a_cell_gets_a_png_of_the_scene(scene_graph):
    shown = show(scene_graph, **VIEW)
    found = Image.open(io.BytesIO(shown._repr_png_()))
    assert found.format == 'PNG'
    assert found.size == (200, 100)
    np.testing.assert_array_equal(np.asarray(found), shown.pixels)


def test_what_is_inside_is_seen_through_bodies_only(scene_graph):
    covered = show(scene_graph, see_through=1.0, max_distance=-1.0, **VIEW).pixels
    seen = show(scene_graph, see_through=0.3, max_distance=-1.0, **VIEW).pixels
    middle, aside = (50, 100), (50, 85)  # on the ball in the box, and on the box alone
    assert np.abs(covered[middle].astype(int) - covered[aside]).max() <= 12
    assert np.abs(seen[middle].astype(int) - seen[aside]).max() > 40


def test_bands_of_rows_are_one_picture(scene_graph, monkeypatch):
    found = show(scene_graph, see_through=0.3, **VIEW).pixels
    for band in (7, 10_000):
        monkeypatch.setattr(snapshot, '_BAND', band)
        assert np.array_equal(show(scene_graph, see_through=0.3, **VIEW).pixels, found)


def test_nearest_points_are_drawn_over_all_else_orange_where_bodies_overlap(scene_graph):
    bare = show(scene_graph, see_through=1.0, max_distance=-1.0, **VIEW).pixels
    near = show(scene_graph, see_through=1.0, max_distance=0.01, **VIEW).pixels
    changed = (bare != near).any(axis=2)
    assert changed.any()
    orange = near[changed].astype(int)
    assert ((orange[:, 0] > 200) & (orange[:, 2] < 20)).any()
    blue = show(scene_graph, see_through=1.0, max_distance=0.5, **VIEW).pixels
    assert ((blue[..., 2] > 200) & (blue[..., 0] < 60)).any()


def test_only_the_nearest_pairs_are_drawn(scene_graph):
    def drawn(nearest):
        return show(scene_graph, max_distance=1.0, nearest=nearest, **VIEW).pixels

    none, one, every = drawn(0), drawn(1), drawn(10)
    np.testing.assert_array_equal(none, show(scene_graph, max_distance=-1.0, **VIEW).pixels)
    changed = [(each != none).any(axis=2) for each in (one, every)]
    assert 0 < changed[0].sum() < changed[1].sum()
    assert not (changed[0] & ~changed[1]).any()


def test_without_a_camera_all_of_the_scene_is_in_sight(scene_graph):
    pixels = show(scene_graph, see_through=1.0, size=(160, 120)).pixels
    background = pixels[0, 0]
    other = (np.abs(pixels.astype(int) - background) > 20).any(axis=2)
    rows, columns = np.flatnonzero(other.any(axis=1)), np.flatnonzero(other.any(axis=0))
    assert 0 < rows[0] < rows[-1] < 119
    assert 0 < columns[0] < columns[-1] < 159
    assert rows[-1] - rows[0] > 60 or columns[-1] - columns[0] > 80


def test_a_state_of_joints_moves_the_robot_and_not_the_context():
    from batch.conftest import Cell

    cell = Cell()
    context = cell.scene_graph.CreateDefaultContext()
    some = {'from_W': [3, -3, 2], 'at_W': [0, 0, 0.5], 'size': (160, 120)}
    a, b = (show(context, cell.joints, q, **some).pixels for q in cell.states(2))
    assert (a != b).any()
    with pytest.raises(PoseError, match='never had a pose'):
        show(context, **some)
    assert isinstance(cell.joints, Joints)


def test_what_cannot_be_shown_is_refused(scene_graph):
    with pytest.raises(ArgumentError, match='role kPerception'):
        show(scene_graph, role=Role.kPerception)
    with pytest.raises(ArgumentError, match='go together'):
        show(scene_graph, from_W=[1, 1, 1])
    with pytest.raises(ArgumentError, match='go together'):
        show(scene_graph, q=[0.0])
    with pytest.raises(GeometryError, match='see_through'):
        show(scene_graph, see_through=0.0)
    with pytest.raises(ArgumentError, match='not None'):
        show(None)
    with pytest.raises(ArgumentError, match='the same point'):
        looking([1, 1, 1], [1, 1, 1])
