"""Paths of joint values: against fine scans, closed forms and themselves, cut and turned round."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from batch.conftest import cell_off_the_floor
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.batch import Joints, PathChecker, check_path, check_paths, evaluate
from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    GeometryError,
    GeometrySet,
    MotionCheck,
    SceneGraph,
)
from drake_geom_ros.scene_files import load_scene

SCAN = 200  # states an edge


@pytest.fixture(scope='module')
def cell():
    """Return the cell, in which the arm's base touches the floor and nobody counts it."""
    return cell_off_the_floor()


def told(check):
    """Return all that a check tells, to be compared to the bit."""
    return (*check.__dict__.values(),)


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(told(one), told(other), strict=True))


def scanned(cell, path):
    """Return times by rows of a path, and the upper ends of the least distances."""
    edges = len(path) - 1
    times = np.arange(edges * SCAN + 1) / SCAN
    states = np.column_stack([np.interp(times, np.arange(len(path)), column) for column in path.T])
    least = evaluate(cell.scene_graph, states=states, joints=cell.joints, want='least')
    rounding = 1e-12  # of interpolating here
    return times, least.distance + least.error_bound + rounding


def paths_of(cell, seed, rows, step):
    """Return a random walk (rows, q) within the limits."""
    rng = np.random.default_rng(seed)
    start = cell.states(1, seed)[0]
    walk = start + np.cumsum(rng.normal(0, step, (rows, cell.joints.count)), axis=0)
    return np.clip(walk, cell.joints.lower.clip(-6), cell.joints.upper.clip(max=6))


def hold(cell, path, check, least):
    """Hold what is told of a path against a fine scan."""
    times, upper = scanned(cell, path)
    near = times[upper <= least]
    if check.outcome == 'clear':
        assert not len(near)
        assert check.lower_bound <= upper.min()
        assert check.lower_bound > least
        assert check.times == (len(path) - 1,) * 2
    else:
        assert not (near < check.last_free).any()
    if check.outcome == 'contact':
        first, last = check.times
        assert last - first <= 1.001e-6
        assert check.time == last
        assert check.distance + check.error_bound <= least
        if len(near):
            assert near[0] >= first


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    rows=st.integers(1, 6),
    step=st.sampled_from([0.0, 1e-3, 0.1, 0.5]),
    least=st.sampled_from([0.0, 0.02]),
)
def test_paths_against_a_fine_scan(cell, seed, rows, step, least):
    path = paths_of(cell, seed, rows, step)
    asked = {'min_distance': least, 'ignore_limits': True, 'threads': 1}
    check = check_path(cell.scene_graph, cell.joints, path, **asked)
    hold(cell, path, check, least)
    back = check_path(cell.scene_graph, cell.joints, path[::-1], **asked)
    if 'unknown' not in (check.outcome, back.outcome):
        assert check.outcome == back.outcome
    middle = 0.5 * (path[:-1] + path[1:])
    finer = np.insert(path, np.arange(1, len(path)), middle, axis=0)
    cut = check_path(cell.scene_graph, cell.joints, finer, **asked)
    if 'unknown' not in (check.outcome, cut.outcome):
        assert check.outcome == cut.outcome
        if check.outcome == 'contact':
            assert abs(0.5 * cut.times[0] - check.times[0]) <= 2e-6


def test_many_paths_are_to_the_bit_those_one_by_one(cell):
    paths = [paths_of(cell, seed, 1 + seed % 5, 0.3) for seed in range(24)]
    alone = [
        check_path(cell.scene_graph, cell.joints, path, threads=1, ignore_limits=True)
        for path in paths
    ]
    for threads in (1, 2, 5):
        each = check_paths(
            cell.scene_graph, cell.joints, paths, threads=threads, ignore_limits=True
        )
        assert all(same(one, other) for one, other in zip(alone, each, strict=True))
    assert {'clear', 'contact'} <= {check.outcome for check in alone}


@pytest.fixture(scope='module')
def pillar(tmp_path_factory):
    """Return a scene of a rod about z, a slide and a leaf that follows it, and a post."""
    folder = tmp_path_factory.mktemp('pillar')
    (folder / 'rod.urdf').write_text(ROD)
    (folder / 'scene.yaml').write_text(SCENE)
    graph = SceneGraph()
    loaded = load_scene(folder / 'scene.yaml', graph)
    return graph, Joints.of(loaded)


