"""Padded geometries: larger all around by a length, as spheres of larger radii are."""

import math

import numpy as np
import pytest

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    Mesh,
    MeshData,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw

PAD_A, PAD_B = 0.07, 0.02
TETRA = MeshData(
    np.vstack((np.zeros(3), 0.4 * np.eye(3))), [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
)
SHAPES = {
    'sphere': Sphere(0.2),
    'capsule': Capsule(0.1, 0.4),
    'box': Box(0.3, 0.4, 0.5),
    'cylinder': Cylinder(0.2, 0.4),
    'ellipsoid': Ellipsoid(0.2, 0.3, 0.1),
    'convex': Convex.FromMeshData(TETRA),
}


def grown(shape, by):
    """Return what a sphere or a capsule is with the padding in its radius."""
    if isinstance(shape, Sphere):
        return Sphere(shape.radius() + by)
    return Capsule(shape.radius() + by, shape.length())


class Scene:
    def __init__(self, *bodies):
        """``bodies``: shape, padding."""
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('s')
        self.frames, self.ids = [], []
        for k, (shape, padding, *more) in enumerate(bodies):
            self.frames.append(self.graph.RegisterFrame(source, GeometryFrame(f'f{k}')))
            instance = GeometryInstance(RigidTransform([0.02, 0, 0]), shape, 'body')
            properties = ProximityProperties()
            if padding:
                properties.AddProperty('proximity', 'padding', padding)
            for key in more:
                properties.AddProperty(*key, True)
            instance.set_proximity_properties(properties)
            self.ids.append(self.graph.RegisterGeometry(source, self.frames[-1], instance))

    def query(self, *X_WFs):
        context = self.graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector(dict(zip(self.frames, X_WFs, strict=True))))
        return self.graph.get_query_output_port().Eval(context)


def placed(seed, scale):
    rng = np.random.default_rng(seed)
    turn = RollPitchYaw(*rng.uniform(-3, 3, 3))
    return RigidTransform(), RigidTransform(turn, scale * rng.normal(size=3))


@pytest.mark.parametrize('name', ['sphere', 'capsule'])
@pytest.mark.parametrize('other', SHAPES)
@pytest.mark.parametrize('scale', [0.15, 0.5])
def test_distances_are_those_of_larger_radii(name, other, scale):
    a, b = SHAPES[name], SHAPES[other]
    padded = Scene((a, PAD_A), (b, 0.0))
    larger = Scene((grown(a, PAD_A), 0.0), (b, 0.0))
    for seed in range(5):
        X = placed(seed, scale)
        mine, (truth,) = (
            padded.query(*X),
            larger.query(*X).ComputeSignedDistancePairwiseClosestPoints(),
        )
        (found,) = mine.ComputeSignedDistancePairwiseClosestPoints()
        slack = found.error_bound + truth.error_bound
        assert abs(found.distance - truth.distance) <= slack
        if truth.is_nhat_BA_W_unique:
            np.testing.assert_allclose(found.nhat_BA_W, truth.nhat_BA_W, rtol=0, atol=1e-6)
        p_WCa = mine.X_WG(padded.ids[0]) @ found.p_ACa
        p_WCb = mine.X_WG(padded.ids[1]) @ found.p_BCb
        assert np.dot(p_WCa - p_WCb, found.nhat_BA_W) == pytest.approx(found.distance, abs=1e-9)
        assert mine.HasCollisions() == (truth.distance < 0)
        hits = mine.ComputePointPairPenetration()
        assert [hit.depth for hit in hits] == ([-found.distance] if truth.distance < 0 else [])
        (alone,) = mine.signed_distance_of_pair(*padded.ids)
        assert alone.distance == pytest.approx(found.distance, abs=1e-9)
        if truth.distance < 0:
            assert mine.FindCollisionCandidates() == [tuple(padded.ids)]


