"""MoveIt's text format of planning scenes: read as scenes, and written from scenes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import (
    Box,
    Convex,
    Cylinder,
    GeometryInstance,
    HalfSpace,
    Mesh,
    OccupiedCells,
    ProximityProperties,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, load_scene, read_scene
from drake_geom_ros.scene_files.moveit_scene_writer import to_moveit_scene

TABLE = """table top
* mug
0.5 0 0.4
0 0 0.7071067811865476 0.7071067811865476
2
cylinder
0.04 0.1
0 0 0.05
0 0 0 1
0.8 0.1 0.1 1
box
0.02 0.01 0.06
0.05 0 0.05
0 0 0 1
0 0 0 0
1
handle
0.06 0 0.05
0 0 0 1
* ground
0 0 0
0 0 0 1
1
plane
0 0 2 1
0 0 0
0 0 0 1
0 0 0 0
0
.
"""
OLD = """(noname)
* ball
1
sphere
0.1
1 2 3
0 0 0 1
0 0 0 0
.
"""
TETRAHEDRON = """mesh
4 4
0 0 0
1 0 0
0 1 0
0 0 1
0 2 1
0 1 3
0 3 2
1 2 3
"""


def object_of(shape):
    return f'bodies\n* body\n0 0 0\n0 0 0 1\n1\n{shape}0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n'


def read(text):
    return read_scene(text, format='moveit')


def loaded_from(text):
    scene_graph = SceneGraph()
    loaded = load_scene(text, scene_graph, format='moveit')
    context = scene_graph.CreateDefaultContext()
    return scene_graph, loaded, scene_graph.get_query_output_port().Eval(context)


def nearest(query, points):
    """Return the signed distance of each point to the nearest geometry."""
    found = query.ComputeSignedDistanceToPoint(points)
    least = np.full(len(points), np.inf)
    np.minimum.at(least, found.point_index, found.distance)
    return least


def test_objects_are_frames_with_shapes_and_subframes():
    scene_graph, loaded, query = loaded_from(TABLE)
    X_WM = query.X_WF(loaded.frames['planning_scene', 'mug'])
    np.testing.assert_allclose(X_WM.translation(), [0.5, 0.0, 0.4], rtol=0, atol=1e-15)
    X_WH = query.X_WF(loaded.frames['planning_scene', 'mug/handle'])
    np.testing.assert_allclose(X_WH.translation(), [0.5, 0.06, 0.45], rtol=0, atol=1e-12)
    inspector = scene_graph.model_inspector()
    shapes = {key[1:]: inspector.GetShape(id) for key, id in loaded.geometries.items()}
    assert {key: type(shape) for key, shape in shapes.items()} == {
        ('mug', 'cylinder_0'): Cylinder,
        ('mug', 'box_1'): Box,
        ('ground', 'plane_0'): HalfSpace,
    }
    assert (shapes['mug', 'cylinder_0'].radius(), shapes['mug', 'cylinder_0'].length()) == (
        0.04,
        0.1,
    )
    # The plane 2 z + 1 = 0, with the half space below.
    above = nearest(query, np.array([[5.0, 5.0, 0.0]]))
    assert above[0] == pytest.approx(0.5, abs=1e-12)


def test_objects_of_the_world_are_anchored():
    _, _, query = loaded_from(TABLE)
    assert len(query.FindCollisionCandidates()) == 0


def test_a_file_of_moveit_1_has_no_pose_of_an_object():
    scene = read(OLD)
    (frame,), (geometry,) = scene.frames, scene.geometries
    assert frame.X_PF.IsExactlyIdentity()
    assert isinstance(geometry.shape, Sphere)
    assert geometry.X_FG.translation().tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ('shape', 'kind', 'note'),
    [
        (TETRAHEDRON, Mesh, ''),
        ('cone\n0.1 0.3\n', Convex, 'pyramid of 64 sides'),
        ('plane\n0 0 1 0\n', HalfSpace, 'half space behind it'),
        ('mesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n0 1 2\n', None, 'volume'),
    ],
)
def test_shapes_that_are_read_otherwise_are_named(shape, kind, note):
    if kind is None:
        with pytest.raises(SceneFileError):
            read(object_of(shape))
        return
    scene = read(object_of(shape))
    assert isinstance(scene.geometries[0].shape, kind)
    assert note in ''.join(scene.warnings)


@pytest.mark.parametrize(
    ('old', 'new', 'words'),
    [
        ('0.5 0 0.4', '0.5 0 zero', ":3: '0.5 0 zero' is not the position of object 'mug'"),
        ('cylinder\n', 'prism\n', ":6: the type of a shape is 'prism'"),
        ('0.04 0.1', '0.04', ':7'),
        ('0.04 0.1', '-0.04 0.1', ':7: .*Cylinder'),
        ('0 0 0.7071067811865476 0.7071067811865476', '0 0 0.8 0.7', ':4'),
        ('* ground', '* mug', "the object 'mug' is there twice"),
        ('0\n.\n', '0\n', 'it ends where an object or the end is expected'),
        ('* ground', 'ground', 'is no object'),
        ('\n2\n', '\n-2\n', 'whole number'),
    ],
)
def test_what_is_no_scene_is_refused_with_its_line(old, new, words, tmp_path):
    file = tmp_path / 'top.scene'
    file.write_text(TABLE.replace(old, new, 1))
    with pytest.raises(SceneFileError, match=words):
        read_scene(file)


def test_what_comes_after_the_end_is_not_read_and_warned_of():
    scene = read(f'{TABLE}\n* late\n0 0 0\n')
    assert {frame.name for frame in scene.frames} == {'mug', 'mug/handle', 'ground'}
    (warning,) = [each for each in scene.warnings if 'late' in each]
    assert f':{len(TABLE.splitlines()) + 2}: the scene ends above' in warning
    assert not [each for each in read(f'{TABLE}\n \n').warnings if 'ends above' in each]


SCENE = """
sources: [cell, other]
frames:
- {{name: cart, source: cell, pose: {{position: [{x}, 2, 0.5], rpy: [0, 0.5, {x}]}}}}
- {{name: cart, source: other, pose: {{position: [0, -2, 0]}}}}
geometries:
- {{name: load, source: cell, frame: cart, shape: {{type: box, size: [1, 0.5, 0.25]}},
    pose: {{position: [0, 0, 1]}}}}
