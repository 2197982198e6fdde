"""Height maps of SDFormat: grey images, scaled and turned as in Gazebo, and others refused."""

import sys

import numpy as np
import pytest
from PIL import Image

from drake_geom_ros.geometry import HeightField, SceneGraph
from drake_geom_ros.scene_files import load_scene, read_scene, save_scene
from drake_geom_ros.scene_files.errors import SceneFileError

# Rows of pixels, the first on top: at the largest y. Columns run along x.
GREYS = np.array([[0, 10, 20], [100, 50, 200]], dtype=np.uint8)
SIZE = (4.0, 2.0, 3.0)
# Ground height under each pixel, by (x, y): 200 is the brightest, and stands at 3 m.
HEIGHTS = {
    (-2, 1): 0.0, (0, 1): 0.15, (2, 1): 0.3,
    (-2, -1): 1.5, (0, -1): 0.75, (2, -1): 3.0,
}  # fmt: skip


def written(folder, pixels=GREYS, inside='', size='4 2 3', name='ground.png', pose=''):
    """Write a model with an image as ground; return its path."""
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    image.save(folder / name)
    path = folder / 'ground.sdf'
    path.write_text(
        '<sdf version="1.9"><model name="ground"><static>true</static><link name="l">'
        f'<collision name="c">{pose}<geometry><heightmap><uri>{name}</uri><size>{size}</size>'
        f'{inside}</heightmap></geometry></collision></link></model></sdf>\n'
    )
    return path


def shape_in(path):
    (geometry,) = read_scene(path).geometries
    return geometry.shape


def query_of(path):
    scene_graph = SceneGraph()
    load_scene(path, scene_graph)
    context = scene_graph.CreateDefaultContext()
    return scene_graph.get_query_output_port().Eval(context)


def test_pixels_are_heights_with_the_first_row_at_the_largest_y(tmp_path):
    """A point just above each pixel is out of the ground, and one just below is in it."""
    query = query_of(written(tmp_path, inside='<pos>10 20 30</pos>'))
    at = np.array([(10 + 0.999 * x, 20 + 0.999 * y, 30 + z) for (x, y), z in HEIGHTS.items()])
    up = np.array([0, 0, 0.02])
    assert (query.ComputeSignedDistanceToPoint(at + up).distance > 0.0).all()
    assert (query.ComputeSignedDistanceToPoint(at - up).distance < 0.0).all()


def test_the_pose_of_the_collision_turns_the_ground(tmp_path):
    """A quarter turn about z carries the corner at (2, -1) to (1, 2)."""
    quarter = '<pose degrees="true">0 0 0 0 0 90</pose>'
    query = query_of(written(tmp_path, pose=quarter, inside='<pos>0 0 1</pos>'))
    above, below = query.ComputeSignedDistanceToPoint(
        np.array([[0.999, 1.999, 4.02], [0.999, 1.999, 3.98]])
    ).distance
    assert below < 0.0 < above


@pytest.mark.parametrize(
    'pixels',
    [
        GREYS.astype(np.uint16) * 257,
        Image.fromarray(GREYS).convert('RGB'),
        Image.fromarray(GREYS).convert('RGBA'),
        Image.fromarray(GREYS).convert('LA'),
        Image.fromarray(GREYS).convert('P'),
        Image.fromarray(GREYS.astype(np.int32) * 257),
    ],
    ids=['16 bits', 'RGB', 'RGBA', 'LA', 'palette', '32 bits'],
)
def test_grey_images_of_all_kinds_are_the_same_ground(tmp_path, pixels):
    found = shape_in(written(tmp_path, pixels, name='ground.tiff'))
    expected = shape_in(written(tmp_path))
    np.testing.assert_allclose(found.heights(), expected.heights(), rtol=1e-15)
    np.testing.assert_array_equal(found.xs(), [-2.0, 0.0, 2.0])
    np.testing.assert_array_equal(found.ys(), [-1.0, 1.0])


def test_the_ground_is_deep_and_a_black_image_is_flat(tmp_path):
    assert shape_in(written(tmp_path)).base() == -max(SIZE)
    flat = shape_in(written(tmp_path, 0 * GREYS))
    assert isinstance(flat, HeightField)
    assert (flat.heights() == 0.0).all()


def test_a_saved_scene_has_the_ground_without_its_image(tmp_path):
    scene_graph = SceneGraph()
    load_scene(written(tmp_path), scene_graph)
    text = save_scene(scene_graph)
    (tmp_path / 'ground.png').unlink()
    assert shape_in(text) == shape_in(written(tmp_path))


@pytest.mark.parametrize(
    ('pixels', 'options', 'fault'),
    [
        (Image.new('RGB', (2, 2), (1, 2, 1)), {}, r'it has colours; read are grey'),
        (Image.new('L', (1, 9)), {}, r'it has 1 x 9 pixels; read are 2 x 2'),
        (Image.new('L', (1025, 1025)), {}, r'1025 x 1025 pixels; .*up to 524288'),
        (Image.new('F', (2, 2)), {'name': 'ground.tiff'}, r'its mode is F'),
        (GREYS, {'size': '1 1 -1'}, r'<size> of a <heightmap> is \[1.0, 1.0, -1.0\]'),
        (GREYS, {'size': '1 1 0'}, r'must be > 0'),
        (GREYS, {'size': '1 1'}, r"<size> is '1 1'; it must be 3 finite numbers"),
        (GREYS, {'inside': '<pos>0 0</pos>'}, r'<pos>'),
    ],
)
def test_other_grounds_are_refused_with_their_line(tmp_path, pixels, options, fault):
    with pytest.raises(SceneFileError, match=rf'ground.sdf:1: .*{fault}'):
        read_scene(written(tmp_path, pixels, **options))


def test_an_image_that_is_missing_cut_or_none_is_named(tmp_path):
    path = written(tmp_path)
    image = tmp_path / 'ground.png'
    image.write_bytes(image.read_bytes()[:-30])
    with pytest.raises(SceneFileError, match=r'ground.sdf:1: .*ground.png .*cannot be read'):
        read_scene(path)
    image.write_text('no image')
    with pytest.raises(SceneFileError, match=r'ground.png .*cannot be read'):
        read_scene(path)
    image.unlink()
    with pytest.raises(SceneFileError, match=r"'ground.png': there is no file"):
        read_scene(path)


def test_without_pillow_the_error_says_what_to_install(tmp_path, monkeypatch):
    path = written(tmp_path)
    monkeypatch.setitem(sys.modules, 'PIL', None)
    with pytest.raises(SceneFileError, match=r'pip install pillow'):
        read_scene(path)
