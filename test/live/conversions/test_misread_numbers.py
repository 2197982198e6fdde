"""Numbers that only an integer read as a double makes are refused, wherever they stand."""

import struct
from types import SimpleNamespace as Plain

import numpy as np
import pytest

pytest.importorskip('rclpy')
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point, Pose, TransformStamped
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from drake_geom_ros.live.conversions.misread_numbers import refuse_misread_numbers
from drake_geom_ros.live.conversions.transforms import transforms_of
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.tf_edges import judged
from drake_geom_ros.math.tolerances import SMALLEST_SENT


def misread(integer):
    """Return what a receiver reads where rclpy sends the bits of an integer."""
    return struct.unpack('d', struct.pack('q', integer))[0]


@pytest.mark.parametrize('integer', [1, -(2**63) + 1, 2**53])
@pytest.mark.parametrize(
    ('place', 'message'),
    [
        ('max_distance', lambda x: srv.ComputeSignedDistancePairwise.Request(max_distance=x)),
        ('rule.enter', lambda x: srv.AddProximityRule.Request(rule=msg.ProximityRule(enter=x))),
        ('lease', lambda x: srv.RenewFilter.Request(lease=x)),
        ('pose.position.x', lambda x: srv.Attach.Request(pose=Pose(position=Point(x=x)))),
        ('shape.dimensions[1]', lambda x: srv.ChangeShape.Request(shape=_shape(x))),
        ('roles[0].properties[0].value.double_value', lambda x: _with_property(x)),
        ('poses.poses[2]', lambda x: srv.HasCollisions.Request(poses=_poses(x))),
        ('poses[2]', lambda x: _poses(x)),
    ],
)
def test_an_integer_read_as_a_double_is_refused_by_its_place(integer, place, message):
    with pytest.raises(RuntimeError) as refused:
        refuse_misread_numbers(message(misread(integer)))
    assert str(refused.value).startswith(f'{place}: ')


def _shape(x):
    return msg.Shape(type=1, dimensions=[1.0, x])


def _poses(x):
    return msg.FramePoses(frame_names=['a'], poses=[0.0, 0.0, x, 0.0, 0.0, 0.0, 1.0])


def _with_property(x):
    property = msg.Property(group='g', name='n')
    property.value.double_value = x
    return srv.RegisterGeometry.Request(roles=[msg.Role(properties=[property])])


@pytest.mark.parametrize('number', [0.0, -0.0, 1.0, SMALLEST_SENT, -1e-200, np.inf, np.nan])
def test_other_numbers_pass(number):
    refuse_misread_numbers(srv.ComputeSignedDistancePairwise.Request(max_distance=number))


def test_joint_values_may_decay_through_every_magnitude():
    tiny = [5e-324]
    refuse_misread_numbers(JointState(name=['a'], position=tiny, velocity=tiny))
    path = JointTrajectory(points=[JointTrajectoryPoint(positions=tiny)])
    refuse_misread_numbers(srv.CheckMotion.Request(path=path))
    refuse_misread_numbers(srv.EvaluateStates.Request(positions=tiny))


def test_what_is_no_message_passes():
    refuse_misread_numbers(b'bytes')
    refuse_misread_numbers(Plain(max_distance=5e-324))


def test_the_guard_refuses_such_requests_before_their_handler_and_messages_before_they_are_taken():
    taken, refusals = [], []
    log = Plain(warning=lambda text: None, error=lambda text: None)
    guard = Guard(log, lambda name, reason, count: refusals.append((name, reason)))
    request = srv.CheckMotion.Request(min_distance=misread(1))
    response = guard.answer(lambda *each: taken.append(each), None, request, Plain())
    assert not response.success
    assert response.message.startswith('min_distance: ')
    guard.take('frame_poses', taken.append, _poses(misread(1)))
    assert refusals[0][0] == 'frame_poses'
    assert not taken


def test_a_transform_with_such_a_number_is_left_out_and_named():
    transforms = [TransformStamped(child_frame_id=name) for name in ('good', 'bad')]
    for transform in transforms:
        transform.header.frame_id = 'world'
    transforms[1].transform.translation.x = misread(1)
    good, refusal = judged(transforms_of(Plain(transforms=transforms)))
    assert good.tolist() == [0]
    assert refusal.transforms == 1
    assert "'bad' in 'world': 5e-324 is refused" in refusal.reason