- {{name: wheel, source: cell, frame: cart, shape: {{type: cylinder, radius: 0.2, length: 0.1}}}}
- {{name: pill, source: other, frame: cart, shape: {{type: capsule, radius: 0.3, length: 0.8}}}}
- {{name: ball, source: cell, shape: {{type: sphere, radius: 0.3}}, pose: {{position: [4, 0, 0]}}}}
- {{name: floor, source: cell, shape: {{type: half_space}}, pose: {{position: [0, 0, -1]}}}}
"""


@settings(max_examples=10, deadline=None)
@given(x=st.floats(-3.0, 3.0), seed=st.integers(0, 10**6))
def test_what_is_written_reads_back_as_the_same_bodies(x, seed):
    scene_graph = SceneGraph()
    loaded = load_scene(SCENE.format(x=x), scene_graph)
    written = to_moveit_scene(scene_graph, loaded)
    assert written.left_out == ()
    _, back, query = loaded_from(written.text)
    assert {name for _, name in back.frames} == {'cell::cart', 'other::cart', 'ball', 'floor'}
    context = scene_graph.CreateDefaultContext()
    points = np.random.default_rng(seed).uniform(-5.0, 5.0, size=(300, 3))
    before = nearest(scene_graph.get_query_output_port().Eval(context), points)
    after = nearest(query, points)
    # A capsule is three bodies now: inside, each knows its own surface alone.
    outside = before > 0.0
    np.testing.assert_allclose(after[outside], before[outside], rtol=0, atol=1e-9)
    assert (after[~outside] <= 1e-9).all()


def test_subframes_and_colours_come_back():
    scene_graph, loaded, _ = loaded_from(TABLE)
    _, back, query = loaded_from(to_moveit_scene(scene_graph, loaded, 'table top').text)
    X_WH = query.X_WF(back.frames['planning_scene', 'mug/handle'])
    np.testing.assert_allclose(X_WH.translation(), [0.5, 0.06, 0.45], rtol=0, atol=1e-12)
    inspector = query.inspector()
    mug = back.geometries['planning_scene', 'mug', 'cylinder_0']
    colour = inspector.GetIllustrationProperties(mug).GetProperty('phong', 'diffuse')
    assert (colour.r(), colour.g(), colour.b(), colour.a()) == (0.8, 0.1, 0.1, 1.0)
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 3


def test_meshes_are_written_as_their_triangles():
    scene_graph, loaded, query = loaded_from(object_of(TETRAHEDRON))
    _, _, other = loaded_from(to_moveit_scene(scene_graph, loaded).text)
    points = np.random.default_rng(4).uniform(-1.0, 2.0, size=(200, 3))
    np.testing.assert_allclose(nearest(other, points), nearest(query, points), rtol=0, atol=1e-9)


def test_a_shape_that_moveit_has_not_is_refused():
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('cell')
    instance = GeometryInstance(RigidTransform(), OccupiedCells(0.5, np.zeros((1, 3))), 'map')
    instance.set_proximity_properties(ProximityProperties())
    geometry = scene_graph.RegisterAnchoredGeometry(source, instance)
    loaded = LoadedScene(geometries={('cell', 'world', 'map'): geometry})
    with pytest.raises(SceneFileError, match='cell::world/map: a OccupiedCells has no type'):
        to_moveit_scene(scene_graph, loaded)


def test_the_command_converts_both_ways_and_leaves_robots_out(tmp_path, capsys):
    (tmp_path / 'arm.urdf').write_text(
        '<robot name="arm"><link name="base"><collision><geometry><sphere radius="0.1"/>'
        '</geometry></collision></link></robot>'
    )
    scene = tmp_path / 'cell.yaml'
    scene.write_text(
        f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, pose: {{}}}}]\n' + SCENE.format(x=1.0)
    )
    target, back = tmp_path / 'cell.scene', tmp_path / 'back.yaml'
    assert main(['convert', str(scene), '--to', str(target)]) == 0
    assert capsys.readouterr().out == 'left out 1 geometry of robots and on them\n'
    assert main(['convert', str(target), str(back)]) == 0
    assert {frame.name for frame in read_scene(back).frames} == {
        'cell::cart',
        'other::cart',
        'ball',
        'floor',
    }
    assert main(['convert', str(scene), str(target), '--to', str(target)]) == 2
    assert main(['convert', str(scene)]) == 2


def test_a_scene_file_keeps_a_pose_to_the_bit():
    X = RigidTransform.FromArray([0.1, 1e-17, -3.3, 0.0, 0.0, 0.6, 0.8])
    row = ' '.join(map(repr, X.ToArray()[:3].tolist()))
    scene = read(TABLE.replace('0.5 0 0.4', row))
    assert scene.frames[0].X_PF.translation().tolist() == X.translation().tolist()
