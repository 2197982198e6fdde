"""The core works in an interpreter where every ROS module raises on import."""

import subprocess
import sys
import textwrap
from importlib.util import find_spec

import pytest
from conventions.source_tree import PACKAGE, ROOT, SOURCES, module_of
from conventions.test_layers import LAYERS, room_of

pytestmark = pytest.mark.processes

# All whose room may not import ROS, rooms of the node among them.
CORE = [
    module_of(path)
    for path in SOURCES
    if 'ROS' not in LAYERS[room_of(str(path.relative_to(PACKAGE)))][1]
]

# Parts of pydrake whose import fails on purpose: see test/test_multibody.py.
NOT_REBUILT = ('drake_geom_ros.multibody', 'drake_geom_ros.systems')

NO_ROS = """
import sys


class NoRos:
    def find_spec(self, name, path=None, target=None):
        library = name.split('.')[0]
        if library.startswith(('rclpy', 'rosidl', 'ament', 'rcl_', 'rpyutils', 'tf2')) or (
            library.endswith(('_msgs', '_srvs', '_interfaces'))
        ):
            raise ImportError(f'{name} must not be imported here')


sys.meta_path.insert(0, NoRos())
"""


def run_without_ros(script):
    return subprocess.run(
        [sys.executable, '-c', NO_ROS + textwrap.dedent(script)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
    )


def test_ros_does_raise_there():
    result = run_without_ros('import rclpy')
    assert result.returncode == 1
    assert 'rclpy must not be imported here' in result.stderr


def test_every_module_of_the_core_imports():
    # Modules that draw by VTK or call CasADi are imported only where these are installed.
    rooms = {'vtkmodules': '.render.vtk.', 'casadi': '.casadi_callback'}
    left_out = [room for library, room in rooms.items() if find_spec(library) is None]
    modules = [
        name
        for name in CORE
        if not name.endswith('__main__')
        and name not in NOT_REBUILT
        and not any(room in name for room in left_out)
    ]
    result = run_without_ros(
        f'import importlib\nfor name in {modules}: importlib.import_module(name)'
    )
    assert result.returncode == 0, result.stderr


def test_a_scene_answers():
    result = run_without_ros("""
        from drake_geom_ros.geometry import (
            FramePoseVector, GeometryFrame, GeometryInstance, ProximityProperties, SceneGraph,
            Sphere,
        )
        from drake_geom_ros.math import RigidTransform

        scene = SceneGraph()
        source = scene.RegisterSource('demo')
        poses = FramePoseVector()
        for number, x in enumerate((0.0, 3.0)):
            frame = scene.RegisterFrame(source, GeometryFrame(f'frame{number}'))
            ball = scene.RegisterGeometry(
                source, frame, GeometryInstance(RigidTransform(), Sphere(1.0), f'ball{number}')
            )
            scene.AssignRole(source, ball, ProximityProperties())
            poses.set_value(frame, RigidTransform([x, 0.0, 0.0]))
        context = scene.CreateDefaultContext()
        scene.get_source_pose_port(source).FixValue(context, poses)
        query = scene.get_query_output_port().Eval(context)
        (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
        print(pair.distance)
        """)
    assert result.returncode == 0, result.stderr
    assert float(result.stdout) == 1.0
