"""``check_state_validity`` on a live scene, without ROS, beside what batches say."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import AT, JOINTS_OF_ARM
from live.live_scenes import Clock, live_scene
from live.moveit_messages import REMOVE, attached_object, ball, collision_object, pose
from live.scene.test_touch_links import SRDF, URDF
from live.services.test_states import BOUNDS, answer, cell_in

from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.services.state_validity import check_state_validity


@pytest.fixture
def live(tmp_path):
    return live_scene(cell_in(tmp_path, 'adjacent_links: filtered'), Clock(1000.0))


def contact():
    def vector():
        return Plain(x=0.0, y=0.0, z=0.0)

    return Plain(header=Plain(frame_id=''), position=vector(), normal=vector(), depth=0.0)


def validity(live, names=(), positions=(), group='', attached=(), constraints=()):
    state = Plain(
        joint_state=Plain(name=list(names), position=list(positions)),
        multi_dof_joint_state=Plain(joint_names=[]),
        attached_collision_objects=list(attached),
    )
    kinds = ('joint', 'position', 'orientation', 'visibility')
    lists = {f'{kind}_constraints': [] for kind in kinds}
    limits = Plain(**{**lists, 'joint_constraints': list(constraints)})
    request = Plain(robot_state=state, group_name=group, constraints=limits)
    response = Plain(valid=False, contacts=[])
    check_state_validity(live, contact, request, response)
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


@pytest.mark.parametrize(
    ('fields', 'reason'),
    [
        ({'names': ['nothing'], 'positions': [0.0]}, "no joint 'nothing'"),
        ({'names': JOINTS_OF_ARM, 'positions': [0.0]}, 'positions holds 1 numbers'),
        ({'group': 'arm'}, "group_name is 'arm', which is 0 groups; groups: none"),
        ({'attached': [Plain()]}, 'attached_collision_objects are not read'),
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