@pytest.mark.parametrize('name', SHAPES)
@pytest.mark.parametrize('other', SHAPES)
def test_both_paddings_count_and_bounds_hold(name, other):
    """The support function of a padded body is that of the body, plus the radius."""
    scene = Scene((SHAPES[name], PAD_A), (SHAPES[other], PAD_B))
    plain = Scene((SHAPES[name], 0.0), (SHAPES[other], 0.0))
    for seed in range(3):
        X = placed(seed, 0.4)
        (found,) = scene.query(*X).ComputeSignedDistancePairwiseClosestPoints()
        (bare,) = plain.query(*X).ComputeSignedDistancePairwiseClosestPoints()
        slack = found.error_bound + bare.error_bound
        assert abs(found.distance - (bare.distance - PAD_A - PAD_B)) <= slack
        for accuracy in ('bound', 'fast'):
            (rough,) = scene.query(*X).ComputeSignedDistancePairwiseClosestPoints(
                accuracy=accuracy
            )
            assert abs(rough.distance - found.distance) <= rough.error_bound + found.error_bound


def test_a_half_space_is_padded_too():
    scene = Scene((HalfSpace(), PAD_A), (Sphere(0.1), PAD_B))
    (found,) = scene.query(
        RigidTransform(), RigidTransform([0, 0, 0.5])
    ).ComputeSignedDistancePairwiseClosestPoints()
    assert found.distance == pytest.approx(0.4 - PAD_A - PAD_B)


def test_limits_are_of_the_padded_distances():
    scene = Scene((Sphere(0.1), PAD_A), (Sphere(0.1), PAD_B))
    query = scene.query(RigidTransform(), RigidTransform([1.0, 0, 0]))
    near = 0.8 - PAD_A - PAD_B
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(near + 1e-9)) == 1
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(near - 1e-9)) == 0
    touching = scene.query(RigidTransform(), RigidTransform([0.2 + PAD_A + PAD_B, 0, 0]))
    assert not touching.HasCollisions()


@pytest.mark.parametrize('accuracy', ['bound', 'fast', 'exact'])
def test_lists_have_all_that_may_be_within_by_the_lower_bound(accuracy):
    """A limit between the lower bound and the distance leaves no pair out, here as in states."""
    scene = Scene((SHAPES['cylinder'], PAD_A), (SHAPES['ellipsoid'], PAD_B))
    X = placed(1, 0.6)
    query = scene.query(*X)
    (found,) = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)
    assert found.error_bound > 0.0
    lower = found.distance - found.error_bound
    ask = {'frame_ids': scene.frames, 'want': 'within', 'accuracy': accuracy}
    poses = np.array([[[*x.translation(), *x.rotation().ToQuaternion().wxyz()] for x in X]])
    poses[..., 3:] = np.roll(poses[..., 3:], -1, axis=-1)
    for limit, count in ((lower + 0.5 * found.error_bound, 1), (lower - 1e-9, 0)):
        listed = query.ComputeSignedDistancePairwiseClosestPoints(limit, accuracy=accuracy)
        assert len(listed) == count
        assert len(evaluate(scene.graph, poses=poses, max_distance=limit, **ask).distance) == count


@pytest.mark.parametrize('name', SHAPES)
def test_points_are_nearer_by_the_padding(name):
    scene = Scene((SHAPES[name], PAD_A))
    plain = Scene((SHAPES[name], 0.0))
    X = placed(3, 0.1)[1:]
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (40, 3))
    query = scene.query(*X)
    found = query.ComputeSignedDistanceToPoint(points)
    bare = plain.query(*X).ComputeSignedDistanceToPoint(points)
    np.testing.assert_allclose(found.distance, bare.distance - PAD_A, rtol=0, atol=1e-12)
    nearest = np.array([query.X_WG(scene.ids[0]) @ p for p in found.p_GN])
    steps = points[found.point_index] - nearest
    np.testing.assert_allclose(
        (steps * found.grad_W).sum(axis=1), found.distance, rtol=0, atol=1e-9
    )
    limited = query.ComputeSignedDistanceToPoint(points, 0.1)
    assert len(limited) == (found.distance <= 0.1).sum()


