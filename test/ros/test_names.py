"""Names with `::`, `/` and `#` through a real node: found whole, or refused with both meanings."""

import pytest
from drake_geom_msgs import msg, srv
from ros.scene_calls import accepted, add_sphere, place_of, poses, refused

pytestmark = pytest.mark.topics


def distance(client, a, b):
    return client.call(
        srv.ComputeSignedDistancePair,
        'compute_signed_distance_pair',
        geometry_a=a,
        geometry_b=b,
    )


def test_names_are_compared_whole_and_what_stands_for_two_is_refused(client):
    ids = {}
    for source, frames in (('o', ['p::q', 'arm::base', 'x/y', '#123456789']), ('o::p', ['q'])):
        accepted(client.call(srv.RegisterSource, 'register_source', name=source))
        for frame in frames:
            ids[source, frame] = add_sphere(client, source, frame, 0.1)
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    sent = [
        ('o', ['p::q', 'o::arm::base', 'x/y', '#123456789'], [0, 1, 2, 3]),
        ('o::p', ['q'], [4]),
    ]

    def arrived():
        for source, frames, places in sent:
            publisher.publish(poses(frames, [(x, 0, 0) for x in places], source))
        return place_of(client, 'q') == (4, 0, 0) and place_of(client, 'x/y') == (2, 0, 0)

    client.wait_for(arrived, 'poses')
    assert place_of(client, 'p::q') == (0, 0, 0)
    assert place_of(client, 'o::arm::base') == place_of(client, 'arm::base') == (1, 0, 0)
    assert place_of(client, '#123456789') == place_of(client, 'o::#123456789') == (3, 0, 0)
    both = "'o::p::q' of source 'o' (#", "'o::p::q' of source 'o::p' (#"
    refused(client.call(srv.GetPose, 'get_pose', frame='o::p::q'), '2 frames share', *both)
    answer = accepted(distance(client, 'o::arm::base/ball', 'x/y/ball'))
    assert abs(answer.result.distance[0] - 0.8) < 1e-9
    ball = "'o::p::q/ball' of source 'o' (#"
    refused(distance(client, 'o::p::q/ball', 'x/y/ball'), '2 geometries share', ball)
    number = ids['o::p', 'q']
    assert (
        abs(accepted(distance(client, f'#{number}', 'x/y/ball')).result.distance[0] - 1.8) < 1e-9
    )
    # With its source a frame is never taken for another one: a child goes onto the right one.
    request = {'source': 'o::p', 'name': 'child', 'parent': 'q'}
    accepted(client.call(srv.RegisterFrame, 'register_frame', **request))
    refused(
        client.call(srv.RegisterFrame, 'register_frame', **{**request, 'parent': 'p::q'}), 'p::q'
    )
