"""Gradients by joints: against frame Jacobians, and against differences of distances."""

import numpy as np
import pytest

from drake_geom_ros.batch import Checker, evaluate
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.trajectories import Kinematics


def asked(cell, states, **how):
    return evaluate(cell.scene_graph, states=states, joints=cell.joints, by_joints=True, **how)


@pytest.mark.parametrize(
    'how', [{'want': 'least'}, {'want': 'nearest', 'count': 3}, {'want': 'within'}]
)
def test_they_are_those_of_the_frames_jacobians(cell, how):
    states = cell.states(20)
    found = asked(cell, states, **how)
    arm = cell.loaded.robots['arm']
    kinematics = Kinematics(str(arm.urdf))
    Js = kinematics.link_jacobians(states, arm.X_WB.GetAsMatrix4())
    links = {
        id.get_value(): kinematics.link_names.index(link)
        for (source, link, _), id in cell.loaded.geometries.items()
        if source == 'arm'
    }
    offsets = getattr(found, 'offsets', np.arange(len(states) + 1))
    of_state = np.repeat(np.arange(len(states)), np.diff(offsets))
    assert found.joint_gradient.shape == (len(found.distance), 4)
    for k, s in enumerate(of_state):
        expected = np.zeros(4)
        for id, part in ((found.id_A[k], slice(0, 6)), (found.id_B[k], slice(6, 12))):
            if id in links:
                expected += found.gradient[k, part] @ Js[s, links[id]]
        np.testing.assert_allclose(found.joint_gradient[k], expected, rtol=0, atol=1e-12)


def test_they_are_differences_of_distances(cell):
    states, step = cell.states(40), 1e-6
    least = asked(cell, states, want='least')
    smooth = 0
    for k, q in enumerate(states):
        for joint in range(4):
            ends = np.array([q, q])
            ends[:, joint] += [-step, step]
            sides = asked(cell, ends, want='least')
            pairs = np.column_stack((sides.id_A, sides.id_B))
            if (pairs != (least.id_A[k], least.id_B[k])).any() or not least.is_nhat_BA_W_unique[k]:
                continue
            slope = (sides.distance[1] - sides.distance[0]) / (2.0 * step)
            assert abs(slope - least.joint_gradient[k, joint]) < 2e-3
            smooth += 1
    assert smooth > 100


def test_threads_and_blocks_change_no_bit_and_nobody_gets_what_he_did_not_ask_for(cell):
    states = cell.states(60)
    once = asked(cell, states, want='least', threads=1, block_size=60)
    again = asked(cell, states, want='least', threads=2, block_size=7)
    np.testing.assert_array_equal(once.joint_gradient, again.joint_gradient)
    plain = evaluate(cell.scene_graph, want='least', states=states, joints=cell.joints)
    assert plain.joint_gradient.shape == (60, 0)
    np.testing.assert_array_equal(plain.distance, once.distance)


def test_where_there_is_no_pair_it_is_zero(cell):
    found = asked(cell, cell.states(50), want='least', max_distance=-0.01)
    none = np.isinf(found.distance)
    assert none.any()
    assert not found.joint_gradient[none].any()
    assert set(found.name_A[none]) == {''}


def test_what_has_no_gradients_by_joints_is_refused(cell):
    states = cell.states(2)
    for how in ({'want': 'collision'}, {'want': 'points', 'points': [[0.0, 0.0, 0.0]]}):
        with pytest.raises(ArgumentError, match='by_joints'):
            asked(cell, states, **how)
    with pytest.raises(ArgumentError, match='by_joints'):
        evaluate(
            cell.scene_graph, cell.joints.frame_ids, cell.joints.poses(states), by_joints=True
        )


def test_results_name_their_geometries(cell):
    states = cell.states(20)
    least = evaluate(cell.scene_graph, want='least', states=states, joints=cell.joints)
    names = {'::'.join(key[:2]) + '/' + key[2] for key in cell.loaded.geometries}
    assert set(least.name_A) <= names
    assert set(least.name_B) <= names
    near = Checker(cell.scene_graph, cell.joints).nearest(states[3])
    assert (near.name_a, near.name_b) == (least.name_A[3], least.name_B[3])
    points = evaluate(
        cell.scene_graph, want='points', points=[[0, 0, 1]], states=states, joints=cell.joints
    )
    assert points.names_of(points.id_G).tolist() == points.name_G.tolist()
    assert names == set(points.name_G)
