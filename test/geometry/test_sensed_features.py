"""All that geometries are asked, of sensed maps: the right answer, or an error that says why.

None may look like "free": a ball of 5 cm stands 10 cm in front of the nearest cell, or in it.
"""

import pickle

import numpy as np
import pytest
from geometry.render.scenes import images, scene_of
from oracles.sensed_maps import KINDS, grid
from oracles.shape_scenes import ShapeScene

from drake_geom_ros import batch
from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.geometry import (
    Box,
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    FramePoseVector,
    FramePoseVector_,
    GeometryError,
    GeometryInstance,
    IllustrationProperties,
    OccupiedCells,
    PointCloud,
    ProximityProperties,
    RenderCameraCore,
    Role,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.autodiff.poses import with_derivatives
from drake_geom_ros.geometry.visualizer import _messages
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import load_scene, save_scene
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.scaled_surfaces import parts_of

NEAR, IN = RigidTransform([0.0, 0.0, 0.25]), RigidTransform([0.0, 0.0, 0.12])
# The nearest cell is around the origin: half its edge and its radius are 0.1.
CENTRES = np.vstack((np.zeros((1, 3)), grid(4, 4, 1) - [0.0, 0.0, 2.0]))


def make(kind):
    return kind(0.2 if kind is OccupiedCells else 0.1, CENTRES)


@pytest.fixture(params=KINDS)
def scene(request):
    return ShapeScene(make(request.param), Sphere(0.05))


def at(scene, X_WB):
    return scene.posed(RigidTransform(), X_WB).query


def test_pairs_at_every_level(scene):
    for level in ('bound', 'fast', 'balanced', 'exact'):
        (found,) = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
        assert abs(found.distance - 0.1) <= found.error_bound
        (found,) = at(scene, IN).ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
        assert abs(found.distance + 0.03) <= found.error_bound
        assert scene.query.HasCollisions(accuracy=level)
        assert len(scene.query.ComputePointPairPenetration(accuracy=level)) == 1
    found = at(scene, NEAR)
    assert not found.HasCollisions()
    assert not len(found.ComputePointPairPenetration())
    assert len(found.ComputeSignedDistancePairwiseClosestPoints(0.1 + 1e-9)) == 1
    assert not len(found.ComputeSignedDistancePairwiseClosestPoints(0.1 - 1e-9))


@pytest.mark.parametrize('padding', [0.0, 0.01])
def test_where_nothing_is_near_enough_no_depth_is_computed(scene, padding):
    """As where rules are about stops alone, which need no distance."""
    properties = ProximityProperties()
    properties.AddProperty('proximity', 'padding', padding)
    role = scene.source, scene.ids[0], properties, RoleAssign.kReplace
    scene.graph.AssignRole(scene.context, *role)
    query = at(scene, IN)
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(-0.5)) == 0
    assert query.effects().narrowphase_pairs == 1
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(-np.inf)) == 0
    assert (query.effects().narrowphase_pairs, query.effects().pairs_by_method) == (0, {})
    (found,) = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
    assert abs(found.distance + padding - 0.1) <= found.error_bound


def test_witness_points_lie_on_both_surfaces(scene):
    (found,) = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
    assert found.nhat_BA_W == pytest.approx([0.0, 0.0, -1.0])
    assert found.p_ACa == pytest.approx([0.0, 0.0, 0.1], abs=1e-12)
    assert found.p_BCb == pytest.approx([0.0, 0.0, -0.05], abs=1e-12)


def test_an_answer_is_that_of_a_scene_that_was_asked_nothing_before(scene):
    rng = np.random.default_rng(1)
    for _ in range(20):
        X = RigidTransform(rng.uniform(-0.4, 0.4, 3))
        query, fresh = at(scene, X), scene.graph.CreateDefaultContext()
        if rng.random() < 0.5:
            query.HasCollisions()
        if rng.random() < 0.5:
            query.ComputeSignedDistancePairwiseClosestPoints(0.05, accuracy='fast')
        found = query.ComputeSignedDistancePairwiseClosestPoints()
        scene.pose(fresh, (RigidTransform(), X))
        first = scene.asked(fresh).ComputeSignedDistancePairwiseClosestPoints()
        for name in ('distance', 'error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb', 'method'):
            assert getattr(found, name).tolist() == getattr(first, name).tolist()


