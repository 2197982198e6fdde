"""What a scene imports: files of meshes bring trimesh, nothing else does."""

import os
import subprocess
import sys

import pytest
import trimesh
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes

# Uncompiled: what is imported does not hang on it.
ASK = """
import sys
from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
scene = SceneGraph()
loaded = load_scene(sys.argv[1], scene)
context = scene.CreateDefaultContext()
poses = dict.fromkeys(loaded.frames.values(), RigidTransform())
context.UpdateFramePoses(FramePoseVector(poses))
query = scene.get_query_output_port().Eval(context)
query.ComputeSignedDistancePairwiseClosestPoints(0.1)
query.ComputePointPairPenetration()
query.ComputeSignedDistanceToPoint([0, 0, 0], 0.5)
print(*sys.modules)
"""
NODE = """
import sys
import drake_geom_ros.ros.scene_graph_node
print(*sys.modules)
"""
BALL = '- {name: ball, frame: a, shape: {type: sphere, radius: 1}}'
HULL = '- {name: hull, shape: {type: convex, vertices: [[0,0,0], [1,0,0], [0,1,0], [0,0,1]]}}'
KERNELS = 'drake_geom_ros.geometry._proximity.kernels.'


def modules(code, *arguments):
    """Return what a process has imported that runs the code."""
    done = subprocess.run(
        [sys.executable, '-c', code, *arguments],
        cwd=ROOT,
        env={**os.environ, 'NUMBA_DISABLE_JIT': '1'},
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def scene(*geometries):
    return '\n'.join(['frames: [{name: a}, {name: b}]', 'geometries:', *geometries])


def test_a_scene_without_meshes_imports_no_mesh_library():
    """Two arms and a table: URDF, every primitive shape, every kind of query."""
    found = modules(ASK, str(ROOT / 'scenes/two_pandas.yaml'))
    assert not found & {'trimesh', 'fcl', 'yourdfpy', 'rclpy', 'matplotlib'}
    assert {'lxml', KERNELS + 'cores.gjk'} <= found


def test_a_hull_imports_qhull_and_a_mesh_file_its_reader(tmp_path):
    found = modules(ASK, scene(BALL, HULL))
    assert 'scipy.spatial' in found
    assert 'trimesh' not in found
    trimesh.creation.box().export(tmp_path / 'box.stl')
    of_file = f'- {{name: hull, shape: {{type: mesh, uri: {tmp_path}/box.stl}}}}'
    assert 'trimesh' in modules(ASK, scene(BALL, of_file))


def test_a_scene_of_spheres_imports_no_other_kernels():
    found = modules(ASK, scene(BALL, BALL.replace('frame: a', 'frame: b')))
    kernels = {name.removeprefix(KERNELS) for name in found if name.startswith(KERNELS)}
    # Bounds are computed by one function for all shapes, and so are pairs of extreme sizes.
    assert kernels == {
        *('addresses', 'pair_table', 'vectors', 'calling', 'closed_forms', 'shapes'),
        *(f'calling.{name}' for name in ('pairs', 'points', 'extremes')),
        *(
            f'closed_forms.{name}'
            for name in ('spheres', 'points', 'ellipsoid_point', 'to_points')
        ),
        *(f'shapes.{name}' for name in ('bounds', 'hull_packing', 'hulls', 'maps')),
        *(f'shapes.{name}' for name in ('summit', 'supports')),
        # Imported, and not compiled before somebody asks for derivatives.
        *('shapes.features', 'shapes.feature_borders'),
    }


def test_the_node_imports_no_mesh_library():
    pytest.importorskip('rclpy')
    assert not modules(NODE) & {'trimesh', 'fcl', 'yourdfpy', 'tf2_msgs'}
