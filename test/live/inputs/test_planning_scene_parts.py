"""Paddings, octomap and robot state of MoveIt's planning scenes."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, opened, scene_text, state
from live.inputs.test_planning_scene import box, place
from live.inputs.test_robot_description import urdf as urdf_of
from live.live_scenes import Clock, live_scene
from live.moveit_messages import (
    attached_object,
    matrix,
    octomap_of,
    planning_scene,
    pose,
    robot_state,
    transform,
)

from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.sensed_maps import Cells

LINKS = ('base', 'hand', 'finger')
SPHERE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
BODIES = ''.join(f'<link name="{link}">{SPHERE}</link>' for link in LINKS[:2])
BODIES += (
    '<link name="finger"><collision><geometry><box size="0.2 0.4 0.4"/></geometry></collision>'
    '</link>'
)
FIXED = ''.join(
    f'<joint name="to_{child}" type="fixed"><parent link="base"/><child link="{child}"/>'
    f'<origin xyz="{x} 0 0"/></joint>'
    for child, x in (('hand', 2.0), ('finger', 4.0))
)


@pytest.fixture
def urdf(tmp_path):
    (tmp_path / 'arm.urdf').write_text(f'<robot name="arm">{BODIES}{FIXED}</robot>')
    return tmp_path / 'arm.urdf'


@pytest.fixture
def live(urdf):
    return live_scene(f'robots:\n- {{name: arm, urdf: {urdf}, pose: {{}}}}', Clock())


def padding(name, value):
    return Plain(link_name=name, padding=value)


def scale(name, value):
    return Plain(link_name=name, scale=value)


def gap(live, name='target/sphere_0'):
    """Return the distance of an object's first shape to each link."""
    with live.reading() as scene:
        names = scene.model.names
        results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
        gaps = {}
        for each in results:
            pair = {names.geometry_names[id] for id in (each.id_A, each.id_B)}
            others = [n for n in pair if not n.endswith(name)]
            if len(others) == 1:
                gaps[others[0].split('::')[1].split('/')[0]] = each.distance
    return gaps


def test_a_padding_makes_a_link_larger_until_another_one_comes(live):
    moveit = PlanningSceneInput(live)
    moveit.take_scene(planning_scene([box('target', 2.0, at=pose(2.0, 1.0))]))
    assert gap(live)['hand'] == pytest.approx(0.8)
    done = moveit.take_scene(planning_scene(link_padding=[padding('hand', 0.05)]))
    assert 'between links of robots, too' in done
    assert gap(live)['hand'] == pytest.approx(0.75)
    moveit.take_scene(planning_scene([box('other', 9.0)]))
    assert gap(live)['hand'] == pytest.approx(0.75), 'a diff without it leaves it'
    moveit.take_scene(planning_scene(link_padding=[padding('hand', 0.02), padding('base', 0.0)]))
    assert gap(live)['hand'] == pytest.approx(0.78)
    moveit.take_scene(planning_scene(link_padding=[padding('hand', 0.0)]))
    assert gap(live)['hand'] == pytest.approx(0.8)


def test_the_larger_padding_counts_of_the_scene_and_of_moveit(urdf):
    robot = f'{{name: arm, urdf: {urdf}, pose: {{}}, padding: {{hand: 0.1}}}}'
    live = live_scene(f'robots:\n- {robot}', Clock())
    moveit = PlanningSceneInput(live)
    moveit.take_scene(planning_scene([box('target', at=pose(2.0, 1.0))]))
    for given, expected in ((0.0, 0.7), (0.15, 0.65), (0.05, 0.7)):
        moveit.take_scene(planning_scene(link_padding=[padding('hand', given)]))
        assert gap(live)['hand'] == pytest.approx(expected)


def test_a_scaled_link_is_within_its_padding(live):
    moveit = PlanningSceneInput(live)
    moveit.take_scene(planning_scene([box('target', at=pose(4.0, 1.0))]))
    assert gap(live)['finger'] == pytest.approx(0.7)
    scaled = [scale('finger', 1.5), scale('hand', 2.0), scale('base', 0.5)]
    done = moveit.take_scene(planning_scene(link_scale=scaled))
    assert "link_scale of 'base' is 0.5 and counts as 1" in done
    # Scaled, the box ends at 0.3; the padding is half of the way to its corner.
    corner = 0.5 * math.hypot(0.2, 0.4, 0.4)
    assert gap(live)['finger'] == pytest.approx(0.7 - 0.5 * corner)
    assert gap(live)['finger'] <= 1.0 - 0.3 - 0.1
    moveit.take_scene(planning_scene(link_scale=[scale('finger', 1.0)]))
    assert gap(live)['finger'] == pytest.approx(0.7)


