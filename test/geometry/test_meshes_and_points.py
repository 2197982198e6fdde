"""A mesh and points: the body that its surface encloses, whatever it is in pairs; as pydrake."""

import json
import subprocess
import sys
import warnings
from importlib.util import find_spec

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene
from oracles.solids import surface_of

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import Box, Convex, Mesh, MeshData, Sphere
from truth.bodies import grids

VERTICES, TRIANGLES = grids.surface(grids.L)
L = MeshData(VERTICES, TRIANGLES)
NOTCH = [1.3, 1.3, 0.5]
POINTS = [NOTCH, [0.5, 0.5, 0.5], [3.0, 3.0, 3.0], [1.5, 1.5, 1.2], [0.9, 1.9, 0.7]]
ASK = """
import json, sys
from pydrake.common import MemoryFile
from pydrake.geometry import *
from pydrake.math import RigidTransform
text, kind, points = json.load(sys.stdin)
graph = SceneGraph()
source = graph.RegisterSource('s')
frame = graph.RegisterFrame(source, GeometryFrame('f'))
shape = globals()[kind](InMemoryMesh(mesh_file=MemoryFile(text, '.obj', 'mesh')))
body = GeometryInstance(RigidTransform(), shape, 'body')
body.set_proximity_properties(ProximityProperties())
graph.RegisterGeometry(source, frame, body)
context, poses = graph.CreateDefaultContext(), FramePoseVector()
poses.set_value(frame, RigidTransform())
graph.get_source_pose_port(source).FixValue(context, poses)
query = graph.get_query_output_port().Eval(context)
print(json.dumps([query.ComputeSignedDistanceToPoint(p)[0].distance for p in points]))
"""


def distances(shape, points=POINTS, **options):
    """The distances of points from a shape."""
    query = ShapeScene(shape, **options).posed([0, 0, 0]).query
    return query.ComputeSignedDistanceToPoint(np.array(points)).distance


def test_a_plain_mesh_is_its_hull_in_pairs_and_its_surface_to_points():
    mesh = Mesh.FromMeshData(L)
    np.testing.assert_array_equal(distances(mesh), distances(mesh, solid=True))
    assert distances(mesh)[0] == pytest.approx(0.3, abs=1e-15)
    assert distances(Convex.FromMeshData(L))[0] < -0.25
    assert ShapeScene(mesh, Sphere(0.1)).pair([0, 0, 0], NOTCH).distance < -0.25


@pytest.mark.processes
@pytest.mark.skipif(find_spec('pydrake') is None, reason='no pydrake')
@pytest.mark.parametrize('kind', [Mesh, Convex])
def test_pydrake_says_the_same(kind):
    text = ''.join('v {} {} {}\n'.format(*map(float, v)) for v in VERTICES)
    text += ''.join('f {} {} {}\n'.format(*(k + 1 for k in t)) for t in TRIANGLES)
    asked = json.dumps([text, kind.__name__, POINTS])
    told = subprocess.run(
        [sys.executable, '-c', ASK], input=asked, capture_output=True, text=True, check=True
    )
    np.testing.assert_allclose(
        distances(kind.FromMeshData(L)), json.loads(told.stdout), rtol=0, atol=1e-14
    )


def test_one_that_is_not_closed_is_its_hull_and_says_so_when_it_is_registered():
    opened = Mesh.FromMeshData(MeshData(VERTICES, TRIANGLES[:-1]))
    with pytest.warns(
        UserWarning, match='from points to this mesh are those to its convex hull, since.*open'
    ):
        scene = ShapeScene(opened)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        found = scene.posed([0, 0, 0]).query.ComputeSignedDistanceToPoint(np.array(POINTS))
    np.testing.assert_array_equal(found.distance, distances(Convex.FromMeshData(L)))


def test_a_closed_one_says_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        distances(Mesh.FromMeshData(L))


def test_among_others_copies_and_changes_of_the_scene():
    scene = ShapeScene(Box(0.1, 0.1, 0.1), Mesh.FromMeshData(L), Sphere(0.2))
    query = scene.posed([5, 0, 0], [0, 0, 0], [0, 5, 0]).query
    found = query.ComputeSignedDistanceToPoint(NOTCH)
    assert found.distance[1] == pytest.approx(0.3, abs=1e-15)
    assert list(found.distance) == list(
        scene.asked(scene.context.copy()).ComputeSignedDistanceToPoint(NOTCH).distance
    )
    assert list(found.distance) == list(
        scene.asked(scene.context.what_if()).ComputeSignedDistanceToPoint(NOTCH).distance
    )
    scene.graph.RemoveGeometry(scene.context, scene.source, scene.ids[0])
    left = query.ComputeSignedDistanceToPoint(NOTCH)
    assert list(left.distance) == list(found.distance[1:])


def test_in_a_batch_too():
    scene = ShapeScene(Mesh.FromMeshData(L), Sphere(0.2))
    poses = np.zeros((3, 2, 7))
    poses[:, :, 6], poses[:, 1, 1], poses[:, 0, 0] = 1.0, 5.0, [0.0, 0.1, 0.2]
    found = evaluate(scene.graph, scene.frames, poses, want='points', points=[NOTCH])
    assert found.distance[::2] == pytest.approx([0.3, 0.2, 0.1], abs=1e-15)


def test_the_surface_of_a_scaled_mesh_is_scaled():
    mesh = Mesh.FromMeshData(surface_of('L'), 2.0)
    assert distances(mesh, [np.multiply(2.0, NOTCH)])[0] == pytest.approx(0.6, abs=1e-14)