def test_points(scene):
    query = at(scene, RigidTransform([9.0, 0, 0]))
    found = query.ComputeSignedDistanceToPoint([[0, 0, 0.3], [0, 0, 0.09], [0, 0, 5.0]], 1.0)
    of_map = found.distance[found.id_G == scene.ids[0].get_value()]
    assert of_map == pytest.approx([0.2, -0.01])
    inside = query.ComputeSignedDistanceToPoint([0, 0, 0.0], 0.0)
    assert inside.distance + inside.error_bound >= -0.1
    assert inside.distance - inside.error_bound <= -0.1


def test_batches(scene):
    poses = np.zeros((2, 1, 7))
    poses[..., 6], poses[:, 0, 2] = 1.0, (0.25, 0.12)
    scene.posed(RigidTransform(), NEAR)
    asked = scene.context, [scene.frames[1]], poses
    assert batch.evaluate(*asked, want='collision').tolist() == [False, True]
    least = batch.evaluate(*asked, want='least')
    assert np.abs(least.distance - [0.1, -0.03]).max() <= 1e-12
    within = batch.evaluate(*asked, want='within', max_distance=0.05)
    assert within.offsets.tolist() == [0, 0, 1]
    for want in ('collision', 'least', 'within'):
        again = batch.evaluate(*asked, want=want, max_distance=1.0, threads=1, block_size=1)
        once = batch.evaluate(*asked, want=want, max_distance=1.0)
        for name in ('distance', 'error_bound') if want != 'collision' else ():
            assert getattr(again, name).tolist() == getattr(once, name).tolist()


def test_motions(scene):
    query = at(scene, NEAR)
    end = FramePoseVector({scene.frames[1]: RigidTransform([0.0, 0.0, -0.9])})
    found = query.CheckMotion(end)
    assert found.outcome == 'contact'
    assert found.times[0] <= 0.1 / 1.15 <= found.times[1]
    aside = FramePoseVector({scene.frames[1]: RigidTransform([1.0, 0.0, 0.25])})
    found = query.CheckMotion(aside)
    assert found.outcome == 'clear'
    assert 0.0 < found.lower_bound <= 0.1