def u_shape():
    """Return a mesh that is not convex: two posts on a bar, as triangles from boxes."""
    import trimesh

    parts = [trimesh.creation.box((1, 0.2, 0.2))]
    parts += [
        trimesh.creation.box(
            (0.2, 0.2, 1), trimesh.transformations.translation_matrix((x, 0, 0.5))
        )
        for x in (-0.4, 0.4)
    ]
    mesh = trimesh.boolean.union(parts)
    return Mesh.FromMeshData(MeshData(mesh.vertices, mesh.faces))


def test_between_walls_a_padded_ball_has_bounds_that_hold_the_truth():
    """Out of a slot of 0.6 that is too narrow by its padding the way is up, and longer."""
    solid = [('mesh', 'solid')]
    for radius, padding in ((0.25, 0.1), (0.2, 0.05)):
        scene = Scene((u_shape(), 0.0, *solid), (Sphere(radius), padding))
        X_WB = RigidTransform([0.0, 0, 0.6])
        query = scene.query(RigidTransform(), X_WB)
        (found,) = query.ComputeSignedDistancePairwiseClosestPoints()
        if radius + padding < 0.3 - 0.02:
            assert found.distance > 0.0
            assert found.error_bound < 1e-6
            assert not query.HasCollisions()
            continue
        larger = Scene((u_shape(), 0.0, *solid), (Sphere(radius + padding), 0.0))
        (truth,) = larger.query(
            RigidTransform(), X_WB
        ).ComputeSignedDistancePairwiseClosestPoints()
        low, high = truth.distance - truth.error_bound, truth.distance + truth.error_bound
        assert found.distance - found.error_bound <= low
        assert high <= found.distance + found.error_bound
        assert query.HasCollisions()
        assert len(query.ComputePointPairPenetration()) == 1


def test_gradients_are_those_without_padding_and_witness_derivatives_are_refused():
    bodies = (SHAPES['box'], SHAPES['cylinder'])
    X = placed(2, 0.5)
    found = Scene(*zip(bodies, (PAD_A, PAD_B), strict=True)).query(*X)
    bare = Scene(*zip(bodies, (0.0, 0.0), strict=True)).query(*X)
    mine = found.ComputeSignedDistancePairwiseClosestPoints()
    theirs = bare.ComputeSignedDistancePairwiseClosestPoints()
    np.testing.assert_allclose(mine.gradients, theirs.gradients, rtol=0, atol=1e-9)
    assert mine.is_gradient_unique.tolist() == theirs.is_gradient_unique.tolist()
    assert mine.is_padded
    assert mine.without_padding().distance == pytest.approx(theirs.distance)


def test_states_are_answered_as_a_query_object_does():
    names = list(SHAPES)
    scene = Scene(*((SHAPES[name], 0.03 * k) for k, name in enumerate(names)))
    rng = np.random.default_rng(0)
    poses = np.zeros((6, len(names), 7))
    poses[..., :3] = rng.uniform(-0.8, 0.8, (*poses.shape[:2], 3))
    poses[..., 6] = 1.0
    ask = {'frame_ids': scene.frames, 'poses': poses}
    hits = evaluate(scene.graph, want='collision', **ask)
    near = evaluate(scene.graph, want='collision', max_distance=0.2, **ask)
    least = evaluate(scene.graph, want='least', **ask)
    within = evaluate(scene.graph, want='within', max_distance=0.3, **ask)
    for k, row in enumerate(poses):
        query = scene.query(*(RigidTransform(p[:3]) for p in row))
        found = query.ComputeSignedDistancePairwiseClosestPoints()
        assert hits[k] == query.HasCollisions()
        assert near[k] == (found.distance - found.error_bound <= 0.2).any()
        assert least.distance[k] == pytest.approx(found.distance.min(), abs=1e-9)
        some = within.distance[within.offsets[k] : within.offsets[k + 1]]
        np.testing.assert_allclose(some, found.distance[found.distance <= 0.3], rtol=0, atol=1e-9)
    assert hits.any()
    assert not hits.all()


@pytest.mark.parametrize('padding', [-0.1, math.nan, math.inf, 'a', [1.0]])
def test_what_is_no_length_is_refused(padding):
    with pytest.raises(RuntimeError, match='padding'):
        Scene((Sphere(1.0), padding))
