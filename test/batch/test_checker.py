"""The prepared checker: what ``evaluate`` says, one state at a time, and of a scene that is."""

import pickle
import threading

import numpy as np
import pytest
from batch.conftest import Cell

from drake_geom_ros.batch import Checker, Joints, evaluate
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    ArgumentError,
    CollisionFilterDeclaration,
    Convex,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    MeshData,
    PoseError,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
from truth.bodies.random_bodies import random_directions

CHANGED = 'was changed since'


def standing():
    """Return a cell whose arm may stand on the floor, which it touches."""
    found = Cell()
    foot, floor = ('arm', 'base', 'collision_0'), ('things', 'world', 'floor')
    ids = [found.loaded.geometries[name] for name in (foot, floor)]
    declaration = CollisionFilterDeclaration().ExcludeBetween(*(GeometrySet(id) for id in ids))
    found.scene_graph.collision_filter_manager().Apply(declaration)
    return found


@pytest.fixture(scope='module')
def cell():
    return standing()


@pytest.fixture
def own():
    """Return a cell that may be changed."""
    return standing()


def collides(cell, states, margin, accuracy=''):
    asked = {'states': states, 'joints': cell.joints, 'accuracy': accuracy}
    return evaluate(cell.scene_graph, want='collision', max_distance=margin, **asked)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('margin', [0.0, 0.05])
def test_free_is_what_evaluate_says_whatever_was_asked_before(cell, accuracy, margin):
    states = cell.states(300)
    checker = Checker(cell.scene_graph, cell.joints, margin, accuracy=accuracy)
    expected = ~collides(cell, states, margin, accuracy)
    assert accuracy == 'bound' or 0 < expected.sum() < len(expected)
    assert [checker.free(q) for q in states] == expected.tolist()
    assert [checker.free(q) for q in states[::-1]] == expected[::-1].tolist()
    np.testing.assert_array_equal(checker.free_each(states), expected)
    twice = [checker.free(q) and checker.free(q) for q in states.tolist()]
    assert twice == expected.tolist()


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_clearance_is_the_least_lower_bound_of_evaluate(cell, accuracy):
    states = cell.states(100)
    checker = Checker(cell.scene_graph, cell.joints, accuracy=accuracy)
    asked = {'states': states, 'joints': cell.joints, 'accuracy': accuracy}
    least = evaluate(cell.scene_graph, want='least', **asked)
    found = [checker.nearest(q) for q in states]
    for name in ('distance', 'error_bound'):
        np.testing.assert_array_equal([getattr(f, name) for f in found], getattr(least, name))
    assert [f.id_A.get_value() for f in found] == least.id_A.tolist()
    assert [f.id_B.get_value() for f in found] == least.id_B.tolist()
    assert [f.name_a for f in found] == cell.scene_graph.model_inspector().full_names(least.id_A)
    lower = (least.distance - least.error_bound).tolist()
    assert [checker.clearance(q) for q in states] == lower == [f.lower_bound for f in found]


def test_a_state_outside_its_limits_is_not_free_and_it_is_told_which(cell):
    checker = Checker(cell.scene_graph, cell.joints)
    free = next(q for q in cell.states(100) if checker.free(q))
    for joint, limits in enumerate(zip(cell.joints.lower, cell.joints.upper, strict=True)):
        for limit, beyond in zip(limits, (-np.inf, np.inf), strict=True):
            if np.isfinite(limit):
                q = free.copy()
                q[joint] = np.nextafter(limit, beyond)
                assert not checker.free(q)
                assert not checker.free_each(q[None])[0]
                assert f'{cell.joints.names[joint]} = ' in checker.reason(q)
                assert 'outside its limits' in checker.reason(q)
    assert checker.reason(free) == ''
    q = free.copy()
    q[3] = cell.joints.upper[3] + 1e-9
    anyhow = Checker(cell.scene_graph, cell.joints, ignore_limits=True)
    assert anyhow.free(q) == (not collides(cell, q[None], 0.0)[0])
    assert checker.clearance(q) == anyhow.clearance(q)


