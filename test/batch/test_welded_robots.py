"""Robots welded to the world: what joint values do not move stays anchored in each state."""

import numpy as np
import pytest

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import ArgumentError, FramePoseVector, SceneGraph
from drake_geom_ros.scene_files import load_scene

ROBOT = """<robot name="arm"><link name="world"/>
<link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="tip"><collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry>
</collision></link>
<joint name="weld" type="fixed"><origin xyz="0 0 0.09"/><parent link="world"/><child link="base"/>
</joint>
<joint name="turn" type="revolute"><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/><parent link="base"/>
<child link="tip"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>"""
SCENE = """
robots: [{name: arm, urdf: arm.urdf}]
geometries:
- {name: floor, shape: {type: half_space}}
"""
TURNED_DOWN = 1.4  # [rad], where the tip is in the floor
STATES = np.array([[0.0], [-1.0], [0.3], [TURNED_DOWN]])


@pytest.fixture
def cell(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ROBOT)
    path = tmp_path / 'cell.yaml'
    path.write_text(SCENE)
    graph = SceneGraph()
    return graph, load_scene(path, graph)


def test_the_base_on_the_floor_collides_in_no_state(cell):
    graph, loaded = cell
    joints = Joints.of(loaded)
    found = evaluate(graph, want='collision', states=STATES, joints=joints)
    assert found.tolist() == [False, False, False, True]


@pytest.mark.parametrize('want', ['least', 'within'])
def test_states_are_answered_as_a_context_posed_alike(cell, want):
    graph, loaded = cell
    joints = Joints.of(loaded)
    found = evaluate(graph, want=want, states=STATES, joints=joints)
    for row, poses in enumerate(joints.poses(STATES)):
        context = graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(joints.id_values, poses))
        query = graph.get_query_output_port().Eval(context)
        pairs = query.ComputeSignedDistancePairwiseClosestPoints()
        assert len(pairs) == 1  # the tip and the floor
        at = row if want == 'least' else found.offsets[row]
        assert found.distance[at] == pairs.distance[0]
        assert (found.id_A[at], found.id_B[at]) == (pairs.id_A[0], pairs.id_B[0])


def test_states_that_pose_a_welded_base_themselves_end_its_weld(cell):
    graph, loaded = cell
    joints = Joints.of(loaded)
    poses = joints.poses(STATES)
    found = evaluate(graph, joints.frame_ids, poses, 'collision')
    assert found.all()


def test_a_base_that_joint_values_put_elsewhere_is_not_welded(cell):
    graph, loaded = cell
    joints = Joints.of(loaded)
    context = graph.CreateDefaultContext()
    (base,) = (id for (_, frame), id in loaded.frames.items() if frame == 'base')
    lifted = FramePoseVector.FromArrays([base], [[0, 0, 1.0, 0, 0, 0, 1]])
    context.UpdateFramePoses(lifted)
    assert evaluate(context, want='collision', states=STATES, joints=joints).all()


def test_a_joint_name_that_two_robots_bear_is_refused(tmp_path):
    """Robots ``a`` with a joint ``b::turn``, and ``a::b`` with ``turn``."""
    for file, joint in (('one.urdf', 'b::turn'), ('two.urdf', 'turn')):
        (tmp_path / file).write_text(ROBOT.replace('"turn"', f'"{joint}"'))
    path = tmp_path / 'cell.yaml'
    path.write_text("robots: [{name: a, urdf: one.urdf}, {name: 'a::b', urdf: two.urdf}]")
    loaded = load_scene(path, SceneGraph())
    for names in (None, ['a::b::turn']):
        with pytest.raises(ArgumentError, match='joints of two robots'):
            Joints.of(loaded, names)


MOBILE = ROBOT.replace('type="fixed"', 'type="planar"').replace('<origin xyz="0 0 0.09"/>', '')


def test_a_base_on_a_planar_joint_goes_where_its_columns_say(cell, tmp_path):
    (tmp_path / 'arm.urdf').write_text(MOBILE.replace('<parent', '<axis xyz="0 0 1"/><parent', 1))
    graph = SceneGraph()
    loaded = load_scene(tmp_path / 'cell.yaml', graph)
    joints = Joints.of(loaded)
    assert joints.names == ('arm::weld/x', 'arm::weld/y', 'arm::weld/theta', 'arm::turn')
    (poses,) = joints.poses(np.array([[1.0, 2.0, np.pi / 2, 0.0]]))
    np.testing.assert_allclose(poses[0], [1, 2, 0, 0, 0, 0.5**0.5, 0.5**0.5], rtol=0, atol=1e-12)
    np.testing.assert_allclose(poses[1, :3], [1, 2, 0.5], rtol=0, atol=1e-12)
    some = Joints.of(loaded, ['arm::turn'])
    assert some.count == 1
    assert some.frame_ids == []


def test_a_robot_whose_joint_has_no_leader_is_refused_with_the_way_round(cell, tmp_path):
    urdf = ROBOT.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="thumb"/>')
    (tmp_path / 'arm.urdf').write_text(urdf)
    loaded = load_scene(tmp_path / 'cell.yaml', SceneGraph())
    with pytest.raises(ArgumentError, match=r"'thumb'.*poses of frames"):
        Joints.of(loaded)