def test_paddings_and_matrix_hold_for_a_robot_that_comes_later(urdf):
    live = live_scene('sources: [cell]\n', Clock())
    moveit = PlanningSceneInput(live)
    objects = [box('target', at=pose(2.0, 1.0)), box('mug', at=pose(0.0, 1.0))]
    done = moveit.take_scene(
        planning_scene(
            objects,
            link_padding=[padding('hand', 0.05)],
            allowed=matrix(['mug', 'base'], [('mug', 'base')]),
        )
    )
    assert 'hand is no link of a robot' in done
    robot = read_scene(f'robots:\n- {{name: arm, urdf: {urdf}, pose: {{}}}}')
    live.change(addition(robot))
    assert gap(live)['hand'] == pytest.approx(0.8)
    assert 'base' in gap(live, 'mug/sphere_0')
    moveit.renew()
    assert gap(live)['hand'] == pytest.approx(0.75)
    assert 'base' not in gap(live, 'mug/sphere_0')
    with live.reading() as scene:
        version = scene.model.version
    moveit.renew()
    with live.reading() as scene:
        assert scene.model.version == version


def test_a_robot_may_come_while_the_matrix_excludes_pairs(live):
    moveit = PlanningSceneInput(live)
    moveit.take_scene(
        planning_scene([box('mug')], allowed=matrix(['mug', 'base'], [('mug', 'base')]))
    )
    assert 'base' not in gap(live, 'mug/sphere_0')
    assert 'added' in RobotInput(live).take(urdf_of('other', 'a', 'b', 'c'))
    moveit.renew()
    assert 'base' not in gap(live, 'mug/sphere_0')
    with live.reading() as scene:
        manager = scene.model.filter_manager
        names = scene.model.names
        a, b = (names.geometry(f'other::{link}/collision_0') for link in 'ab')
        assert manager.explain(a, b), 'adjacent links are filtered'
        assert len(manager.active_filter_ids()) == 1


CELLS = Cells.of_points([[1.1, 0.1, 0.1], [1.1, 0.6, 0.1]], 0.5)


def cells_in_world(live):
    with live.reading() as scene:
        if 'planning_scene' not in scene.maps.by_name:
            return None
        seen = scene.maps.by_name['planning_scene']
        X = scene.query.X_WF(seen.frame)
        return sorted(np.round(X.multiply(seen.cells.centres().T).T, 9).tolist())


def test_an_octomap_is_a_map_of_the_scene_where_its_frame_is(live):
    moveit = PlanningSceneInput(live)
    moveit.take_scene(planning_scene([box('a', 9.0)], octomap=octomap_of(CELLS)))
    assert cells_in_world(live) == [[1.25, 0.25, 0.25], [1.25, 0.75, 0.25]]
    moveit.take_scene(planning_scene([box('b', 8.0)]))
    assert len(cells_in_world(live)) == 2, 'a diff without one leaves it'
    quarter = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    there = octomap_of(CELLS, frame='hand', at=pose(0.0, 0.0, 1.0, q=quarter))
    moveit.take_scene(planning_scene(octomap=there))
    assert cells_in_world(live) == [[1.25, 1.25, 1.25], [1.75, 1.25, 1.25]]
    with live.reading() as scene:
        # The hand at (2, 0, 0) and the nearest corner of the cells at (2, 1, 1).
        names = scene.model.names
        distances = {
            frozenset(names.geometry_names[i].split('/')[0] for i in (p.id_A, p.id_B)): p.distance
            for p in scene.query.ComputeSignedDistancePairwiseClosestPoints()
        }
    assert distances[frozenset(['arm::hand', 'obstacles::planning_scene'])] == pytest.approx(
        math.sqrt(2.0) - 0.1
    )
    moveit.take_scene(planning_scene(is_diff=False))
    assert cells_in_world(live) is None, 'a full scene without one'
    moveit.take_scene(planning_scene(octomap=octomap_of(CELLS)))
    moveit.take_scene(planning_scene(octomap=octomap_of(None, id='OcTree')))
    assert cells_in_world(live) is None, 'an empty one in a diff'


def test_the_matrix_names_the_octomap(live):
    moveit = PlanningSceneInput(live)
    allowed = matrix(['<octomap>', 'hand'], [('<octomap>', 'hand')])

    def touching():
        with live.reading() as scene:
            names = scene.model.names.geometry_names
            pairs = scene.query.FindCollisionCandidates()
        every = {frozenset(names[i].split('/')[0] for i in pair) for pair in pairs}
        return {
            next(iter(p - {'obstacles::planning_scene'}))
            for p in every
            if 'obstacles::planning_scene' in p
        }

    cells = octomap_of(Cells.of_points([[2.1, 0.1, 0.1]], 0.5))
    moveit.take_scene(planning_scene(octomap=cells))
    assert 'arm::hand' in touching()
    moveit.take_scene(planning_scene(allowed=allowed))
    assert 'arm::hand' not in touching()
    moveit.take_scene(planning_scene(octomap=octomap_of(None, id='OcTree')))
    moveit.take_scene(planning_scene(octomap=cells))
    assert 'arm::hand' not in touching(), 'it holds for a map that comes later'
    moveit.take_scene(planning_scene(allowed=matrix(['hand'], (), {'hand': True})))
    assert 'arm::hand' not in touching(), 'a default is about the octomap, too'


