"""``check_state_validity`` on a live scene, without ROS, beside what batches say."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.test_joint_input import AT, JOINTS_OF_ARM
from live.live_scenes import Clock, live_scene
from live.moveit_messages import (
    REMOVE,
    attached_object,
    ball,
    collision_object,
    pose,
    robot_state,
    transform,
)
from live.scene.test_touch_links import SRDF, URDF
from live.services.test_path_motions import hall_in
from live.services.test_states import BOUNDS, answer, cell_in

from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.services.state_validity import ValidityMessages, check_state_validity


@pytest.fixture
def live(tmp_path):
    return live_scene(cell_in(tmp_path, 'adjacent_links: filtered'), Clock(1000.0))


def vector():
    return Plain(x=0.0, y=0.0, z=0.0)


def contact():
    return Plain(header=Plain(frame_id=''), position=vector(), normal=vector(), depth=0.0)


def cost_source():
    return Plain(cost_density=0.0, aabb_min=vector(), aabb_max=vector())


MESSAGES = ValidityMessages(contact, cost_source)


def validity(
    live, names=(), positions=(), group='', attached=(), constraints=(), several=(), frame=''
):
    values = dict(zip(names, positions, strict=False))
    given = {'name': list(names), 'position': list(positions)}
    state = robot_state(values, several, attached, frame=frame, **given)
    return ask(live, state, group, constraints)


def ask(live, state, group='', constraints=()):
    kinds = ('joint', 'position', 'orientation', 'visibility')
    lists = {f'{kind}_constraints': [] for kind in kinds}
    limits = Plain(**{**lists, 'joint_constraints': list(constraints)})
    request = Plain(robot_state=state, group_name=group, constraints=limits)
    response = Plain(valid=False, contacts=[])
    check_state_validity(live, MESSAGES, request, response)
    return response


def test_a_state_is_valid_where_batches_call_it_free(live):
    states = np.random.default_rng(7).uniform(*BOUNDS, size=(200, 3))
    free = answer(live, states, ignore_limits=True).free
    answers = [validity(live, JOINTS_OF_ARM, each) for each in states]
    assert [each.valid for each in answers] == list(free)
    assert 0 < sum(free) < len(free)
    found = [each for one in answers for each in one.contacts]
    assert {each.body_type_1 for each in found} | {each.body_type_2 for each in found} == {0, 1}
    for each in found:
        assert each.depth > 0.0
        normal = [each.normal.x, each.normal.y, each.normal.z]
        assert np.linalg.norm(normal) == pytest.approx(1.0)


def corners(source):
    return np.array([[p.x, p.y, p.z] for p in (source.aabb_min, source.aabb_max)])


STACK = """
sources: [cell]
frames:
- {name: crate, source: cell, pose: {position: [0, 0, 0.4], rpy: [0, 0, 0.78539816339744831]}}
geometries:
- {name: floor, source: cell, shape: {type: half_space}}
- {name: crate, source: cell, frame: crate, shape: {type: box, size: [1, 1, 1]}}
- name: ball
  source: cell
  frame: crate
  shape: {type: sphere, radius: 0.25}
  pose: {position: [5, 0, 0]}
  roles: {proximity: {proximity: {padding: 0.2}}}
"""


SLOPE = """
sources: [cell]
frames: [{{name: crate, source: cell, pose: {{}}}}]
geometries:
- name: floor
  source: cell
  shape: {{type: half_space}}
  pose: {{rpy: {rpy}, position: [{x}, 0, 0]}}