ROD = """<robot name="rod">
  <link name="base"/>
  <link name="rod"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry>
  </collision></link>
  <link name="slide"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="leaf"><collision><origin xyz="0 0 0.5"/><geometry><sphere radius="0.05"/></geometry>
  </collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="rod"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="push" type="prismatic"><parent link="base"/><child link="slide"/>
    <origin xyz="0 0 2"/><axis xyz="1 0 0"/><limit lower="-1" upper="5" velocity="1" effort="1"/>
  </joint>
  <joint name="follow" type="prismatic"><parent link="slide"/><child link="leaf"/>
    <axis xyz="0 0 1"/><mimic joint="push" multiplier="2" offset="0.25"/>
    <limit lower="-9" upper="9" velocity="1" effort="1"/></joint>
</robot>
"""
SCENE = """name: pillar
sources: [rod, posts]
robots:
  - {name: rod, urdf: rod.urdf, adjacent_links: kept}
geometries:
  - {name: post, source: posts, pose: {position: [0, 1, 0]}, shape: {type: sphere, radius: 0.1}}
"""


def test_joints_by_closed_forms(pillar):
    graph, joints = pillar
    assert joints.names == ('rod::turn', 'rod::push')
    # Two balls as far as 1 from the axis touch where the chord is 0.2.
    angle = 0.5 * math.pi - 2 * math.asin(0.1)
    whole = check_path(graph, joints, [[0.0, 0.0], [2 * math.pi, 0.0]])
    assert whole.outcome == 'contact'
    assert whole.times[0] <= angle / (2 * math.pi) <= whole.times[1]
    other = check_path(graph, joints, [[math.pi, 0.0], [2 * math.pi, 0.0]])
    assert other.outcome == 'clear'
    rows = check_path(graph, joints, [[math.pi, 0.0], [2 * math.pi, 0.5], [2.5 * math.pi, 0.5]])
    assert rows.outcome == 'contact'
    assert rows.times[0] <= 1 + angle / (0.5 * math.pi) <= rows.times[1]
    # The leaf, 2 q + 0.75 above the slide, comes down to it.
    down = check_path(graph, joints, [[3.0, 1.0], [3.0, -1.0]])
    assert down.outcome == 'contact'
    assert down.times[0] <= (1 + 0.3) / 2 <= down.times[1]


def test_one_row_and_what_is_no_path(pillar):
    graph, joints = pillar
    alone = check_path(graph, joints, [[math.pi, 0.0]])
    assert (alone.outcome, alone.times, alone.time) == ('clear', (0.0, 0.0), 0.0)
    hit = check_path(graph, joints, [[0.5 * math.pi, 0.0]])
    assert (hit.outcome, hit.times) == ('contact', (0.0, 0.0))
    for path, word in (
        (np.zeros((0, 2)), 'at least one row'),
        (np.zeros((3, 3)), r'shape \(3, 3\)'),
        (np.zeros(2), 'shape'),
        ([[0.0, math.nan]], 'row 0: rod::push = nan; joint values must be finite'),
        ([[0.0, 0.0], [0.0, 7.0]], r'row 1: rod::push = 7; it is outside its limits \[-1, 5\]'),
        ([['a', 'b']], 'numbers'),
    ):
        with pytest.raises(ArgumentError, match=word):
            check_path(graph, joints, path)
    with pytest.raises(ArgumentError, match='path 1'):
        check_paths(graph, joints, [[[0.0, 0.0]], [[0.0, math.inf]]])
    with pytest.raises(ArgumentError, match='time_tolerance'):
        check_path(graph, joints, [[0.0, 0.0]], time_tolerance=-1)
    assert check_paths(graph, joints, []) == []


def test_long_paths_share_their_parts_and_their_budget(pillar):
    graph, joints = pillar
    rows = np.linspace([math.pi, 0.0], [2 * math.pi, 0.0], 2001)
    alone = check_path(graph, joints, rows, threads=1)
    assert (alone.outcome, alone.times) == ('clear', (2000.0, 2000.0))
    assert same(alone, check_path(graph, joints, rows, threads=3))
    through = np.linspace([math.pi, 0.0], [3 * math.pi, 0.0], 2001)
    hit = check_path(graph, joints, through, threads=1)
    assert hit.outcome == 'contact'
    assert same(hit, check_path(graph, joints, through, threads=3))
    last = 0.0
    for most in (1, 10, 100, 10**6):
        check = check_path(graph, joints, through, max_evaluations=most)
        assert check.evaluations <= most
        assert check.outcome in ('unknown', 'contact')
        assert check.last_free >= last
        last = check.last_free
    assert check.times == hit.times


def test_contacts_at_the_start_stay_left_out(pillar):
    graph, joints = pillar
    rows = np.linspace([0.5 * math.pi, 0.0], [2.4 * math.pi, 0.0], 1001)
    assert check_path(graph, joints, rows).times == (0.0, 0.0)
    check = check_path(graph, joints, rows, ignore_start_contacts=True)
    assert (check.outcome, check.ignored) == ('clear', 1)
    assert isinstance(check, MotionCheck)