def test_the_reason_names_the_pair(cell):
    checker = Checker(cell.scene_graph, cell.joints, 0.02)
    for q in cell.states(40):
        near = checker.nearest(q)
        told = f'{near.name_a} and {near.name_b}' in checker.reason(q)
        assert told == (near.lower_bound <= 0.02) == (not checker.free(q))


@pytest.mark.parametrize(
    ('bad', 'words'),
    [
        ([0.0, 0.0, 0.0], r'\(3,\); it must be \(4,\), one value each for arm::turn'),
        ([[0.0, 0.0, 0.0, 0.0]], r'\(1, 4\)'),
        (0.0, r'\(\)'),
        ([0.0, np.nan, 0.0, 0.0], 'arm::bend = nan: joint values must be finite'),
        ([0.0, 0.0, np.inf, -np.inf], 'arm::roll = inf, arm::slide = -inf'),
        (['0', '0', '0', '0'], 'must be numbers'),
        ([0j, 0, 0, 0], 'must be numbers'),
        ([True, False, True, True], 'must be numbers'),
        ([None, 0, 0, 0], 'must be numbers'),
        ([[0.0], [0.0, 1.0]], 'must be numbers'),
    ],
)
def test_what_is_no_state_is_refused(cell, bad, words):
    checker = Checker(cell.scene_graph, cell.joints)
    for ask in (checker.free, checker.clearance, checker.nearest, checker.reason):
        with pytest.raises(ArgumentError, match=words):
            ask(bad)


def test_states_are_refused_by_their_number(cell):
    checker = Checker(cell.scene_graph, cell.joints)
    states = cell.states(2000)
    states[1500, 2] = np.nan
    with pytest.raises(ArgumentError, match=r'state 1500: arm::roll = nan'):
        checker.free_each(states)
    with pytest.raises(ArgumentError, match=r'\(2000, 3\); it must be \(N, 4\)'):
        checker.free_each(states[:, :3])
    assert checker.free_each(np.zeros((0, 4))).shape == (0,)


def test_arrays_of_any_layout_and_type_are_the_same_state(cell):
    checker = Checker(cell.scene_graph, cell.joints)
    states = np.asfortranarray(cell.states(50))
    expected = [checker.free(np.ascontiguousarray(q)) for q in states]
    assert [checker.free(q) for q in states] == expected
    assert [checker.free(tuple(q)) for q in states] == expected
    states.flags.writeable = False
    assert [checker.free(q) for q in states] == expected
    np.testing.assert_array_equal(checker.free_each(states), expected)
    assert checker.free(np.zeros(4, dtype=np.int32)) == checker.free(np.zeros(4))


def add_ball(scene_graph, loaded, on=None):
    ball = GeometryInstance(RigidTransform([0.3, 0.3, 0.3]), Sphere(0.05), 'ball')
    ball.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterAnchoredGeometry(
        *([] if on is None else [on]), loaded.sources['things'], ball
    )


def filter_all(cell, context=None):
    ids = GeometrySet(list(cell.loaded.geometries.values()))
    manager = cell.scene_graph.collision_filter_manager(context)
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(ids))


def first_pose(cell, x):
    poses = FramePoseVector()
    poses.set_value(cell.loaded.frames['things', 'tray'], RigidTransform([x, 0.1, 0.4]))
    return poses


def by_poses(cell, states, want, **arguments):
    """Return what ``evaluate`` says of the poses of the links, without the joints."""
    asked = {'frame_ids': cell.joints.frame_ids, 'poses': cell.joints.poses(states)}
    return evaluate(cell.scene_graph, want=want, **asked, **arguments)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('margin', [np.inf, 0.0, 0.05])
def test_collision_by_joints_is_that_by_poses(cell, accuracy, margin):
    states = cell.states(300)
    expected = by_poses(cell, states, 'collision', max_distance=margin, accuracy=accuracy)
    assert accuracy == 'bound' or 0 < expected.sum() < len(expected)
    np.testing.assert_array_equal(collides(cell, states, margin, accuracy), expected)


def pad(cell, name, padding):
    properties = ProximityProperties()
    if padding:
        properties.AddProperty('proximity', 'padding', padding)
    source, geometry = cell.loaded.sources[name[0]], cell.loaded.geometries[name]
    cell.scene_graph.AssignRole(source, geometry, properties, RoleAssign.kReplace)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('margin', [0.0, 0.05])
