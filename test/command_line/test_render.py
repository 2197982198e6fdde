"""`render`: a scene file in, pictures out."""

import csv

import numpy as np
import pytest
from conventions.source_tree import ROOT
from viewing.scenes import PRESSING

from drake_geom_ros.command_line.pictures import millimetres
from drake_geom_ros.command_line.program import main
from drake_geom_ros.command_line.render import looking

Image = pytest.importorskip('PIL.Image')
pytest.importorskip('matplotlib')

SCENE = """\
frames: [{name: ball, pose: {position: [0, 0, 2]}}]
geometries:
- name: ball
  frame: ball
  shape: {type: sphere, radius: 0.5}
  roles: {perception: {phong: {diffuse: {rgba: [1, 0, 0, 1]}}, label: {id: 9}}}
cameras:
- {name: up, size: [33, 25], intrinsics: [40, 40, 16.5, 12.5]}
- {name: far, size: [5, 5], pose: {position: [0, 0, -50]}, images: [depth], far: 60}
"""
POSES = 'time,frame,x,y,z,qx,qy,qz,qw\n0,ball,0,0,2,0,0,0,1\n1,ball,0,0,3,0,0,0,1\n'


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(SCENE)
    return str(path)


def render(folder, *arguments):
    assert main(['render', *arguments, '--out', str(folder)]) == 0
    return sorted(path.name for path in folder.iterdir())


def pixels(path):
    return np.asarray(Image.open(path))


def test_a_camera_of_the_file_writes_its_images(tmp_path, scene):
    out = tmp_path / 'out'
    assert render(out, scene, '--camera', 'up') == [
        'up_color.png',
        'up_depth.png',
        'up_depth_map.png',
        'up_label.png',
        'up_label_legend.csv',
        'up_label_map.png',
    ]
    assert pixels(out / 'up_color.png')[12, 16].tolist()[1:] == [0, 0, 255]
    depth = pixels(out / 'up_depth.png')
    assert (depth[12, 16], depth[0, 0]) == (1500, 0)
    assert depth.dtype == np.uint16
    assert pixels(out / 'up_label.png')[12, 16] == 9
    (row,) = csv.DictReader((out / 'up_label_legend.csv').read_text().splitlines())
    assert (row['label'], row['geometry']) == ('9', 'scene::ball/ball')
    assert int(row['pixels_of_label']) == (pixels(out / 'up_label.png') == 9).sum() > 100


def test_all_cameras_and_all_moments(tmp_path, scene, capsys):
    poses = tmp_path / 'poses.csv'
    poses.write_text(POSES)
    out = tmp_path / 'out'
    names = render(out, scene, '--poses', str(poses))
    assert {'up_0000_depth.png', 'up_0001_depth.png', 'far_0001_depth.png'} <= set(names)
    assert not any(name.startswith('far_0000_color') for name in names)
    middles = [pixels(out / f'up_000{k}_depth.png')[12, 16] for k in range(2)]
    assert middles == [1500, 2500]
    one = tmp_path / 'one'
    render(one, scene, '--camera', 'up', '--poses', str(poses), '--time', '0.5')
    assert pixels(one / 'up_depth.png')[12, 16] == 1500


def test_a_camera_from_somewhere_shows_collision_shapes_where_nothing_else_is(tmp_path, capsys):
    scene = str(ROOT / 'scenes/minimal.yaml')
    looks = ('--from', '3', '0', '1', '--at', '0', '0', '1', '--size', '40', '30')
    names = render(tmp_path / 'out', scene, *looks)
    assert 'camera_color.png' in names
    assert 'has the perception role' in capsys.readouterr().out
    assert len(np.unique(pixels(tmp_path / 'out/camera_label.png'))) > 2


def test_a_camera_looks_where_it_is_told():
    for at in ([0, 0, 0], [5, 5, 5], [1.0, 2.0, 9.0]):
        X_WC = looking([1.0, 2.0, 3.0], at)
        ahead = X_WC.inverse().multiply(np.array(at, dtype=float))
        np.testing.assert_allclose(ahead[:2], 0.0, rtol=0, atol=1e-12)
        assert ahead[2] > 0
        # Down in the image is down in the world, but for a look straight up.
        assert X_WC.rotation().matrix()[2, 1] <= 1e-12


def test_millimetres_leave_out_what_has_no_depth():
    depths = np.array([0.0, 0.0004, 1.2345, 65.534, 65.6, np.inf], np.float32)
    assert millimetres(depths).tolist() == [0, 0, 1234, 65534, 0, 0]


def test_contact_surfaces_are_drawn_where_they_are_asked_for(tmp_path, capsys):
    scene = tmp_path / 'pressing.yaml'
    scene.write_text(PRESSING)
    looks = ('--from', '0.3', '-0.5', '0.4', '--at', '0', '0', '0', '--size', '80', '60')
    assert 'camera_view.png' not in render(tmp_path / 'bare', str(scene), *looks)
    assert 'contact surface' not in capsys.readouterr().out
    assert 'camera_view.png' in render(tmp_path / 'out', str(scene), *looks, '--contacts')
    told = capsys.readouterr().out
    assert 'camera: 1 contact surface, from no pressure (dark blue) to ' in told
    assert 'camera: NOT SHOWN: 1 pair that overlaps without a contact surface' in told
    other = ('--see-through', '1.0')
    render(tmp_path / 'other', str(scene), *looks, *other)
    shown, plain = (pixels(tmp_path / each / 'camera_view.png') for each in ('out', 'other'))
    assert (shown != plain).any(axis=2).sum() > 20


@pytest.mark.parametrize(
    ('arguments', 'why'),
    [
        (('--camera', 'none'), "no camera 'none'; it has up, far"),
        (('--from', '1', '2', '3'), '--from and --at go together'),
        (('--from', '1', '2', '3', '--at', '1', '2', '3'), 'the same point'),
        (('--from', '1', '2', '3', '--at', '0', '0', '0', '--fov-y', '4'), 'fov_y'),
        (('--time', '1'), '--time goes with --poses'),
    ],
)
def test_what_cannot_be_is_one_line(tmp_path, scene, capsys, arguments, why):
    assert main(['render', scene, *arguments, '--out', str(tmp_path / 'out')]) == 2
    assert why in capsys.readouterr().err


def test_a_scene_without_cameras_says_how_to_place_one(tmp_path, capsys):
    assert main(['render', str(ROOT / 'scenes/minimal.yaml'), '--out', str(tmp_path)]) == 2
    assert '--from X Y Z' in capsys.readouterr().err