- {{name: crate, source: cell, frame: crate, shape: {{type: box, size: [1, 1, 1]}}}}
"""


def test_cost_sources_are_the_boxes_that_both_bodies_have_in_common():
    live = live_scene(STACK, Clock(1000.0))
    found = validity(live)
    assert not found.valid
    assert [each.cost_density for each in found.cost_sources] == [1.0, 1.0]
    crate, ball = map(corners, found.cost_sources)  # the largest first
    side = np.sqrt(0.5)
    np.testing.assert_allclose(
        crate, [[-side, -side, -0.1], [side, side, 0.0]], rtol=0, atol=1e-12
    )
    x = 5.0 * side
    np.testing.assert_allclose(
        ball, [[x - 0.45, x - 0.45, -0.05], [x + 0.45, x + 0.45, 0.0]], rtol=0, atol=1e-12
    )


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_cost_source_on_a_slope_is_around_what_is_below_it(seed):
    rng = np.random.default_rng(seed)
    rpy = [round(float(angle), 3) for angle in rng.uniform(-3.0, 3.0, 3)]
    live = live_scene(SLOPE.format(rpy=rpy, x=rng.uniform(-0.8, 0.8)), Clock(1000.0))
    found = validity(live)
    with live.reading() as held:
        X_WF = held.query.X_WG(held.model.names.geometry('cell::world/floor'))
    points = rng.uniform(-0.5, 0.5, size=(3000, 3))
    normal = X_WF.rotation().matrix()[:, 2]
    below = points[(points - X_WF.translation()) @ normal <= 0.0]
    if not len(found.cost_sources):
        assert not len(below)
        return
    (low, high) = corners(found.cost_sources[0])
    assert (below >= low - 1e-9).all()
    assert (below <= high + 1e-9).all()
    if len(below) > 300:
        np.testing.assert_allclose(below.min(axis=0), low, rtol=0, atol=0.25)
        np.testing.assert_allclose(below.max(axis=0), high, rtol=0, atol=0.25)


def test_points_of_contacts_lie_in_their_cost_sources(live):
    states = np.random.default_rng(8).uniform(*BOUNDS, size=(50, 3))
    count = 0
    for each in states:
        found = validity(live, JOINTS_OF_ARM, each)
        assert len(found.cost_sources) == len(found.contacts)
        boxes = [corners(source) for source in found.cost_sources]
        volumes = [np.prod(high - low) for low, high in boxes]
        assert volumes == sorted(volumes, reverse=True)
        for point in (each.position for each in found.contacts):
            p = np.array([point.x, point.y, point.z])
            assert any((low <= p + 1e-9).all() and (p <= high + 1e-9).all() for low, high in boxes)
            count += 1
    assert count > 10


@pytest.mark.parametrize(
    ('fields', 'reason'),
    [
        ({'names': ['nothing'], 'positions': [0.0]}, "no joint 'nothing'"),
        ({'names': JOINTS_OF_ARM, 'positions': [0.0]}, 'positions holds 1 numbers'),
        ({'group': 'arm'}, "group_name is 'arm', which is 0 groups; groups: none"),
        (
            {'attached': [attached_object('hand', collision_object('mug'))]},
            "attaches 'mug' to 'hand', which the scene does not",
        ),
        ({'several': {'nothing': transform()}}, "'nothing' is no joint of a robot here"),
        ({'constraints': [Plain()]}, 'constraints of joint are not evaluated'),
        ({}, 'the scene is incomplete'),
    ],
)
def test_what_cannot_be_answered_is_refused(live, fields, reason):
    with pytest.raises(RuntimeError, match=reason):
        validity(live, **fields)


def test_a_group_counts_with_what_its_links_carry(tmp_path):
    """All links stand in one place; two of them are fingers, and one carries a ball."""
    (tmp_path / 'arm.urdf').write_text(URDF)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    keys = f'name: arm, urdf: {tmp_path}/arm.urdf, srdf: {tmp_path}/arm.srdf, {AT}'
    live = live_scene(f'robots:\n- {{{keys}, configuration: {{wrist: 0, l: 0, r: 0}}}}', Clock())
    moveit = PlanningSceneInput(live)
    message = collision_object('ball', frame='hand', primitives=[ball()], primitive_poses=[pose()])
    moveit.take_attached(attached_object('left', message))

    def found(group):
        contacts = validity(live, group=group).contacts
        return {frozenset([c.contact_body_1, c.contact_body_2]) for c in contacts}

    every = {frozenset(pair) for pair in (['left', 'right'], ['ball', 'hand'], ['ball', 'right'])}
    assert found('') == found('gripper') == found('fingers') == every
    moveit.take_attached(attached_object('', collision_object('ball', REMOVE)))
    every |= {frozenset(['ball', 'left'])}
    assert found('fingers') == every - {frozenset(['ball', 'hand'])}
    assert found('') == every


def test_a_state_may_attach_what_the_scene_attaches_as_moveit_repeats_it(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    keys = f'name: arm, urdf: {tmp_path}/arm.urdf, {AT}, configuration: {{wrist: 0, l: 0, r: 0}}'
    live = live_scene(f'robots:\n- {{{keys}}}\n', Clock())
    message = collision_object('ball', frame='hand', primitives=[ball()], primitive_poses=[pose()])
    PlanningSceneInput(live).take_attached(attached_object('left', message))
    again = validity(live, attached=[attached_object('left', message)])
    assert len(again.contacts) == len(validity(live).contacts)
    with pytest.raises(RuntimeError, match="attaches 'ball' to 'right'"):
        validity(live, attached=[attached_object('right', message)])


def test_transforms_pose_bases_and_joints_of_several_values(tmp_path):
    hall = hall_in(tmp_path)
    assert validity(hall).valid
    # The hand stands 1.5 m above the base, and the post there at x = 2.
    there = {'floor': transform(1.9)}
    found = validity(hall, several=there, frame='world')
    assert {found.contacts[0].contact_body_1, found.contacts[0].contact_body_2} == {
        'hand',
        'hall::world/post',
    }
    assert validity(hall, several={'floor': transform(1.9, 3.0)}).valid
    assert validity(hall).valid, 'the scene has not changed'
    short = robot_state(several=there)
    short.multi_dof_joint_state.transforms = []
    with pytest.raises(RuntimeError, match='1 names and 0 transforms'):
        ask(hall, short)
    with pytest.raises(RuntimeError, match="is measured in 'odom'"):
        validity(hall, several=there, frame='odom')