@pytest.mark.parametrize('name', [('things', 'world', 'egg'), ('arm', 'base', 'collision_0')])
def test_a_padded_scene_is_answered_as_by_evaluate(own, name, accuracy, margin):
    before, states = Checker(own.scene_graph, own.joints), own.states(200)
    pad(own, name, 0.1)
    with pytest.raises(GeometryError, match=CHANGED):
        before.free(states[0])
    checker = Checker(own.scene_graph, own.joints, margin, accuracy=accuracy)
    asked = {'max_distance': margin, 'accuracy': accuracy}
    expected = by_poses(own, states, 'collision', **asked)
    np.testing.assert_array_equal(checker.free_each(states), ~expected)
    np.testing.assert_array_equal(collides(own, states, margin, accuracy), expected)
    least = by_poses(own, states, 'least', accuracy=accuracy)
    np.testing.assert_array_equal(
        [checker.clearance(q) for q in states], least.distance - least.error_bound
    )
    if name[0] == 'things' and accuracy != 'bound':
        pad(own, name, 0.0)
        plain = Checker(own.scene_graph, own.joints, margin).free_each(states)
        assert (plain & expected).any()


@pytest.mark.parametrize('accuracy', [*ACCURACY_LEVELS, 0.1])
@pytest.mark.parametrize('margin', [0.0, 0.05])
def test_a_padding_makes_no_other_pair_near(own, accuracy, margin):
    """A hull of many vertices, which has a coarse hull, and a padding of another geometry."""
    egg = own.loaded.geometries['things', 'world', 'egg']
    points = 0.2 * random_directions(np.random.default_rng(0), 300)
    hull = Convex.FromMeshData(MeshData(points))
    own.scene_graph.ChangeShape(own.loaded.sources['things'], egg, hull)
    pad(own, ('arm', 'base', 'collision_0'), 0.3)
    states = own.states(200)
    checker = Checker(own.scene_graph, own.joints, margin, accuracy=accuracy)
    expected = by_poses(own, states, 'collision', max_distance=margin, accuracy='exact')
    free = checker.free_each(states)
    assert 0 < expected.sum() < len(expected)
    if accuracy == 'bound':
        assert not (free & expected).any()
    else:
        np.testing.assert_array_equal(free, ~expected)


@pytest.mark.parametrize(
    'change',
    [
        lambda cell: add_ball(cell.scene_graph, cell.loaded),
        lambda cell: filter_all(cell),
        lambda cell: cell.scene_graph.SetFirstPoses(first_pose(cell, 0.0)),
        lambda cell: cell.scene_graph.ChangeShape(
            cell.loaded.sources['things'],
            cell.loaded.geometries['things', 'world', 'egg'],
            Sphere(0.9),
        ),
        lambda cell: cell.scene_graph.RemoveGeometry(
            cell.loaded.sources['things'], cell.loaded.geometries['things', 'world', 'egg']
        ),
    ],
)
def test_once_the_scene_has_changed_nothing_is_answered(own, change):
    checker = Checker(own.scene_graph, own.joints)
    q = own.states(1)[0]
    checker.free(q)
    change(own)
    for ask in (checker.free, checker.clearance, checker.nearest, checker.reason):
        with pytest.raises(GeometryError, match=CHANGED):
            ask(q)
    with pytest.raises(GeometryError, match=CHANGED):
        checker.free_each(q[None])


def test_of_a_context_it_is_the_frames_that_stay_that_must_not_move(own):
    context = own.scene_graph.CreateDefaultContext()
    states = own.states(2)
    arm = FramePoseVector.FromArrays(own.joints.frame_ids, own.joints.poses(states)[0])
    checker = Checker(context, own.joints)
    expected = checker.free(states[1])
    context.UpdateFramePoses(arm)  # what the joints move is no part of it
    own.scene_graph.get_query_output_port().Eval(context).HasCollisions()
    assert checker.free(states[1]) == expected
    context.UpdateFramePoses(first_pose(own, 0.6))  # where it is
    assert checker.free(states[1]) == expected
    add_ball(own.scene_graph, own.loaded)  # of the scene graph, not of the context
    assert checker.free(states[1]) == expected
    context.UpdateFramePoses(first_pose(own, 0.61))
    for _ in range(2):
        with pytest.raises(GeometryError, match=CHANGED):
            checker.free(states[1])
    again = Checker(context, own.joints)
    assert again.clearance(states[1]) == Checker(context, own.joints).clearance(states[1])
    filter_all(own, context)
    with pytest.raises(GeometryError, match=CHANGED):
        again.free(states[1])


