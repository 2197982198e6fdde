"""States and paths of a robot that carries a half space over a floor."""

import numpy as np
import pytest

from drake_geom_ros.batch import Checker, Joints, check_path, evaluate
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.scene_files import load_scene

ARM = """
sources: [arm]
robots: [{name: arm, urdf: %s}]
geometries: [{name: floor, source: arm, shape: {type: half_space}}]
"""
URDF = """<robot name="arm"><link name="base"/><link name="lift"/>
<link name="plate"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="up" type="prismatic"><parent link="base"/><child link="lift"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
<joint name="tilt" type="revolute"><parent link="lift"/><child link="plate"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


class Press:
    """A plate over a floor, turned downwards where ``tilt`` is 0, at the height ``up``."""

    def __init__(self, folder, overturned=True):
        (folder / 'arm.urdf').write_text(URDF)
        (folder / 'arm.yaml').write_text(ARM % 'arm.urdf')
        self.scene = SceneGraph()
        loaded = load_scene(folder / 'arm.yaml', self.scene)
        self.joints = Joints.of(loaded)
        inspector = self.scene.model_inspector()
        frames = [f for f in inspector.GetAllFrameIds() if inspector.GetName(f) == 'plate']
        R = RotationMatrix(np.diag([1.0, -1.0, -1.0] if overturned else [1.0, 1.0, 1.0]))
        body = GeometryInstance(RigidTransform(R, [0, 0, 0.06]), HalfSpace(), 'press')
        body.set_proximity_properties(ProximityProperties())
        source = inspector.GetAllSourceIds()[-1]
        self.press = self.scene.RegisterGeometry(source, frames[0], body)

    def query(self, q):
        context = self.scene.CreateDefaultContext()
        (poses,) = self.joints.poses(np.array([q]))
        context.UpdateFramePoses(FramePoseVector.FromArrays(self.joints.frame_ids, poses))
        return self.scene.get_query_output_port().Eval(context)


@pytest.fixture(scope='module')
def press(tmp_path_factory):
    return Press(tmp_path_factory.mktemp('press'))


def states(press):
    rng = np.random.default_rng(1)
    found = np.zeros((40, press.joints.count))
    names = list(press.joints.names)
    found[:, names.index('arm::up')] = rng.uniform(-0.2, 0.6, 40)
    found[::4, names.index('arm::tilt')] = rng.choice([1e-9, -1.0, 2.0], 10)
    return found


@pytest.mark.parametrize('margin', [0.0, 0.2])
def test_checkers_batches_and_contexts_agree(press, margin):
    rows = states(press)
    checker = Checker(press.scene, press.joints, margin)
    free = checker.free_each(rows)
    collides = evaluate(
        press.scene, want='collision', states=rows, joints=press.joints, max_distance=margin
    )
    assert (free == ~collides).all()
    assert 0 < np.count_nonzero(free) < len(free)
    for q, is_free in zip(rows, free, strict=True):
        query = press.query(q)
        lower = query.half_space_gaps().lower
        others = query.ComputeSignedDistancePairwiseClosestPoints()
        least = min(lower.min(), (others.distance - others.error_bound).min())
        assert checker.free(q) == is_free == (least > margin)
        assert checker.clearance(q) == pytest.approx(least, abs=1e-12)
        assert (checker.reason(q) == '') == is_free
        if margin == 0.0:
            assert query.HasCollisions() == (not is_free)
        if least == -np.inf:
            near = checker.nearest(q)
            assert near.id_A < near.id_B
            assert press.press in (near.id_A, near.id_B)
            assert 'are half spaces that overlap' in checker.reason(q)


def nearest_by_hand(query):
    """Return the lower ends [m] of all pairs, those of half spaces among them, in order."""
    others = query.ComputeSignedDistancePairwiseClosestPoints()
    lower = [query.half_space_gaps().lower, others.distance - others.error_bound]
    return np.sort(np.concatenate(lower))


@pytest.mark.parametrize('max_distance', [np.inf, 0.1])
def test_least_and_nearest_count_pairs_of_half_spaces_as_checkers_do(press, max_distance):
    """Those that cross are minus infinity apart, whatever else is near."""
    rows = states(press)
    checker = Checker(press.scene, press.joints)
    asked = {'states': rows, 'joints': press.joints, 'max_distance': max_distance}
    least = evaluate(press.scene, want='least', **asked)
    nearest = evaluate(press.scene, want='nearest', count=2, **asked)
    crossing = 0
    for k, q in enumerate(rows):
        lower = nearest_by_hand(press.query(q))
        lower = lower[lower <= max_distance][:2]
        of_state = slice(nearest.offsets[k], nearest.offsets[k + 1])
        found = nearest.distance[of_state] - nearest.error_bound[of_state]
        assert found == pytest.approx(lower, abs=1e-12)
        if not len(lower):
            assert least.distance[k] == np.inf
            continue
        assert least.distance[k] - least.error_bound[k] == pytest.approx(lower[0], abs=1e-12)
        assert checker.clearance(q) == pytest.approx(lower[0], abs=1e-12)
        near = checker.nearest(q)
        assert (least.id_A[k], least.id_B[k]) == (near.id_A.get_value(), near.id_B.get_value())
        crossing += lower[0] == -np.inf
    assert 5 <= crossing < len(rows)


def test_opposed_planes_have_witness_points_on_both_and_crossing_ones_nothing(press):
    q = np.zeros((2, press.joints.count))
    q[0, list(press.joints.names).index('arm::up')] = 0.5
    q[1, list(press.joints.names).index('arm::tilt')] = -1.0
    found = evaluate(
        press.scene, want='nearest', count=9, states=q, joints=press.joints, by_joints=True
    )
    value = press.press.get_value()
    opposed, crossing = np.flatnonzero((found.id_A == value) | (found.id_B == value))[[0, -1]]
    assert opposed < found.offsets[1] <= crossing
    assert found.distance[opposed] == pytest.approx(0.56)
    assert abs(found.nhat_BA_W[opposed, 2]) == 1.0
    span = found.p_WCa[opposed] - found.p_WCb[opposed]
    assert span == pytest.approx(found.distance[opposed] * found.nhat_BA_W[opposed])
    assert sorted([found.p_WCa[opposed, 2], found.p_WCb[opposed, 2]]) == pytest.approx([0, 0.56])
    assert found.distance[crossing] == -np.inf
    assert not found.nhat_BA_W[crossing].any()
    assert not found.gradient[crossing].any()
    assert np.isfinite(found.joint_gradient).all()


def test_a_pair_of_half_spaces_alone_is_something_that_could_collide(tmp_path):
    press = Press(tmp_path)
    inspector = press.scene.model_inspector()
    source = inspector.GetAllSourceIds()[-1]
    (ball,) = [
        g
        for g in inspector.GetAllGeometryIds()
        if not isinstance(inspector.GetShape(g), HalfSpace)
    ]
    press.scene.RemoveGeometry(source, ball)
    checker = Checker(press.scene, press.joints)
    high, tilted = _values(press, 0.5), _values(press, 0.5, 0.1)
    assert checker.free(high)
    assert not checker.free(tilted)
    assert checker.clearance(high) == pytest.approx(0.56)
    assert check_path(press.scene, press.joints, [high]).outcome == 'clear'


def _values(press, up, tilt=0.0):
    return [{'arm::up': up, 'arm::tilt': tilt}[name] for name in press.joints.names]


def test_paths_are_clear_only_where_nothing_moves(press):
    high, low, tilted = _values(press, 0.5), _values(press, 0.4), _values(press, 0.5, 0.1)
    inside = _values(press, -0.2)

    def outcomes(*path, **asked):
        found = check_path(press.scene, press.joints, path, **asked)
        return found.outcome, found.times

    assert outcomes(high) == ('clear', (0.0, 0.0))
    assert outcomes(high, high, high) == ('clear', (2.0, 2.0))
    assert outcomes(high, low) == ('unknown', (0.0, 1.0))
    assert outcomes(high, tilted)[0] == 'unknown'
    assert outcomes(tilted, high) == ('contact', (0.0, 0.0))
    assert outcomes(inside) == ('contact', (0.0, 0.0))
    assert outcomes(high, high, min_distance=0.6) == ('contact', (0.0, 0.0))
    assert outcomes(tilted, high, ignore_start_contacts=True) == ('clear', (1.0, 1.0))
    assert outcomes(high, tilted, ignore_start_contacts=True)[0] == 'unknown'
    found = check_path(press.scene, press.joints, [high, low])
    assert press.press in (found.id_A, found.id_B)
    assert found.distance == pytest.approx(0.56)


def test_edges_are_told_each_by_itself(press):
    high, low, tilted = _values(press, 0.5), _values(press, 0.4), _values(press, 0.5, 0.1)
    checker = PathChecker(press.scene, press.joints)
    found = checker.check_edges([high, high, low, tilted, tilted])
    assert [each.outcome for each in found] == ['clear', 'unknown', 'unknown', 'contact']
    assert [each.times[0] for each in found] == [1.0, 1.0, 2.0, 3.0]
    path = [low, *[high] * 100]
    checks = [
        checker.check(path),
        checker.check_each([path], 2)[0],
        checker.check_each([path], 1)[0],
    ]
    assert {(each.outcome, each.times[0]) for each in checks} == {('unknown', 0.0)}
    checks = [checker.check([*path[1:], tilted]), checker.check_each([[*path[1:], tilted]], 2)[0]]
    assert {each.outcome for each in checks} == {'unknown'}


def test_gaps_of_half_spaces_have_gradients(press):
    checker = Checker(press.scene, press.joints)
    up, tilt = 0.5, 0.0
    every = checker.distances_and_gradients([up, tilt])
    (k,) = [k for k, names in enumerate(checker.pair_names) if 'press' in names[0] + names[1]]
    assert k == len(checker.pairs) - 1
    assert every.distance[k] == pytest.approx(up + 0.06)
    np.testing.assert_allclose(every.gradient[k], [1.0, 0.0], rtol=0, atol=1e-12)
    assert not every.is_gradient_unique[k]  # the slightest turn makes them cross
    ids = checker.pairs[[k]]
    np.testing.assert_array_equal(
        checker.distances_and_gradients([up, tilt], pairs=ids).gradient, every.gradient[[k]]
    )
    crossing = checker.distances_and_gradients([[up, tilt], [up, 0.1]], pairs=ids)
    assert crossing.distance[:, 0].tolist() == [every.distance[k], -np.inf]
    assert not crossing.gradient[1].any()
    for q in ([up, tilt], [up, 0.1], [-0.5, 0.0]):
        clearance, gradient = checker.clearance_and_gradient(q)
        assert clearance == checker.clearance(q)
        least = checker.distances_and_gradients(q)
        np.testing.assert_array_equal(gradient, least.gradient[np.argmin(least.lower_bound)])
