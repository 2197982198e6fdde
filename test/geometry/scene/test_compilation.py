"""Once everything is compiled, no query of any scene compiles anything."""

import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes

CODE = """
import numpy as np
from numba.core import event
from drake_geom_ros import geometry as g
from drake_geom_ros.batch import Checker, Joints, evaluate
from drake_geom_ros.geometry.render import CameraProperties
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.math import RigidTransform

told = []
kernels = g.compile_all_kernels(lambda *what: told.append(what))
graph = g.SceneGraph()
whole = g.RenderEngineExactParams(role=g.Role.kProximity)
graph.AddRenderer('exact', g.MakeRenderEngineExact(whole))
source = graph.RegisterSource('s')
corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
mesh = g.MeshData(corners, faces)
solid = g.ProximityProperties()
solid.AddProperty('mesh', 'solid', True)
shapes = [
    g.Sphere(1), g.Box(1, 1, 1), g.Capsule(1, 1), g.Cylinder(1, 1), g.Ellipsoid(1, 2, 3),
    g.Convex.FromMeshData(mesh), g.Mesh.FromMeshData(mesh), g.HalfSpace(),
    g.OccupiedCells(1.0, np.zeros((1, 3))),
]
poses = g.FramePoseVector()
with event.install_recorder('numba:compile') as recorder:
    for k, shape in enumerate(2 * shapes):
        frame = graph.RegisterFrame(source, g.GeometryFrame(f'f{k}'))
        instance = g.GeometryInstance(RigidTransform(), shape, f'g{k}')
        properties = solid if isinstance(shape, g.Mesh) else g.ProximityProperties()
        instance.set_proximity_properties(properties)
        graph.RegisterGeometry(source, frame, instance)
        poses.set_value(frame, RigidTransform([0.4 * k, 0, 0]))
    context = graph.CreateDefaultContext()
    graph.get_source_pose_port(source).FixValue(context, poses)
    query = graph.get_query_output_port().Eval(context)
    some = g.GeometrySet(graph.model_inspector().GetAllGeometryIds()[:2])
    declared = g.CollisionFilterDeclaration().ExcludeWithin(some)
    manager = graph.collision_filter_manager(context)
    filters = [manager.ApplyTransient(declared) for _ in range(2)]
    for level in g.ACCURACY_LEVELS:
        query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
        query.ComputePointPairPenetration(accuracy=level, time_budget=1e-9)
        query.HasCollisions(accuracy=level)
        _ = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level).gradients
        _ = query.ComputePointPairPenetration(accuracy=level).gradients
    query.FindCollisionCandidates()
    _ = query.ComputeSignedDistanceToPoint(np.zeros((3, 3))).gradients
    manager.RemoveDeclaration(filters[0])
    camera = CameraProperties(8, 8, 1.0, 'exact')
    query.render_images(camera, graph.world_frame_id(), RigidTransform([0, 0, -9]))
    pressed = g.SceneGraph()
    soft = pressed.RegisterSource('soft')
    poses = g.FramePoseVector()
    for k, shape in enumerate((g.HalfSpace(), g.Sphere(1), g.Box(1, 1, 1), g.Cylinder(1, 1))):
        properties = g.ProximityProperties()
        if k % 2:
            g.AddCompliantHydroelasticProperties(1.0, 1.0, properties)
        else:
            g.AddRigidHydroelasticProperties(1.0, properties)
        frame = pressed.RegisterFrame(soft, g.GeometryFrame(f'f{k}'))
        instance = g.GeometryInstance(RigidTransform(), shape, f'g{k}')
        instance.set_proximity_properties(properties)
        pressed.RegisterGeometry(soft, frame, instance)
        poses.set_value(frame, RigidTransform([0.4 * k, 0, 0.2 * k]))
    squeezed = pressed.CreateDefaultContext()
    squeezed.UpdateFramePoses(poses)
    asked = pressed.get_query_output_port().Eval(squeezed)
    found, _ = asked.ComputeContactSurfacesWithFallback()
    assert len(found) > 2
    of_arms, states = g.SceneGraph(), {}
    joints = Joints.of(load_scene('test/batch/cell.yaml', of_arms))
    for scene in (graph, of_arms):
        for want in ('collision', 'least', 'nearest', 'within', 'points'):
            points = np.zeros((2, 3)) if want == 'points' else None
            states = {'frame_ids': [], 'poses': np.zeros((2, 0, 7))}
            if scene is of_arms:
                states = {'states': np.zeros((2, joints.count)), 'joints': joints}
            evaluate(
                context if scene is graph else scene, want=want, points=points, threads=1, **states
            )
    checker = Checker(of_arms, joints, 0.1)
    checker.free_each(np.zeros((2, joints.count)))
    checker.nearest(np.zeros(joints.count))
print(len(recorder.buffer), len(kernels), len(query.ComputeSignedDistanceToPoint([0, 0, 9])))
"""


def test_no_query_compiles_after_everything_is_compiled():
    done = subprocess.run([sys.executable, '-c', CODE], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    compiled, kernels, geometries = map(int, done.stdout.split())
    assert (compiled, geometries) == (0, 18)
    assert kernels > 20