def test_a_checker_is_prepared_once_and_refuses_another_scene(pillar):
    graph, joints = pillar
    checker = PathChecker(graph, joints)
    for path in ([[math.pi, 0.0], [2 * math.pi, 0.0]], [[0.0, 0.0], [2 * math.pi, 0.0]]):
        assert same(checker.check(path), check_path(graph, joints, path))
        assert all(same(checker.check(path), each) for each in checker.check_each([path] * 3))
    with pytest.raises(ArgumentError, match='shape'):
        checker.check([0.0, 0.0])
    context = graph.CreateDefaultContext()
    checker = PathChecker(context, joints)
    everything = GeometrySet(geometry_ids=graph.model_inspector().GetAllGeometryIds()[:2])
    declaration = CollisionFilterDeclaration().ExcludeWithin(everything)
    graph.collision_filter_manager(context).Apply(declaration)
    with pytest.raises(GeometryError, match='changed since'):
        checker.check([[0.0, 0.0]])


def test_edges_alone_leave_out_what_the_path_does(pillar):
    graph, joints = pillar
    rows = np.linspace([0.0, 0.0], [2 * math.pi, 0.0], 41)  # clear at the start, and through
    edges = PathChecker(graph, joints, ignore_start_contacts=True).check_edges(rows)
    touched = [k for k, edge in enumerate(edges) if edge.outcome != 'clear']
    half = 2 * math.asin(0.1) / (2 * math.pi / 40)
    assert touched == list(range(math.floor(10 - half), math.ceil(10 + half)))
    assert [edge.times for edge in edges[:2]] == [(1.0, 1.0), (2.0, 2.0)]


def test_a_million_rows_are_one_path(pillar):
    """The rod turns away from the post in a million steps, and comes to it in the last one."""
    graph, joints = pillar
    count = 1_000_000
    angles = math.pi + 1e-9 * np.arange(count)
    path = np.column_stack((angles, np.zeros(count)))
    check = check_path(graph, joints, path)
    assert check.outcome == 'clear'
    assert check.times == (count - 1.0, count - 1.0)
    # From now on it turns to the post, in one row more.
    touching = np.vstack((path, [[2.5 * math.pi, 0.0]]))
    found = check_path(graph, joints, touching)
    assert found.outcome == 'contact'
    assert count - 1 < found.times[0] <= found.times[1] < count
    assert found.last_free == found.times[0]


MOUNTED = """name: mounted
sources: [posts]
robots:
  - {name: rod, urdf: rod.urdf, adjacent_links: kept}
  - name: top
    urdf: rod.urdf
    adjacent_links: kept
    mounted_on: "rod::rod"
    pose: {position: [2, 0, 0]}
  - name: far
    urdf: rod.urdf
    adjacent_links: kept
    mounted_on: cart
    pose: {position: [0, 0, 1], rpy: [0.3, 0, 0]}
frames: [{name: cart, source: posts, pose: {rpy: [0, 0, 1], position: [0, -4, 0]}}]
geometries:
  - {name: post, source: posts, pose: {position: [0, 3, 0]}, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture(scope='module')
def mounted(tmp_path_factory):
    """A robot on a link of another one, and one on a frame that is turned."""
    folder = tmp_path_factory.mktemp('mounted')
    (folder / 'rod.urdf').write_text(ROD)
    (folder / 'scene.yaml').write_text(MOUNTED)
    graph = SceneGraph()
    loaded = load_scene(folder / 'scene.yaml', graph)
    return Plain(scene_graph=graph, joints=Joints.of(loaded))


def test_what_a_moving_base_carries_comes_along(mounted):
    """The upper robot's rod goes by 3 m on its carrier's, through the post."""
    still = np.zeros(mounted.joints.count)
    turned = still.copy()
    turned[0] = math.pi
    check = check_path(mounted.scene_graph, mounted.joints, [still, turned])
    assert check.outcome == 'contact'
    # Two balls of 0.1, one at 3 on a turning lever of 3, touch where the chord is 0.2.
    assert math.isclose(check.times[1], 0.5 - 2 * math.asin(0.1 / 3.0) / math.pi, abs_tol=1e-5)


@settings(deadline=None, max_examples=80)
@given(seed=st.integers(0, 10**6), step=st.sampled_from([0.1, 0.5, 2.0]))
def test_robots_on_robots_against_a_fine_scan(mounted, seed, step):
    rng = np.random.default_rng(seed)
    path = rng.uniform(-2, 2, (1, mounted.joints.count)) + np.zeros((2, 1))
    path[1] += rng.normal(0, step, mounted.joints.count)
    check = check_path(mounted.scene_graph, mounted.joints, path, ignore_limits=True)
    hold(mounted, path, check, 0.0)
