"""No command writes over a file that it reads, nor leaves half a file."""

import os
import shutil

import pytest
from conventions.source_tree import ROOT
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.command_line.program import main

SCENE = """
frames: [{name: ball, pose: {}}]
geometries:
- {name: part, shape: {type: convex, uri: part.obj}, pose: {position: [1, 0, 0]}}
- name: ball
  frame: ball
  shape: {type: sphere, radius: 0.2}
  roles: {proximity: {}, perception: {phong: {diffuse_map: up_color.png}}}
cameras: [{name: up, size: [8, 6], images: [color], pose: {position: [0, 0, -2]}}]
"""
POSES = 'time,frame,x,y,z,qx,qy,qz,qw\n0.0,ball,1.0,2.0,3.0,0.0,0.0,0.0,1.0\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'scene.yaml').write_text(SCENE)
    (tmp_path / 'part.obj').write_text(TETRAHEDRON)
    (tmp_path / 'poses.csv').write_text(POSES)
    (tmp_path / 'points.csv').write_text('x,y,z\n0,0,1\n')
    (tmp_path / 'robot.yaml').write_text('robots: [{name: r, urdf: cart.urdf.yaml}]\n')
    (tmp_path / 'cart.urdf.yaml').write_text('<robot name="r"><link name="l"/></robot>')
    (tmp_path / 'link.csv').symlink_to('poses.csv')
    shutil.copy(ROOT / 'docs/batches.png', tmp_path / 'up_color.png')
    return tmp_path


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


QUERY = ['query', 'scene.yaml', '--out']


@pytest.mark.parametrize(
    'arguments',
    [
        [*QUERY, 'scene.yaml'],
        [*QUERY, 'part.obj'],
        [*QUERY, 'up_color.png'],
        [*QUERY, 'poses.csv', '--poses', 'poses.csv'],
        [*QUERY, 'link.csv', '--poses', 'poses.csv'],
        [*QUERY, './points.csv', '--what', 'points', '--points', 'points.csv'],
        ['convert', 'scene.yaml', 'scene.yaml'],
        ['convert', 'poses.csv', 'link.csv'],
        ['convert', 'robot.yaml', 'cart.urdf.yaml'],
    ],
)
def test_an_input_is_not_written_over(folder, capsys, arguments):
    before = contents(folder)
    assert main(arguments) == 2
    assert 'that is read' in capsys.readouterr().err
    assert contents(folder) == before


def test_an_image_is_not_written_over_a_texture_of_its_scene(folder, capsys):
    pytest.importorskip('PIL')
    before = contents(folder)
    assert main(['render', 'scene.yaml', '--out', '.']) == 2
    assert 'up_color.png that is read' in capsys.readouterr().err
    assert contents(folder) == before
    assert main(['render', 'scene.yaml', '--out', 'out']) == 0


@pytest.mark.parametrize(
    'arguments',
    [['query', 'scene.yaml', '--out', 'new.csv'], ['convert', 'scene.yaml', 'new.yaml']],
)
def test_an_error_while_it_is_written_leaves_the_old(folder, capsys, monkeypatch, arguments):
    target = folder / arguments[-1]
    assert main(arguments) == 0
    before = target.read_bytes()

    def full(descriptor):
        raise OSError('no space left')

    monkeypatch.setattr(os, 'fsync', full)
    assert main(arguments) == 2
    assert 'no space left' in capsys.readouterr().err
    assert target.read_bytes() == before
    assert [name for name in os.listdir(folder) if name.startswith('.')] == []