def test_a_refused_scene_leaves_no_octomap(live):
    moveit = PlanningSceneInput(live)
    bad = planning_scene([box('a', frame='nowhere')], octomap=octomap_of(CELLS))
    with pytest.raises(RuntimeError, match='nowhere'):
        moveit.take_scene(bad)
    assert cells_in_world(live) is None


# Joints.


@pytest.fixture
def arm(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    return tmp_path


def taking(text, *, by_default=False):
    live, joints = opened(text, Clock(1000.0), by_default=by_default)
    return live, joints, PlanningSceneInput(live, joints=lambda: joints)


VALUES = dict(zip(JOINTS_OF_ARM, (0.5, 0.3, 0.05), strict=True))


def test_joints_that_no_topic_drives_stand_as_the_scene_says(arm):
    live, joints, moveit = taking(scene_text(arm, 'name: arm, pose: {}'))
    told, other = opened(scene_text(arm, 'name: arm, pose: {}'), Clock(1000.0))
    with told.editing() as scene:
        other.take(scene, state(VALUES, VALUES.values()), 0.0)
    held = attached_object('hand', box('mug', frame='hand', at=pose(0.1)))
    moveit.take_scene(
        planning_scene([box('shelf', frame='hand')], state=robot_state(VALUES, attached=[held]))
    )
    for link in ('upper', 'hand', 'left', 'right'):
        assert place(live, link) == place(told, link)
    # Poses in the message are measured in links where its joints put them.
    assert place(live, 'shelf') == pytest.approx(place(told, 'hand'))
    assert np.linalg.norm(np.subtract(place(live, 'mug'), place(told, 'hand'))) == pytest.approx(
        0.1
    )
    with live.reading() as scene:
        assert not joints.troubles(scene, 5.0)


def test_joints_that_a_topic_drives_are_left_to_it(arm):
    live, joints, moveit = taking(scene_text(arm, 'name: arm, pose: {}'), by_default=True)
    with live.editing() as scene:
        joints.take(scene, state(VALUES, [0.0, 0.0, 0.0]), 0.0)
    before = place(live, 'hand')
    done = moveit.take_scene(planning_scene(joints=VALUES))
    assert 'values of shoulder, wrist, finger are ignored' in done
    assert place(live, 'hand') == before
    assert moveit.take_scene(planning_scene(joints=VALUES)) == '', 'it is logged once'


def test_a_refused_scene_leaves_the_joints_as_they_are(arm):
    live, _, moveit = taking(scene_text(arm, 'name: arm, pose: {}'))
    moveit.take_scene(planning_scene(joints=VALUES))
    before = place(live, 'hand')
    with pytest.raises(RuntimeError, match='nowhere'):
        moveit.take_scene(
            planning_scene([box('a', frame='nowhere')], joints={**VALUES, 'shoulder': 1.0})
        )
    assert place(live, 'hand') == before
    with pytest.raises(RuntimeError, match="position of 'shoulder' is nan"):
        moveit.take_scene(planning_scene(joints={'shoulder': math.nan}))


def test_names_of_two_robots_are_ignored_and_reported(arm):
    live, _, moveit = taking(scene_text(arm, 'name: a, pose: {}', 'name: b, pose: {}'))
    done = moveit.take_scene(
        planning_scene(joints={'shoulder': 1.0, 'nothing': 0.0, 'stick': 0.0})
    )
    assert 'values of shoulder, nothing are ignored' in done
    full = {f'{robot}::{name}': q for robot in 'ab' for name, q in VALUES.items()}
    moveit.take_scene(planning_scene(joints=full))
    assert place(live, 'a::hand') == place(live, 'b::hand')


SRDF = """<robot name="arm"><virtual_joint name="floor" type="planar" parent_frame="world"
child_link="base"/></robot>"""


def test_a_virtual_joint_says_where_the_base_stands(arm):
    (arm / 'arm.srdf').write_text(SRDF)
    live, _, moveit = taking(scene_text(arm, f'name: arm, srdf: {arm}/arm.srdf'))
    there = transform(3.0, 2.0, q=(0.0, 0.0, 1.0, 0.0))
    moveit.take_scene(
        planning_scene(
            [box('shelf', frame='upper')],
            state=robot_state(VALUES, {'floor': there}, frame='world'),
        )
    )
    assert place(live, 'base') == [3.0, 2.0, 0.0]
    assert place(live, 'upper') == pytest.approx([3.0, 2.0, 1.0])
    assert place(live, 'shelf') == pytest.approx([3.0, 2.0, 1.0])
    moveit.take_scene(planning_scene(state=robot_state({}, {'floor': transform(1.0)})))
    assert place(live, 'upper') == pytest.approx([1.0, 0.0, 1.0])
    done = moveit.take_scene(planning_scene(state=robot_state({}, {'wall': transform(1.0)})))
    assert 'values of wall are ignored' in done
