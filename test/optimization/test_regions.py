"""Free balls, boxes and regions: no sampled state in them collides; rates hold for all states."""

import math

import numpy as np
import pytest
from batch.conftest import Cell
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import ArgumentError, GeometryError, SceneGraph
from drake_geom_ros.optimization import (
    HPolyhedron,
    certified_free_ball,
    certified_free_box,
    free_region,
)
from drake_geom_ros.scene_files import load_scene

SLIDER = """<robot name="arm"><link name="base"/>
<link name="cart"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="along" type="prismatic"><parent link="base"/><child link="cart"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
TURNER = SLIDER.replace('prismatic', 'revolute').replace('"1 0 0"', '"0 0 1"')
TURNER = TURNER.replace('<collision>', '<collision><origin xyz="0.6 0 0"/>')
WALL = """
sources: [arm, things]
robots: [{name: arm, urdf: arm.urdf}]
geometries:
  - {name: wall, source: things, pose: {position: [0.9, 0, 0]},
     shape: {type: box, size: [0.2, 1, 1]}}
"""


@pytest.fixture(scope='module')
def standing():
    """Return the cell of ``test/batch`` without the floor, on which the arm stands."""
    graph, cell = SceneGraph(), Cell()
    lines = Cell.path.read_text().replace('arm.urdf', str(Cell.path.with_name('arm.urdf')))
    text = '\n'.join(line for line in lines.splitlines() if 'name: floor' not in line)
    cell.joints = Joints.of(load_scene(text, graph))
    cell.checker = Checker(graph, cell.joints)
    return cell


@given(seed=st.integers(0, 2**31), size=st.sampled_from([1e-3, 0.1, 1.0]))
def test_no_distance_changes_faster_than_its_rates(standing, seed, size):
    first, second = standing.states(2, seed)
    second = first + size * (second - first)
    distances = standing.checker.distances_and_gradients(np.array([first, second]))
    low, high = distances.lower_bound, distances.distance + distances.error_bound
    most = standing.checker.distance_rates @ np.abs(second - first)
    assert (low[0] - high[1] <= most).all()
    assert (low[1] - high[0] <= most).all()
    gradients = np.abs(distances.gradient[0])
    assert (gradients <= standing.checker.distance_rates + 1e-12).all()


def test_rates_are_those_of_the_geometry(tmp_path):
    for urdf, rate in ((SLIDER, 1.0), (TURNER, 0.7)):
        checker = wall_checker(tmp_path, urdf)
        np.testing.assert_allclose(checker.distance_rates, [[rate]], rtol=1e-12)


def wall_checker(folder, urdf, text=WALL, **options):
    (folder / 'arm.urdf').write_text(urdf)
    (folder / 'wall.yaml').write_text(text)
    graph = SceneGraph()
    return Checker(graph, Joints.of(load_scene(folder / 'wall.yaml', graph)), **options)


def test_a_slider_is_free_up_to_the_wall(tmp_path):
    checker = wall_checker(tmp_path, SLIDER, margin=0.1)
    assert certified_free_ball(checker, [0.0]) == pytest.approx(0.6, rel=1e-9)
    assert certified_free_ball(checker, [0.0], margin=0.0) == pytest.approx(0.7, rel=1e-9)
    assert certified_free_ball(checker, [0.7]) == 0.0
    lower, upper = certified_free_box(checker, [0.3])
    np.testing.assert_allclose([lower[0], upper[0]], [0.0, 0.6], rtol=0, atol=1e-9)
    region = free_region(checker, [0.3])
    assert region.certificate == 'certified'
    assert region.polytope.PointInSet([0.5])
    assert not region.polytope.PointInSet([0.61])
    with pytest.raises(GeometryError, match='no free box is proved'):
        certified_free_box(checker, [0.7])


@pytest.mark.parametrize('seed', range(6))
def test_no_state_in_a_ball_or_a_box_collides(standing, seed):
    checker, joints, rng = standing.checker, standing.joints, np.random.default_rng(seed)
    q = next(q for q in standing.states(200, seed) if checker.clearance(q) > 0.02)
    radius = certified_free_ball(checker, q)
    assert radius > 0.0
    steps = rng.normal(size=(2000, len(q)))
    steps *= radius / np.linalg.norm(steps, axis=1)[:, None]
    states = np.clip(q + steps, joints.lower, joints.upper)
    assert checker.free_each(states).all()
    lower, upper = certified_free_box(checker, q)
    assert (lower >= joints.lower).all()
    assert (upper <= joints.upper).all()
    assert (lower <= q).all()
    assert (q <= upper).all()
    corners = np.where(rng.random((2000, len(q))) < 0.5, lower, upper)
    assert checker.free_each(corners).all()
    assert checker.free_each(rng.uniform(lower, upper, (2000, len(q)))).all()


def test_states_that_are_none_are_refused(standing):
    checker = standing.checker
    beyond = np.zeros(4)
    k = int(np.flatnonzero(np.isfinite(checker.joints.upper))[0])
    beyond[k] = checker.joints.upper[k] + 0.1
    for call in (certified_free_ball, certified_free_box):
        for q, words in ((np.zeros((2, 4)), r'\(2, 4\)'), (beyond, 'outside its limits')):
            with pytest.raises(ArgumentError, match=words):
                call(checker, q)
        with pytest.raises(ArgumentError, match='margin=-1'):
            call(checker, np.zeros(4), margin=-1.0)


def test_a_turning_half_space_proves_nothing(tmp_path):
    from batch.test_half_spaces_on_joints import Press

    press = Press(tmp_path)
    checker = Checker(press.scene, press.joints)
    assert checker.clearance([0.5, 0.0]) > 0.0
    assert certified_free_ball(checker, [0.5, 0.0]) == 0.0
    with pytest.raises(GeometryError, match='no free box is proved'):
        certified_free_box(checker, [0.5, 0.0])


@pytest.mark.parametrize('seed', [0, 1])
def test_a_probable_region_holds_few_collisions(standing, seed):
    checker = standing.checker
    q = next(q for q in standing.states(200, seed) if checker.clearance(q) > 0.05)
    lower, upper = checker.joints.lower.clip(-3), checker.joints.upper.clip(max=3)
    how = {'collision_fraction': 0.02, 'confidence': 0.999, 'seed': seed}
    how['domain'] = HPolyhedron.MakeBox(lower, upper)
    region = free_region(checker, q, 'probabilistic', **how)
    assert (region.certificate, region.collision_fraction) == ('probabilistic', 0.02)
    assert region.polytope.PointInSet(q)
    rng = np.random.default_rng(99)
    states = rng.uniform(lower, upper, (40_000, 4))
    inside = states[(states @ region.polytope.A().T <= region.polytope.b()).all(axis=1)]
    assert len(inside) > 100
    # Beyond four standard deviations of a fraction that is allowed.
    most = 0.02 + 4.0 * math.sqrt(0.02 / len(inside))
    assert 1.0 - checker.free_each(inside).mean() < most
    again = free_region(checker, q, 'probabilistic', **how)
    np.testing.assert_array_equal(again.polytope.A(), region.polytope.A())


def test_regions_refuse_what_they_cannot_promise(standing):
    checker = standing.checker
    free = next(q for q in standing.states(200) if checker.clearance(q) > 0.05)
    hit = next(q for q in standing.states(200) if checker.clearance(q) < 0.0)
    for how, words in (
        ({'certificate': 'sure'}, "certificate='sure'"),
        ({'collision_fraction': 0.0}, 'collision_fraction=0.0'),
        ({'confidence': 1.0}, 'confidence=1.0'),
    ):
        with pytest.raises(ArgumentError, match=words):
            free_region(checker, free, **{'certificate': 'probabilistic', **how})
    box = HPolyhedron.MakeBox(np.full(4, -3.0), np.full(4, 3.0))
    with pytest.raises(GeometryError, match='not free'):
        free_region(checker, hit, 'probabilistic', domain=box)
    with pytest.raises(GeometryError, match='after 1 rounds'):
        free_region(checker, free, 'probabilistic', domain=box, most_rounds=1)
    for domain, words in (
        (None, 'arm::turn have no limits'),
        (HPolyhedron.MakeBox([0.0], [1.0]), 'of 4 dimensions'),
        (HPolyhedron.MakeBox(free + 0.1, free + 0.2), 'does not hold the state'),
    ):
        with pytest.raises(ArgumentError, match=words):
            free_region(checker, free, 'probabilistic', domain=domain)


def test_samples_of_a_polyhedron_are_in_it_and_spread_evenly():
    triangle = HPolyhedron([[-1, 0], [0, -1], [1, 1]], [0, 0, 1])
    samples = triangle.UniformSamples(np.random.default_rng(0), [0.1, 0.1], 4000)
    assert all(triangle.PointInSet(x, 1e-12) for x in samples)
    np.testing.assert_allclose(samples.mean(axis=0), [1 / 3, 1 / 3], rtol=0, atol=0.02)
    expected = [[1 / 18, -1 / 36], [-1 / 36, 1 / 18]]
    np.testing.assert_allclose(np.cov(samples.T), expected, rtol=0, atol=6e-3)
    both = triangle.Intersection(HPolyhedron.MakeBox([0, 0], [0.5, 0.5]))
    assert both.ambient_dimension() == 2
    assert both.PointInSet([0.4, 0.4])
    assert not both.PointInSet([0.6, 0.1])


@pytest.mark.parametrize(
    ('call', 'words'),
    [
        (lambda: HPolyhedron([[1.0]], [1.0, 2.0]), r'\(2,\)'),
        (lambda: HPolyhedron([[math.inf]], [1.0]), 'finite'),
        (lambda: HPolyhedron.MakeBox([1.0], [0.0]), 'at most'),
        (lambda: HPolyhedron([[1.0]], [1.0]).UniformSamples(None, [2.0], 1), 'not in the set'),
        (
            lambda: HPolyhedron([[1.0]], [1.0]).UniformSamples(np.random.default_rng(0), [0.0], 1),
            'no limit',
        ),
    ],
)
def test_sets_that_are_none_are_refused(call, words):
    with pytest.raises(ArgumentError, match=words):
        call()
