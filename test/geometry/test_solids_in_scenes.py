"""Solids through the public queries: signs, levels, caches, points, files, what is loaded."""

import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.shape_scenes import ShapeScene
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    Box,
    Convex,
    HalfSpace,
    Mesh,
    MeshData,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import load_scene, save_scene
from truth.bodies import grids

ROOT = Path(__file__).parents[2]
L, RING = Mesh.FromMeshData(surface_of('L')), Mesh.FromMeshData(surface_of('ring'))
CORNERS, CUBE = (np.array(x) for x in grids.surface(grids.CUBE, [np.array([-0.5, 0.5])] * 3))
Scene = partial(ShapeScene, solid=True)


@pytest.mark.parametrize('far', [1e50, 1e60])
def test_a_solid_far_beyond_the_range_of_products_is_taken_as_it_is(far):
    """Its counts and areas are no lengths that could be brought to a metre."""
    cube = Mesh.FromMeshData(MeshData(CORNERS, CUBE))
    for shapes, poses in (((cube, Sphere(0.1)), (0, far)), ((Sphere(0.1), cube), (far, 0))):
        pair = Scene(*shapes).pair(*([x, 0, 0] for x in poses))
        assert pair.distance == pytest.approx(far, rel=1e-14)
        assert pair.error_bound <= 1e-13 * far


def test_a_sphere_within_a_cube_mesh_is_as_deep_as_it_is():
    cube = Mesh.FromMeshData(MeshData(CORNERS, CUBE))
    pair = Scene(cube, Sphere(0.1)).pair([0, 0, 0], [0, 0, 0])
    assert pair.distance == pytest.approx(-0.6, abs=1e-13)
    # The same of a cube with a cavity in a corner far from the ball: no hull tells.
    hollow = np.vstack((CORNERS, 0.05 * CORNERS + 0.4))
    cavity = CUBE[:, ::-1] + 8
    cube = Mesh.FromMeshData(MeshData(hollow, np.vstack((CUBE, cavity))))
    pair = Scene(cube, Sphere(0.1)).pair([0, 0, 0], [0, 0, 0])
    assert pair.distance == pytest.approx(-0.6, abs=1e-13)
    assert pair.error_bound <= 1e-12
    inside = Scene(cube, Sphere(0.01)).pair([0, 0, 0], [0.4, 0.4, 0.4])
    assert inside.distance == pytest.approx(0.015, abs=1e-13)


@pytest.mark.parametrize('other', [Sphere(0.1), Box(0.2, 0.2, 0.2), Mesh.FromMeshData(
    surface_of('U'), 0.1)])  # fmt: skip
