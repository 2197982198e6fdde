"""Compilation of all kernels in advance."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.engine.warm_up import compile_everything
from drake_geom_ros.geometry._proximity.runtime.compiled import (
    CACHE_FOLDER,
    Tell,
    compilation,
    kernels_in_words,
)
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH, read_poses
from drake_geom_ros.geometry.meshes.source import MeshData
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.hydroelastic_properties import (
    AddCompliantHydroelasticProperties,
)
from drake_geom_ros.geometry.model.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.model.properties import PerceptionProperties, ProximityProperties
from drake_geom_ros.geometry.queries.joint_gradients import JointGradients
from drake_geom_ros.geometry.queries.joint_queries import JointQueries
from drake_geom_ros.geometry.queries.joint_trees import JointTree, side_by_side
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries, MotionQuestion
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.state_queries import StateQueries
from drake_geom_ros.geometry.render.camera_properties import CameraProperties
from drake_geom_ros.geometry.render.exact import MakeRenderEngineExact
from drake_geom_ros.geometry.render.exact_params import RenderEngineExactParams
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.primitives import Box, Sphere
from drake_geom_ros.geometry.shapes.sensed import OccupiedCells
from drake_geom_ros.math import RigidTransform

_FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]  # of a tetrahedron, from outside


def compile_all_kernels(tell: Tell | None = None) -> list[str]:
    """Compile the kernels for any scene, or load them from the cache; return their names.

    Takes minutes the first time, and about a second later. ``tell(name, number, last)`` is called
    before each part that the cache lacks. ``SceneGraphContext.compile_kernels`` is for one scene.
    """
    kernels = compile_everything(tell)
    with compilation(tell, 'bodies', 1, 1):
        _register_bodies()
    compile_images(tell)
    with compilation(tell, 'batches of states', 1, 1):
        _answer_for_states()
    with compilation(tell, 'motions', 1, 1):
        _check_a_motion()
    with compilation(tell, 'contact surfaces', 1, 1):
        _press_two_bodies()
    return kernels


def compile_images(tell: Tell | None = None) -> None:
    """Compile the kernels for cameras, or load them from the cache."""
    with compilation(tell, 'images', 1, 1):
        _take_an_image()


def _take_an_image() -> None:
    """Render one pixel of a mesh, which runs all compiled code of the renderer."""
    scene_graph = SceneGraph()
    for samples in (1, 2):
        params = RenderEngineExactParams(color_samples=samples)
        scene_graph.AddRenderer(str(samples), MakeRenderEngineExact(params))
    tetrahedron = MeshData(np.vstack((np.zeros(3), np.eye(3))), _FACES)
    instance = GeometryInstance(RigidTransform(), Mesh.FromMeshData(tetrahedron), 'tetrahedron')
    instance.set_perception_properties(PerceptionProperties())
    scene_graph.RegisterAnchoredGeometry(scene_graph.RegisterSource('images'), instance)
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    for renderer in ('1', '2'):
        camera = CameraProperties(1, 1, 1.0, renderer)
        query.render_images(camera, scene_graph.world_frame_id(), RigidTransform())


def _answer_for_states() -> None:
    """Run every query about one state of two balls, which runs all loops over states."""
    scene = _two_balls()
    queries, stop = StateQueries(scene), np.zeros(1, dtype=np.int64)
    poses = np.zeros((1, 2, 7))
    none, links = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    tree = JointTree(
        *(none, np.zeros(0), np.zeros(0), none, np.zeros((0, 3)), np.zeros((0, 7)), none, none)
    )
    for frame_row in range(2):
        X_WB = np.array([3.0 * frame_row, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        tree.put_poses(np.zeros((1, 0)), X_WB, links, poses, frame_row)
    queries.has_collisions(poses, 'exact', stop)
    queries.has_collisions(poses, 'exact', stop, margin=0.0)
    queries.within(poses, 'exact', math.inf, stop)
    queries.nearest(poses, 'exact', math.inf, 1, stop)
    queries.points(poses, np.zeros((1, 3)), math.inf, stop)
    read_poses(poses[0], np.empty((2, POSE_WIDTH)))  # of scenes with half spaces
    at_rest = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (2, 1))
    at_rest[1, 0] = 3.0
    chain = side_by_side([tree, tree], at_rest, [links, links])
    checks = JointQueries(scene, chain, np.zeros((2, 0)), 'exact', 0.0)
    checks.verdicts(np.zeros((1, 0)))
    checks.least(np.zeros((1, 0)))
    gradients = JointGradients(scene, chain, 0, 'exact')
    gradients.within(np.zeros((1, 0)), math.inf)
    gradients.least(np.zeros((1, 0)))
    gradients.of_rows(np.zeros((1, 0)), none, np.zeros((0, 2), dtype=np.int64), np.zeros((0, 12)))


def _check_a_motion() -> None:
    """Check a motion of two balls into contact, which runs all compiled code for motions."""
    queries = MotionQueries(_two_balls(), 'exact', np.zeros(1, dtype=np.int64))
    starts = np.tile(np.concatenate((np.eye(3).ravel(), np.zeros(3))), (2, 1))
    starts[1, 9], ends = 3.0, starts.copy()
    ends[1, 9] = 1.0
    queries.move(MotionQuestion(), starts, ends, 'slerp')


def _press_two_bodies() -> None:
    """Compute the contact surface of two soft boxes, which runs all compiled code for surfaces."""
    scene_graph, X_WFs = SceneGraph(), FramePoseVector()
    source = scene_graph.RegisterSource('boxes')
    for k, name in enumerate('ab'):
        properties = ProximityProperties()
        AddCompliantHydroelasticProperties(1.0, 1.0, properties)
        box = GeometryInstance(RigidTransform(), Box(1.0, 1.0, 1.0), name)
        box.set_proximity_properties(properties)
        frame = scene_graph.RegisterFrame(source, GeometryFrame(name))
        scene_graph.RegisterGeometry(source, frame, box)
        X_WFs.set_value(frame, RigidTransform([0.5 * k, 0.0, 0.0]))
    context = scene_graph.CreateDefaultContext()
    context.UpdateFramePoses(X_WFs)
    scene_graph.get_query_output_port().Eval(context).ComputeContactSurfaces()


def _register_bodies() -> None:
    """Register a hull, a solid and a map, which runs all compiled code that prepares bodies."""
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('bodies')
    tetrahedron = MeshData(np.vstack((np.zeros(3), np.eye(3))), _FACES)
    shapes = {
        'hull': Convex.FromMeshData(tetrahedron),
        'solid': Mesh.FromMeshData(tetrahedron),
        'map': OccupiedCells(1.0, np.zeros((1, 3))),
    }
    for name, shape in shapes.items():
        properties = ProximityProperties()
        if name == 'solid':
            properties.AddProperty('mesh', 'solid', True)
        body = GeometryInstance(RigidTransform(), shape, name)
        body.set_proximity_properties(properties)
        scene_graph.RegisterAnchoredGeometry(source, body)
    scene_graph.CreateDefaultContext()


def _two_balls() -> PackedScene:
    """Return a scene of two balls, each on its own frame."""
    scene_graph, ids = SceneGraph(), []
    source = scene_graph.RegisterSource('balls')
    for name in 'ab':
        frame = scene_graph.RegisterFrame(source, GeometryFrame(name))
        ball = GeometryInstance(RigidTransform(), Sphere(1.0), name)
        ball.set_proximity_properties(ProximityProperties())
        scene_graph.RegisterGeometry(source, frame, ball)
        ids.append(frame.get_value())
    ids_of_both = np.array(ids, dtype=np.int64)
    scene, _ = PackedScene.of(scene_graph.CreateDefaultContext(), ids_of_both)
    return scene


def kernel_cache() -> str:
    """Return the folder of the kernel cache, empty if none is writable."""
    return CACHE_FOLDER


def kernel_state() -> str:
    """Return in words which kernels answer in this process, and why not the fastest."""
    return kernels_in_words()
