"""Answers that leave something out for want of poses say so; what poses hang on. Without ROS."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import live_scene

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.services import queries, scene, shapes

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {position: [0, 0, 1]}}
  - {name: b, source: s, pose: {position: [0.15, 0, 1]}}
  - {name: nowhere, source: s}
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: nowhere, shape: {type: sphere, radius: 0.1}}
"""
LEFT_OUT = '2 pairs are left out because 1 frame never had a pose: s::nowhere'
WORLD, PARENT = 0, 1
ANSWER = Guard(logger=None, count=None).answer


@pytest.fixture
def live():
    return live_scene(TEXT)


def poses(**frames):
    """Return a FramePoses message of heights."""
    numbers = [float(v) for z in frames.values() for v in (0, 0, z, 0, 0, 0, 1)]
    names = {'source': '', 'frame_names': list(frames), 'frame_ids': []}
    return Plain(header=Plain(frame_id=''), **names, poses=numbers)


def ask(live, handler, given, **fields):
    """Return the answer to a request, with poses of its own."""
    unasked = Plain(names=[], positions=[])
    limits = {'accuracy': '', 'max_distance': 0.0, 'threshold': 0.0}
    request = Plain(poses=given, joints=unasked, **limits, **fields)
    header = Plain(frame_id='', stamp=None)
    response = Plain(success=False, message='', result=Plain(header=header))
    return ANSWER(handler, live, request, response)


ABOUT_ALL = {
    'penetration': queries.compute_point_pair_penetration,
    'distances': queries.compute_signed_distance_pairwise,
    'points': queries.compute_signed_distance_to_point,
    'candidates': queries.find_collision_candidates,
    'collisions': queries.has_collisions,
}


@pytest.mark.parametrize('name', ABOUT_ALL)
def test_an_answer_about_all_says_what_it_leaves_out(live, name):
    points = {'points': [0.0, 0.0, 0.0]} if name == 'points' else {}
    response = ask(live, ABOUT_ALL[name], poses(), **points)
    assert (response.success, response.message) == (True, LEFT_OUT)
    # The poses of the question count.
    response = ask(live, ABOUT_ALL[name], poses(nowhere=5), **points)
    assert (response.success, response.message) == (True, '')
    assert ask(live, ABOUT_ALL[name], poses(), **points).message == LEFT_OUT


def test_what_is_known_is_answered(live):
    response = ask(live, queries.compute_signed_distance_pairwise, poses())
    assert list(response.result.distance) == [pytest.approx(-0.05)]
    response = ask(live, queries.compute_signed_distance_pairwise, poses(nowhere=1))
    assert len(response.result.distance) == 3


def test_a_pair_that_would_need_it_is_refused(live):
    pair = {'geometry_a': 'a/ball', 'geometry_b': 'nowhere/ball'}
    response = ask(live, queries.compute_signed_distance_pair, poses(), **pair)
    assert not response.success
    assert "'nowhere'" in response.message
    assert ask(live, queries.compute_signed_distance_pair, poses(nowhere=2), **pair).success


def get_pose(live, relative_to=WORLD, frame='', geometry=''):
    """Return the answer of get_pose."""
    numbers = dict.fromkeys('xyzw', 0.0)
    pose = Plain(position=Plain(**numbers), orientation=Plain(**numbers))
    stamped = Plain(pose=pose, header=Plain(frame_id='', stamp=None))
    request = Plain(frame=frame, geometry=geometry, relative_to=relative_to)
    response = Plain(success=False, message='', pose=stamped)
    return ANSWER(queries.get_pose, live, request, response)


@pytest.mark.parametrize('what', [{'frame': 'nowhere'}, {'geometry': 'nowhere/ball'}])
def test_nobody_knows_where_it_is(live, what):
    response = get_pose(live, **what)
    assert not response.success
    assert 'never had a pose' in response.message