@pytest.mark.parametrize('p', [(1.5, 1.5, 0.5), (0.5, 0.5, 1.05), (0.4, 0.4, 0.4), (3, 3, 3)])
def test_all_queries_agree(other, p):
    scene = Scene(L, other)
    query = scene.posed([0, 0, 0], p).query
    (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
    contacts = query.ComputePointPairPenetration()
    assert query.HasCollisions() == (pair.distance < 0.0) == bool(len(contacts))
    for contact in contacts:
        assert contact.depth == -pair.distance
        assert contact.nhat_BA_W == pytest.approx(pair.nhat_BA_W)
    near = query.ComputeSignedDistancePairwiseClosestPoints(0.01)
    assert len(near) == (pair.distance <= 0.01)


@pytest.mark.parametrize('other', [Sphere(0.3), Box(0.4, 0.6, 0.5), HalfSpace(), RING])
@given(seed=st.integers(0, 2**32 - 1), level=st.sampled_from(ACCURACY_LEVELS))
def test_who_looks_for_one_contact_is_told_of_it_and_leaves_nothing_behind(other, seed, level):
    """It may be seen without a depth, which whoever asks for one next still gets."""
    rng = np.random.default_rng(seed)
    asked, other_scene = Scene(L, other), Scene(L, other)
    for _ in range(3):
        X = RigidTransform(RollPitchYaw(rng.uniform(-3.0, 3.0, 3)), rng.uniform(-1.0, 2.5, 3))
        query, fresh = asked.posed([0, 0, 0], X).query, other_scene.posed([0, 0, 0], X).query
        found = query.HasCollisions(accuracy=level)
        pairs = query.ComputePointPairPenetration(accuracy=level)
        assert found == bool(len(pairs))
        assert query.HasCollisions(accuracy=level) == found
        expected = fresh.ComputePointPairPenetration(accuracy=level)
        np.testing.assert_array_equal(pairs.depth, expected.depth)
        np.testing.assert_array_equal(pairs.nhat_BA_W, expected.nhat_BA_W)


def test_overlapping_solids_promise_only_that_their_interval_holds():
    scene = Scene(L, RING)
    query = scene.posed([0, 0, 0], [0.8, 0.9, 0.1]).query
    inside = query.ComputeSignedDistancePairwiseClosestPoints()
    assert inside.distance[0] < 0.0
    assert inside.promised_error_bound[0] == np.inf
    assert not inside.breaks_promise().any()
    turned = RigidTransform(RollPitchYaw(1.0, 0.4, 0.5), [0.3, 0.3, 0.1])
    query = Scene(RING, RING).posed([0, 0, 0], turned).query
    linked = query.ComputeSignedDistancePairwiseClosestPoints()
    assert linked.error_bound[0] > 1e-3  # how deep is not known to the last digits
    assert linked.distance[0] + linked.error_bound[0] < 0.0
    assert linked.promised_error_bound[0] == np.inf
    assert not linked.breaks_promise().any()
    query = scene.posed([0, 0, 0], [9, 0, 0]).query
    apart = query.ComputeSignedDistancePairwiseClosestPoints()
    assert apart.error_bound[0] <= apart.promised_error_bound[0] < 1e-8


def test_levels_contain_the_answer():
    rng = np.random.default_rng(4)
    for other in (Sphere(0.2), Box(0.2, 0.5, 0.3), RING):
        scene = Scene(L, other)
        for _ in range(6):
            pose = RigidTransform(RollPitchYaw(*rng.normal(size=3)), rng.uniform(-1, 4, 3))
            exact = scene.pair([0, 0, 0], pose)
            for level in ('bound', 'fast', 'balanced'):
                rough = scene.pair([0, 0, 0], pose, accuracy=level)
                off = abs(rough.distance - exact.distance)
                assert off <= rough.error_bound + exact.error_bound


def test_a_hull_far_from_its_origin_is_bounded_rightly():
    """Go lies outside: it is no point of the body, and says nothing about the distance."""
    far = Convex.FromMeshData(MeshData(np.add(CORNERS, [5, 0, 0]), CUBE))
    scene = Scene(far, Sphere(0.1))
    for x in (0.0, 1.0, -3.0):
        rough = scene.pair([0, 0, 0], [x, 0, 0], accuracy='bound')
        exact = scene.pair([0, 0, 0], [x, 0, 0])
        assert abs(rough.distance - exact.distance) <= rough.error_bound + exact.error_bound


def test_a_walk_in_small_steps_answers_as_a_fresh_scene():
    scene = Scene(L, Box(0.2, 0.3, 0.4))
    for k in range(40):
        pose = RigidTransform(RollPitchYaw(0.1 * k, 0.2, 0.3), [2.5 - 0.05 * k, 1.4, 0.5])
        query = scene.posed([0, 0, 0], pose).query
        walked = query.ComputeSignedDistancePairwiseClosestPoints(0.5)
        fresh = Scene(L, Box(0.2, 0.3, 0.4)).posed([0, 0, 0], pose).query
        fresh = fresh.ComputeSignedDistancePairwiseClosestPoints(0.5)
        assert len(walked) == len(fresh)
        for one, other in zip(walked, fresh, strict=True):
            slack = 2.0 * max(one.error_bound, other.error_bound)
            assert abs(one.distance - other.distance) <= slack
    again = scene.posed([0, 0, 0], pose).query
    again.ComputeSignedDistancePairwiseClosestPoints(0.5)
    assert again.effects().narrowphase_pairs == 0


def test_points_know_inside_from_outside():
    query = Scene(RING).posed([1, 0, 0]).query
    points = np.array([[2.5, 1.5, 0.5], [1.5, 1.5, 0.5], [1.2, 1.5, 0.5], [2.5, 1.5, 4.0]])
    found = query.ComputeSignedDistanceToPoint(points)
    assert found.distance == pytest.approx([0.5, -0.5, -0.2, np.hypot(0.5, 3.0)], abs=1e-13)
    assert found.grad_W[2] == pytest.approx([-1, 0, 0])
    assert (found.error_bound <= 1e-12).all()
    assert query.effects().pairs_by_method == {'mesh': 4}


def test_a_half_space_sees_the_hull_and_is_exact():
    scene = Scene(L, HalfSpace())
    pair = scene.pair([0, 0, -0.25], [0, 0, 0])
    assert pair.distance == pytest.approx(-0.25, abs=1e-14)


def test_the_property_can_be_changed():
    scene = Scene(L, Sphere(0.1))
    graph, mesh = scene.graph, scene.ids[0]
    poses = [0, 0, 0], [1.2, 1.2, 0.5]
    assert scene.pair(*poses).distance == pytest.approx(0.1)
    as_hull = ProximityProperties()
    as_hull.AddProperty('mesh', 'solid', False)
    graph.AssignRole(scene.context, scene.source, mesh, as_hull, RoleAssign.kReplace)
    assert scene.pair(*poses).distance < 0.0  # the hull closes the notch
    assert graph.model_inspector().GetShape(mesh) == L


def test_a_scene_file_says_what_is_solid():
    data = surface_of('L')
    text = f"""
    frames: [{{name: ball, pose: {{}}}}]
    geometries:
      - name: l
        shape:
          type: mesh
          vertices: {data.vertices.tolist()}
          triangles: {data.triangles.tolist()}
        roles: {{proximity: {{mesh: {{solid: true}}}}}}
      - {{name: ball, frame: ball, pose: {{position: [1.2, 1.2, 0.5]}},
          shape: {{type: sphere, radius: 0.1}}}}
    """
    for _ in range(2):
        graph = SceneGraph()
        loaded = load_scene(text, graph)
        query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
        (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
        assert pair.distance == pytest.approx(0.1)
        text = save_scene(graph, loaded.X_PFs)
        assert 'solid: true' in text


LOADED = """
import sys
import numpy as np
from drake_geom_ros.geometry import *
from drake_geom_ros.math import RigidTransform
graph = SceneGraph()
source = graph.RegisterSource('s')
corners = np.array(list(np.ndindex(2, 2, 2)), float).T
for shape in (Sphere(0.1), Convex(points=corners, label='cube')):
    instance = GeometryInstance(RigidTransform(), shape, str(shape._TYPE))
    instance.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(source, graph.RegisterFrame(source, GeometryFrame(instance.name())),
                           instance)
context = graph.CreateSharedContext(partial=True)
graph.get_query_output_port().Eval(context).FindCollisionCandidates()
print([name for name in sys.modules if 'drake_geom_ros' in name and 'solid' in name])
"""


@pytest.mark.processes
def test_a_scene_without_solids_loads_nothing_of_theirs():
    found = subprocess.run(
        [sys.executable, '-c', LOADED], cwd=ROOT, capture_output=True, text=True, timeout=800,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
    )  # fmt: skip
    assert found.stdout == '[]\n', found.stderr
