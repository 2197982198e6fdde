"""Mesh files as scenes of one body."""

from pathlib import Path

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.geometry.meshes._formats import FORMATS
from drake_geom_ros.geometry.meshes._obj_file import obj_text
from drake_geom_ros.scene_files import RobotOptions, SceneFileError, load_scene, read_scene
from drake_geom_ros.scene_files.mesh_scenes import MESH_SUFFIXES, source_name

NOTCHED = np.vstack((BOX, np.add(BOX, [2, 0, 0])))  # two boxes with a gap
PAIR = obj_text(NOTCHED, np.vstack((SIDES, SIDES + 8)))


@pytest.fixture
def path(tmp_path):
    path = tmp_path / 'left-part 2.OBJ'
    path.write_text(PAIR)
    return path


def test_every_format_of_meshes_is_a_scene():
    assert sorted(suffix.removeprefix('.') for suffix in MESH_SUFFIXES) == sorted(FORMATS)


def test_it_is_one_body_at_the_origin(path):
    scene_graph = SceneGraph()
    loaded = load_scene(path, scene_graph)
    assert list(loaded.geometries) == [('left_part_2', 'body', 'mesh')]
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)
    pose = query.GetPoseInWorld(loaded.frames['left_part_2', 'body'])
    assert pose.IsExactlyIdentity()
    distances = query.ComputeSignedDistanceToPoint(np.array([[4.0, 1.0, 1.0]]))
    assert distances.distance.tolist() == [1.0]


def test_it_is_a_solid_where_the_options_say_so(path):
    for patterns, is_solid in (((), False), (('*',), True), (('body/mesh',), True)):
        (geometry,) = read_scene(path, options=RobotOptions(solid_meshes=patterns)).geometries
        (properties,) = geometry.roles.values()
        assert properties.GetPropertyOrDefault('mesh', 'solid', False) is is_solid


@pytest.mark.parametrize(
    ('stem', 'name'),
    [('part', 'part'), ('2 parts', 'mesh_2_parts'), ('a.b-c', 'a_b_c'), ('_', 'mesh__')],
)
def test_the_source_is_named_as_the_file(stem, name):
    assert source_name(Path(f'{stem}.stl')) == name


def test_a_text_and_an_srdf_are_refused(path):
    with pytest.raises(SceneFileError, match='a mesh is a file'):
        read_scene(PAIR, format='mesh')
    with pytest.raises(SceneFileError, match='has no SRDF'):
        read_scene(path, srdf='robot.srdf')
    path.write_text('f 1 2 3\n')
    with pytest.raises(SceneFileError, match=r'there is no vertex 1|has no faces'):
        read_scene(path)


def test_commands_take_it_as_a_hull_or_as_a_solid(path, tmp_path, capsys):
    assert main(['check', str(path)]) == 0
    assert 'as its hull, 8 vertices' in capsys.readouterr().out
    assert main(['check', '--solid', str(path)]) == 0
    assert 'as a solid, 24 triangles' in capsys.readouterr().out
    scene = tmp_path / 'scene.yaml'
    assert main(['convert', '--solid', str(path), str(scene)]) == 0
    (geometry,) = read_scene(scene).geometries
    assert geometry.shape.filename() == str(path)
    assert main(['check', '--solid', str(scene)]) == 1
    assert '--solid is for a mesh file' in capsys.readouterr().err
