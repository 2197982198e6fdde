"""The node in its own process, asked through real topics and services."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.harness import LATCHED
from ros.scene_calls import (
    accepted,
    add_pair,
    add_sphere,
    declaration,
    exclude,
    place_of,
    poses,
    refused,
)

pytestmark = pytest.mark.topics

PAIR = ['a', 'b']


def answers_for(messages, id_a, id_b):
    """Return (distance, message) of the newest message that holds the pair."""
    for message in reversed(messages):
        for k, pair in enumerate(zip(message.id_a, message.id_b, strict=True)):
            if pair == (id_a, id_b):
                return message.distance[k], message
    return None


def test_poses_in_results_out(client):
    small, large = add_pair(client, 'in_out')
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')
    penetrations = client.listen(msg.PenetrationPairs, 'penetrations')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    client.wait_for(lambda: client.node.count_publishers('/scene_graph/penetrations'), 'results')

    def ask(x, stamp):
        publisher.publish(poses(PAIR, [(0, 0, 0), (x, 0, 0)], 'in_out', stamp))
        return next((m for m in distances if m.header.stamp.sec == stamp), None)

    apart = client.wait_for(lambda: ask(0.5, 7), 'the answer for the gap')
    gap, _ = answers_for([apart], small, large)
    assert gap == pytest.approx(0.2, abs=1e-15)
    assert list(apart.nhat_ba_w) == [-1.0, 0.0, 0.0]
    assert list(apart.p_aca) == pytest.approx([0.1, 0, 0])
    assert list(apart.p_bcb) == pytest.approx([-0.2, 0, 0])
    assert apart.header.frame_id == 'world'
    assert apart.error_bound[0] < 1e-14
    # No contact is an answer too.
    empty = client.wait_for(
        lambda: next((m for m in penetrations if m.header.stamp.sec == 7), None), 'no contact'
    )
    assert list(empty.id_a) == []
    client.wait_for(lambda: ask(0.25, 8), 'the answer for the overlap')
    hit = client.wait_for(
        lambda: next((m for m in penetrations if m.header.stamp.sec == 8), None), 'contact'
    )
    assert list(zip(hit.id_a, hit.id_b, strict=True)) == [(small, large)]
    assert hit.depth[0] == pytest.approx(0.05, abs=1e-15)
    witness = [b - a for a, b in zip(hit.p_wca, hit.p_wcb, strict=True)]
    depth = sum(w * n for w, n in zip(witness, hit.nhat_ba_w, strict=True))
    assert depth == pytest.approx(hit.depth[0], abs=1e-15)


def test_a_bad_message_is_refused_whole_and_counted(client):
    small, large = add_pair(client, 'hostile')
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')
    diagnostics = client.listen(DiagnosticArray, '/diagnostics')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    good = poses(PAIR, [(0, 0, 0), (0.4, 0, 0)], 'hostile', 11)
    short = poses(PAIR, [(0, 0, 0)], 'hostile', 12)
    both = poses(PAIR, [(0, 0, 0), (9, 0, 0)], 'hostile', 12)
    both.frame_ids = [1, 2]
    bad = [
        poses(PAIR, [(9, 0, 0), (math.nan, 0, 0)], 'hostile', 12),
        poses(PAIR, [(9, 0, 0), (0, 0, 0, 0, 0, 0, 1.1)], 'hostile', 12),
        poses(['a', 'nobody'], [(9, 0, 0), (0, 0, 0)], 'hostile', 12),
        poses(['a', 'a'], [(9, 0, 0), (0, 0, 0)], 'hostile', 12),
        poses(['world'], [(9, 0, 0)], 'hostile', 12),
        poses(PAIR, [(9, 0, 0), (0, 0, 0)], 'stranger', 12),
        short,
        both,
    ]

    def status():
        if not diagnostics:
            return {}
        return {v.key: v.value for v in diagnostics[-1].status[0].values}

    client.wait_for(status, 'diagnostics')
    before = int(status()['pose messages refused'])

    def all_refused():
        # Again and again: a server that has not found the publisher yet takes nothing of it.
        for message in bad:
            publisher.publish(message)
        return int(status()['pose messages refused']) >= before + len(bad)

    client.wait_for(all_refused, 'the refusals to be counted')

    def answer():
        publisher.publish(good)
        return next((m for m in distances if m.header.stamp.sec == 11), None)

    found = client.wait_for(answer, 'the answer to a good message after the bad ones')
    assert answers_for([found], small, large)[0] == pytest.approx(0.1, abs=1e-15)
    assert not any(m.header.stamp.sec == 12 for m in distances)


def test_what_if_leaves_the_live_scene_alone(client):
    add_pair(client, 'what_if')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    live = poses(PAIR, [(0, 0, 0), (0.4, 0, 0)], 'what_if')
    pair = {'geometry_a': 'what_if::a/ball', 'geometry_b': 'what_if::b/ball'}

    def distance(**what_if):
        answer = client.call(
            srv.ComputeSignedDistancePair, 'compute_signed_distance_pair', **pair, **what_if
        )
        return accepted(answer).result.distance[0]

    def posed():
        publisher.publish(live)
        return place_of(client, 'what_if::b') == (0.4, 0, 0)

    client.wait_for(posed, 'the live poses')
    assert distance() == pytest.approx(0.1, abs=1e-15)
    # Frame a is not named: it keeps its live pose.
    assert distance(poses=poses(['b'], [(1.3, 0, 0)], 'what_if')) == pytest.approx(1.0)
    assert distance() == pytest.approx(0.1, abs=1e-15)
    refused(
        client.call(
            srv.ComputeSignedDistancePair,
            'compute_signed_distance_pair',
            **pair,
            poses=poses(['b'], [(math.inf, 0, 0)], 'what_if'),
        ),
        'not finite',
    )
    refused(
        client.call(
            srv.ComputeSignedDistancePair,
            'compute_signed_distance_pair',
            **pair,
            accuracy='superb',
        ),
        'superb',
        'exact',
    )


def test_the_other_queries(client):
    small, large = add_pair(client, 'queries')
    apart = poses(PAIR, [(0, 0, 50), (0.5, 0, 50)], 'queries')
    touching = poses(PAIR, [(0, 0, 50), (0.2, 0, 50)], 'queries')
    answer = client.call(
        srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise', poses=apart
    )
    result = accepted(answer).result
    assert math.isinf(result.max_distance)
    assert answers_for([result], small, large)[0] == pytest.approx(0.2, abs=1e-13)
    candidates = accepted(
        client.call(srv.FindCollisionCandidates, 'find_collision_candidates', poses=touching)
    )
    assert (small, large) in zip(candidates.id_a, candidates.id_b, strict=True)
    assert accepted(
        client.call(srv.HasCollisions, 'has_collisions', poses=touching)
    ).has_collisions
    points = accepted(
        client.call(
            srv.ComputeSignedDistanceToPoint,
            'compute_signed_distance_to_point',
            points=[0.0, 0.0, 50.0, 1.0, 0.0, 50.0],
            threshold=0.35,
            poses=apart,
        )
    ).result
    found = dict(
        zip(zip(points.point_index, points.id_g, strict=True), points.distance, strict=True)
    )
    assert found == pytest.approx({(0, small): -0.1, (0, large): 0.3, (1, large): 0.3}, abs=1e-13)
    assert all(math.isfinite(g) for g in points.grad_w)
    # Points that came without a stamp.
    assert (points.query_stamp.sec, points.query_stamp.nanosec) == (0, 0)


def test_impossible_requests_are_refused_and_change_nothing(client):
    add_pair(client, 'refusals')

    def version_now():
        answer = client.call(srv.ComputePointPairPenetration, 'compute_point_pair_penetration')
        return accepted(answer).result.scene_version

    version = version_now()
    sphere = msg.Shape(type=msg.Shape.SPHERE, dimensions=[-1.0])
    place = {'source': 'refusals', 'frame': 'a', 'name': 'x'}
    call = client.call
    refused(call(srv.RegisterSource, 'register_source', name='refusals'), 'refusals')
    refused(call(srv.RegisterFrame, 'register_frame', source='nobody', name='x'), 'nobody')
    refused(call(srv.RegisterFrame, 'register_frame', source='refusals', name='a'), 'a')
    refused(call(srv.RegisterFrame, 'register_frame', source='refusals', name='world'), 'world')
    refused(call(srv.RegisterGeometry, 'register_geometry', shape=sphere, **place), 'radius', '-1')
    ball = msg.Shape(type=msg.Shape.SPHERE, dimensions=[1.0])
    twice = {'shape': ball, 'roles': [msg.Role(role=1), msg.Role(role=1)]}
    refused(call(srv.RegisterGeometry, 'register_geometry', **twice, **place), 'twice')
    taken = {**place, 'name': 'ball', 'shape': ball, 'roles': [msg.Role(role=1)]}
    refused(call(srv.RegisterGeometry, 'register_geometry', **taken), 'ball')
    mesh = msg.Shape(type=msg.Shape.MESH, dimensions=[1.0], mesh_uri='x.obj')
    refused(call(srv.RegisterGeometry, 'register_geometry', shape=mesh, **place), 'x.obj')
    refused(call(srv.RemoveGeometry, 'remove_geometry', geometry='refusals::a/none'), 'none')
    refused(call(srv.RemoveGeometry, 'remove_geometry', geometry='#999999'), '#999999')
    bad_role = msg.Role(role=9)
    refused(
        call(srv.AssignRole, 'assign_role', geometry='refusals::a/ball', role=bad_role), '9', '1'
    )
    refused(
        call(srv.AssignRole, 'assign_role', geometry='refusals::a/ball', role=msg.Role(role=1)),
        'kProximity',
    )
    refused(
        call(srv.ApplyFilter, 'apply_filter', declaration=declaration(9, ['refusals::a/ball'])),
        'operation',
    )
    refused(call(srv.GetPose, 'get_pose'), 'frame')
    refused(call(srv.LoadScene, 'load_scene', path='/nowhere.yaml'), 'nowhere.yaml')
    assert version_now() == version


def test_the_scene_topic_tells_ids_and_names(client):
    scenes = client.listen(msg.Scene, 'scene', LATCHED)
    accepted(client.call(srv.RegisterSource, 'register_source', name='listed'))
    ball = add_sphere(client, 'listed', 'f', 0.3, name=' ball ', roles=(1, 2))

    def entry():
        found = [g for g in scenes[-1].geometries if g.id == ball] if scenes else []
        return found[0] if found else None

    geometry = client.wait_for(entry, 'the new geometry')
    scene = scenes[-1]
    assert geometry.name == 'ball'
    assert [r.role for r in geometry.roles] == [1, 2]
    assert list(geometry.shape.dimensions) == [0.3]
    frame = next(f for f in scene.frames if f.id == geometry.frame_id)
    source = next(s for s in scene.sources if s.id == geometry.source_id)
    assert (frame.name, source.name) == ('f', 'listed')
    assert scene.frames[0].name == 'world'
    accepted(client.call(srv.RemoveGeometry, 'remove_geometry', geometry=f'#{ball}'))
    client.wait_for(lambda: not entry(), 'the removal to be told')


def test_a_saved_scene_comes_back(client):
    add_pair(client, 'saved')
    accepted(
        client.call(
            srv.ApplyFilter, 'apply_filter', declaration=exclude('saved::a/ball', 'saved::b/ball')
        )
    )
    text = accepted(client.call(srv.SaveScene, 'save_scene')).text
    assert 'saved' in text
    accepted(client.call(srv.LoadScene, 'load_scene', text=text, format='yaml', replace=True))
    assert accepted(client.call(srv.SaveScene, 'save_scene')).text == text
    answer = client.call(
        srv.ExplainFilter,
        'explain_filter',
        geometry_a='saved::a/ball',
        geometry_b='saved::b/ball',
    )
    assert accepted(answer).filtered


def test_poses_of_frames_and_geometries(client):
    add_pair(client, 'where')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def position(**request):
        pose = accepted(client.call(srv.GetPose, 'get_pose', **request)).pose
        return pose.header.frame_id, pose.pose.position.x

    def posed():
        # A call may overtake the message: topics and services keep no order between them.
        publisher.publish(poses(PAIR, [(3, 0, 0), (4, 0, 0)], 'where'))
        return client.call(srv.GetPose, 'get_pose', frame='where::a').success

    client.wait_for(posed, 'the pose')
    assert position(frame='where::a') == ('world', 3.0)
    assert position(geometry='where::b/ball') == ('world', 4.0)
    assert position(geometry='where::b/ball', relative_to=1) == ('where::b', 0.0)


def test_nothing_is_computed_for_nobody(client):
    add_pair(client, 'idle')
    reports = client.listen(msg.CycleReport, 'cycle_report')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    client.wait_for(
        lambda: client.node.count_subscribers('/scene_graph/signed_distances') == 0, 'no listener'
    )

    def idle():
        publisher.publish(poses(PAIR, [(0, 0, 0), (0, 0, 0)], 'idle'))
        ran = (
            dict(zip(reports[-1].effects, reports[-1].effect_ran, strict=True)) if reports else {}
        )
        return ran and not ran['narrowphase'] and not ran['publish ~/signed_distances']

    client.wait_for(idle, 'a cycle without listeners')
    report = reports[-1]
    reasons = dict(zip(report.effects, report.effect_reasons, strict=True))
    assert reasons['narrowphase'] == 'no subscriber'
    assert report.unpublished_messages == 3  # penetrations, distances, contact surfaces
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')

    def busy():
        publisher.publish(poses(PAIR, [(0, 0, 0), (0, 0, 0)], 'idle'))
        return (
            distances
            and dict(zip(reports[-1].effects, reports[-1].effect_ran, strict=True))['narrowphase']
        )

    client.wait_for(busy, 'a cycle with a listener')
    assert sum(reports[-1].method_pairs) >= 1


@pytest.mark.parametrize(
    ('name', 'value', 'word'),
    [
        ('accuracy', ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='x'), 'x'),
        (
            'max_distance',
            ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=-1.0),
            '',
        ),
        ('use_tf', ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True), 'use_tf'),
        ('scene_file', ParameterValue(type=ParameterType.PARAMETER_STRING, string_value='x'), ''),
    ],
)
def test_a_bad_parameter_is_refused(client, name, value, word):
    request = [Parameter(name=name, value=value)]
    result = client.call(SetParameters, 'set_parameters', parameters=request).results[0]
    assert not result.successful
    assert word in result.reason