def test_derivatives_of_distances_are_there_and_those_of_points_refused(scene):
    found = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
    assert found.gradients[0, 6:] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-12)
    assert not found.is_gradient_unique[0]
    graph = scene.graph.ToAutoDiffXd()
    context, poses = graph.CreateDefaultContext(), FramePoseVector_[AutoDiffXd]()
    for k, (frame, X) in enumerate(zip(scene.frames, (RigidTransform(), NEAR), strict=True)):
        poses.set_value(frame, with_derivatives(X, np.eye(6, 12, 6 * k), AutoDiffXd))
    graph.get_source_pose_port(scene.source).FixValue(context, poses)
    query = graph.get_query_output_port().Eval(context)
    (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
    np.testing.assert_allclose(pair.distance.derivatives(), found.gradients[0])
    with pytest.raises(GeometryError, match='curvature of a sensed map'):
        _ = pair.nhat_BA_W
    near = query.ComputeSignedDistanceToPoint(np.array([0.0, 0.0, 0.3]), 1.0)[0]
    with pytest.raises(GeometryError, match='curvature of a sensed map'):
        _ = near.grad_W


def test_margins_and_paddings(scene):
    for kind, name in (('map', 'margin'), ('proximity', 'padding')):
        properties = ProximityProperties()
        properties.AddProperty(kind, name, 0.02)
        scene.graph.AssignRole(
            scene.context, scene.source, scene.ids[0], properties, RoleAssign.kReplace
        )
        (found,) = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
        assert found.distance == pytest.approx(0.08)
        (found,) = at(scene, IN).ComputeSignedDistancePairwiseClosestPoints()
        assert abs(found.distance + 0.05) <= found.error_bound
    for wrong in ('wide', -0.1, np.inf, np.nan, True):
        properties = ProximityProperties()
        properties.AddProperty('map', 'margin', wrong)
        with pytest.raises(GeometryError, match=r"\('map', 'margin'\)"):
            scene.graph.AssignRole(scene.source, scene.ids[0], properties, RoleAssign.kReplace)


def test_a_map_takes_the_place_of_another(scene):
    at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
    kind = type(scene.graph.model_inspector().GetShape(scene.ids[0]))
    size = 0.2 if kind is OccupiedCells else 0.1
    scene.graph.ChangeShape(
        scene.context, scene.source, scene.ids[0], kind(size, [[0.0, 0.0, 0.05]])
    )
    (found,) = at(scene, NEAR).ComputeSignedDistancePairwiseClosestPoints()
    assert found.distance == pytest.approx(0.05)


def test_filters_and_copies_know_a_map_as_one_geometry(scene):
    query = at(scene, IN)
    assert len(scene.graph.model_inspector().GetCollisionCandidates()) == 1
    assert len(query.FindCollisionCandidates()) == 1
    other = pickle.loads(pickle.dumps(scene.graph))
    shape = scene.graph.model_inspector().GetShape(scene.ids[0])
    assert other.model_inspector().GetShape(scene.ids[0]) == shape


def test_drawing(scene):
    shape = scene.graph.model_inspector().GetShape(scene.ids[0])
    (part,) = parts_of(shape)
    assert len(part.surface.triangles) >= 8 * len(CENTRES)
    look = IllustrationProperties()
    instance = GeometryInstance(RigidTransform(), shape, 'seen')
    instance.set_illustration_properties(look)
    scene.graph.RegisterAnchoredGeometry(scene.source, instance)
    message, told = _messages.load_message(scene.graph.model_inspector(), Role.kIllustration)
    assert len(message) > 4 * 9 * len(CENTRES)
    assert not told


def seen_of(bodies):
    """Return the depths and the labels (31, 31) of bodies, labelled by their places."""
    core = RenderCameraCore(
        'exact', CameraInfo(31, 31, 0.4), ClippingRange(0.01, 10.0), RigidTransform()
    )
    scene, _ = scene_of(bodies)
    camera = DepthRenderCamera(core, DepthRange(0.1, 5.0))
    seen = images(scene, camera, want=('depth', 'label'))
    return seen.depth.data[..., 0], seen.label.data[..., 0]


@pytest.mark.parametrize('kind', KINDS)
def test_cells_and_balls_are_in_images(kind):
    depth, _ = seen_of([(make(kind), RigidTransform([0.0, 0.0, 1.0]))])
    assert depth[15, 15] == pytest.approx(0.9, abs=1e-3)


def test_images_of_balls_are_those_of_so_many_spheres():
    """One geometry with one label, turned, beside others."""
    rng = np.random.default_rng(0)
    X_WM = RigidTransform(RollPitchYaw(0.3, -0.5, 0.8), [0.1, 0.0, 1.5])
    positions = rng.uniform(-0.4, 0.4, (40, 3))
    box = Box(0.2, 0.2, 0.2), RigidTransform([-0.2, 0.1, 1.4])
    wall = Box(2.0, 2.0, 0.1), RigidTransform([0.0, 0.0, 2.5])
    balls = [(Sphere(0.05), X_WM @ RigidTransform(p)) for p in positions]
    depth, labels = seen_of([box, wall, (PointCloud(0.05, positions), X_WM)])
    expected, of_spheres = seen_of([box, wall, *balls])
    np.testing.assert_allclose(depth, expected, atol=1e-6, rtol=0)
    one, several = np.unique(labels), np.unique(of_spheres)
    assert len(one) == 3
    assert len(several) > 10
    assert (labels == np.minimum(of_spheres, one.max())).all()


def test_a_saved_scene_has_the_map(scene):
    """What a scene file cannot say is refused by name; what it says is the same map."""
    shape = scene.graph.model_inspector().GetShape(scene.ids[0])
    graph = SceneGraph()
    loaded = load_scene(save_scene(scene.graph), graph)
    shapes = [graph.model_inspector().GetShape(id) for id in loaded.geometries.values()]
    assert shape in shapes