def test_of_a_context_the_answers_are_those_of_its_poses(own):
    context = own.scene_graph.CreateDefaultContext()
    context.UpdateFramePoses(first_pose(own, 0.2))
    states = own.states(200)
    checker = Checker(context, own.joints)
    asked = {'want': 'collision', 'max_distance': 0.0, 'states': states, 'joints': own.joints}
    here, there = evaluate(context, **asked), evaluate(own.scene_graph, **asked)
    assert (here != there).any()
    np.testing.assert_array_equal(checker.free_each(states), ~here)


def test_threads_may_share_one_checker_or_have_their_own(cell):
    states = cell.states(400)
    shared = Checker(cell.scene_graph, cell.joints)
    expected = ~collides(cell, states, 0.0)
    clearances = [shared.clearance(q) for q in states]
    wrong = []

    def ask(seed):
        own = Checker(cell.scene_graph, cell.joints) if seed % 2 else shared
        for k in np.random.default_rng(seed).permutation(len(states)):
            if own.free(states[k]) != expected[k] or own.clearance(states[k]) != clearances[k]:
                wrong.append(k)

    threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_what_cannot_be_prepared_is_refused(own):
    for margin in (-0.01, np.nan, np.inf, None, '0.1'):
        with pytest.raises(ArgumentError, match='margin='):
            Checker(own.scene_graph, own.joints, margin)
    with pytest.raises(ArgumentError, match='accuracy='):
        Checker(own.scene_graph, own.joints, accuracy='good')
    with pytest.raises(ArgumentError, match=r'Joints\.of'):
        Checker(own.scene_graph, own.joints.names)
    with pytest.raises(PoseError, match='not in this scene'):
        Checker(Cell().scene_graph, own.joints)
    with pytest.raises(ArgumentError, match=r'arm::elbow'):
        Joints.of(own.loaded, ['arm::elbow'])
    with pytest.raises(TypeError, match='make one in each'):
        pickle.dumps(Checker(own.scene_graph, own.joints))


def test_frames_that_have_no_pose_are_named():
    text = Cell.path.read_text().replace(', pose: {position: [0.6, 0.1, 0.4]}}', '}')
    scene_graph = SceneGraph()
    loaded = load_scene(
        text.replace('arm.urdf', str(Cell.path.with_name('arm.urdf'))), scene_graph
    )
    with pytest.raises(PoseError, match="never had a pose: 'tray'"):
        Checker(scene_graph, Joints.of(loaded))


def test_joints_that_move_nothing_that_could_collide_are_refused(own):
    filter_all(own)
    with pytest.raises(ArgumentError, match='nobody looks at'):
        Checker(own.scene_graph, own.joints)


def test_what_hangs_on_a_link_moves_with_it(own):
    cell = own
    # A ball on a frame on the last link: what a gripper holds.
    link = cell.joints.frame_ids[-1]
    inspector = cell.scene_graph.model_inspector()
    source = inspector.GetOwningSourceId(link)
    held = cell.scene_graph.RegisterFrame(source, link, GeometryFrame('held'))
    ball = GeometryInstance(RigidTransform([0, 0, 0.2]), Sphere(0.1), 'ball')
    ball.set_proximity_properties(ProximityProperties())
    cell.scene_graph.RegisterGeometry(source, held, ball)
    poses = FramePoseVector()
    poses.set_value(held, RigidTransform())
    cell.scene_graph.SetFirstPoses(poses)
    states = cell.states(300)
    checker = Checker(cell.scene_graph, cell.joints)
    expected = ~collides(cell, states, 0.0)
    assert [checker.free(q) for q in states] == expected.tolist()
    assert any('ball' in checker.reason(q) for q in states)
