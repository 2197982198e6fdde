"""Two sources claim a frame: each has its own, and neither poses the other's."""

import pytest
from drake_geom_msgs import msg, srv
from ros.scene_calls import add_pair, place_of, poses, refused

pytestmark = pytest.mark.topics


def where(client, frame):
    place = place_of(client, frame)
    return place and place[0]


def test_frames_of_one_name_belong_to_their_sources(client):
    for source in ('first', 'second'):
        add_pair(client, source)
    # The short name stands for both.
    refused(client.call(srv.GetPose, 'get_pose', frame='a'), 'first::a', 'second::a')
    both = poses(['a'], [(5, 0, 0)])
    refused(client.call(srv.HasCollisions, 'has_collisions', poses=both), 'first::a', 'second::a')
    # A source cannot name what is not its own.
    stolen = poses(['second::a'], [(5, 0, 0)], 'first')
    refused(client.call(srv.HasCollisions, 'has_collisions', poses=stolen), 'second::a', 'first')
    refused(client.call(srv.RegisterSource, 'register_source', name='first'), 'first')


def test_two_publishers_pose_frames_of_one_name_apart(client):
    for source in ('left', 'right'):
        add_pair(client, source)
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def posed():
        publisher.publish(poses(['a'], [(1, 0, 0)], 'left'))
        publisher.publish(poses(['a'], [(2, 0, 0)], 'right'))
        return (where(client, 'left::a'), where(client, 'right::a')) == (1.0, 2.0)

    client.wait_for(posed, 'both poses')