def test_a_geometry_on_a_geometry_is_posed_in_the_frame_and_goes_with_the_other(live):
    """As the definitions of get_pose and remove_geometry say."""
    for name, parent in (('knob', 'a/ball'), ('tip', 'a/knob')):
        origin = Plain(position=Plain(x=0.0, y=0.0, z=0.5), orientation=Plain(x=0, y=0, z=0, w=1))
        shape = Plain(type=1, dimensions=[0.1], vertices=[], triangles=[], mesh_uri='')
        request = Plain(
            source='s', frame='', parent_geometry=parent, name=name, pose=origin, shape=shape,
            roles=[],
        )  # fmt: skip
        shapes.register_geometry(live, request, Plain())
    found = get_pose(live, PARENT, geometry='a/tip').pose
    assert (found.header.frame_id, found.pose.position.z) == ('s::a', 1.0)
    found = get_pose(live, WORLD, geometry='a/tip').pose
    assert (found.header.frame_id, found.pose.position.z) == ('world', 2.0)
    scene.remove_geometry(live, Plain(geometry='a/ball'), Plain())
    for name in ('a/ball', 'a/knob', 'a/tip'):
        assert 'There is no geometry' in get_pose(live, geometry=name).message


CROWD = """
sources: [s]
frames:
  - {name: a, source: s, pose: {}}
  - {name: b, source: s, pose: {}}
  - {name: nowhere, source: s}
geometries:
  - {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
  - {name: wall, source: s, shape: {type: half_space}, pose: {position: [0, 0, -2]}}
  - {name: post, source: s, shape: {type: box, size: [0.1, 0.1, 1]}}
  - {name: plane, source: s, frame: a, shape: {type: half_space}}
  - {name: seen, source: s, frame: a, shape: {type: sphere, radius: 1}, roles: {illustration: {}}}
  - {name: ball, source: s, frame: nowhere, shape: {type: sphere, radius: 0.1}}
""" + ''.join(
    f'  - {{name: ball_{k}, source: s, frame: {"ab"[k % 2]}, '
    'shape: {type: sphere, radius: 0.1}, pose: {position: [' + str(k) + ', 0, 0]}}\n'
    for k in range(8)
)
FILTERS = {
    '': 0,
    'filters: [{deactivate: [b/ball_1]}]': 0,
    'filters: [{exclude_within: [a, b]}]': 0,
    'filters: [{exclude_between: [[a/ball_0, a/ball_2], [b]]}]': 0,
    'filters: [{clique: {name: c, members: [a/ball_0, b/ball_1, b/ball_3]}}]': 0,
    # Two planes that are filtered count twice.
    'filters: [{exclude_between: [[a/plane], [world/floor]]}]': 1,
}


@pytest.mark.parametrize('filters', FILTERS)
def test_how_many_pairs_an_answer_has_is_known_before(filters):
    live = live_scene(CROWD + filters)
    view = live.view()
    found = view.query.ComputeSignedDistancePairwiseClosestPoints()
    assert queries._pairs_at_least(view) == len(found) - FILTERS[filters]


def test_an_answer_that_is_too_large_is_refused_before_it_is_computed(monkeypatch):
    live = live_scene(CROWD)
    live.most_megabytes = 0.001
    monkeypatch.setattr(queries, 'distances_to', None)
    query = 'ComputeSignedDistancePairwiseClosestPoints'
    monkeypatch.setattr(f'drake_geom_ros.geometry.QueryObject.{query}', None)
    points = {'points': [0.0, 0.0, 0.0] * 10}
    # Of 78 pairs 19 are of one frame, and 2 of planes; 10 of the others wait for a pose.
    for name, fields, given, rows in (
        ('distances', {}, {'nowhere': 1}, 57),
        ('distances', {}, {}, 45),
        ('points', points, {'nowhere': 1}, 130),
        ('points', points, {}, 120),
    ):
        answer = ask(live, ABOUT_ALL[name], poses(**given), **fields)
        assert not answer.success
        assert answer.message.startswith(f'an answer of {rows} rows takes 0.0 MB')


def test_an_answer_for_which_there_is_no_memory_is_refused(monkeypatch):
    live = live_scene(CROWD)
    points = {'points': [0.0, 0.0, 0.0] * 10_000}
    monkeypatch.setattr(queries, 'free_memory', lambda: 20e6)
    answer = ask(live, ABOUT_ALL['points'], poses(nowhere=1), **points)
    assert answer.message == (
        'an answer of 130000 rows takes 51 MB of memory until it is sent, and the limits of the '
        'process leave 20 MB: ask for fewer points, or with a smaller threshold'
    )
