"""How bodies press each other, from a real node: topic, service, markers, parameter, client."""

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.harness import PATIENCE, start_node
from ros.scene_calls import accepted, poses, refused
from visualization_msgs.msg import Marker, MarkerArray

from drake_geom_ros.client import IncompleteError, RefusedError, SceneGraphClient
from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene, register

pytestmark = pytest.mark.topics

SCENE = """
sources: [s]
frames:
- {name: ball, source: s, pose: {position: [0, 0, 0.048]}}
- {name: pad, source: s, pose: {position: [0.5, 0, 0]}}
- {name: bare, source: s, pose: {position: [5, 0, 5]}}
geometries:
- {name: table, source: s, shape: {type: half_space},
   roles: {proximity: {hydroelastic: {compliance_type: rigid}}}}
- {name: g, source: s, frame: ball, shape: {type: sphere, radius: 0.05},
   roles: {proximity: {hydroelastic: {compliance_type: compliant,
     hydroelastic_modulus: 1e6, resolution_hint: 0.01}}}}
- {name: g, source: s, frame: pad, shape: {type: box, size: [0.1, 0.1, 0.1]},
   roles: {proximity: {hydroelastic: {compliance_type: compliant, hydroelastic_modulus: 1e5}}}}
- {name: g, source: s, frame: bare, shape: {type: sphere, radius: 0.05}}
filters: [{exclude_between: [[world/table], [pad]]}]
"""
FRAMES = ('ball', 'pad', 'bare')
PLACES = [(0, 0, 0.048), (0.5, 0, 0), (5, 0, 5)]
ON_THE_PAD = [(0.5, 0, 0.09), (0.5, 0, 0), (5, 0, 5)]
NO_PROPERTIES = msg.ContactSurfaces.REASON_NO_PROPERTIES
TOO_DEEP = msg.ContactSurfaces.REASON_TOO_DEEP


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('contacts')
    (folder / 'scene.yaml').write_text(SCENE)
    process = start_node(
        folder / 'log', scene_file=folder / 'scene.yaml', publish_markers=True, marker_rate=20.0
    )
    yield process
    assert process.end() == 0, process.output()


@pytest.fixture
def publisher(client):
    return client.publisher(msg.FramePoses, 'frame_poses', 10)


def expected(places):
    """Return what a scene graph in this process answers."""
    scene_graph = SceneGraph()
    loaded = register(scene_graph, read_scene(SCENE, format='yaml'))
    context = scene_graph.CreateDefaultContext()
    frames = [loaded.frames['s', name] for name in FRAMES]
    context.UpdateFramePoses(
        FramePoseVector(
            {f: RigidTransform(list(map(float, p))) for f, p in zip(frames, places, strict=True)}
        )
    )
    query = scene_graph.get_query_output_port().Eval(context)
    surfaces, points = query.ComputeContactSurfacesWithFallback()
    return loaded, surfaces, points


def check(message, places):
    """Hold a message against the answer of this process, to the bit."""
    _, surfaces, points = expected(places)
    assert message.participants == 3
    assert len(message.id_a) == len(surfaces)
    for name, values in {
        'area': surfaces.areas,
        'p_wc': surfaces.centroids,
        'centre_of_pressure': surfaces.centres_of_pressure,
        'force_on_a_w': surfaces.forces_on_M_W,
        'torque_on_a_wo_w': surfaces.torques_on_M_Wo_W,
        'max_pressure': [each.polygon_arrays()[1].max() for each in surfaces],
        'faces': [each.num_faces() for each in surfaces],
    }.items():
        assert np.array_equal(np.ravel(getattr(message, name)), np.ravel(values)), name
    assert np.array_equal(message.point_pair_depth, [each.depth for each in points])
    return surfaces


def next_of(client, publisher, heard, places, stamp):
    """Publish poses until a result with their stamp comes."""

    def answered():
        publisher.publish(poses(FRAMES, places, 's', stamp=stamp))
        return [m for m in heard if m.header.stamp.sec == stamp]

    return client.wait_for(answered, 'a result of these poses')[-1]


def test_each_cycle_tells_the_surfaces_of_its_poses(client, publisher):
    heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    message = next_of(client, publisher, heard, PLACES, 1)
    surfaces = check(message, PLACES)
    assert len(surfaces) == 1
    assert message.header.frame_id == 'world'
    assert -surfaces.forces_on_M_W[0][2] > 1.0  # the table, M, is pressed down
    assert (message.has_polygons, list(message.p_wv), list(message.pressure)) == (False, [], [])
    check(next_of(client, publisher, heard, ON_THE_PAD, 2), ON_THE_PAD)
    apart = [(0, 0, 1), (2, 0, 0), (5, 0, 5)]
    message = next_of(client, publisher, heard, apart, 3)
    check(message, apart)
    assert (list(message.id_a), message.participants) == ([], 3)


def test_a_pair_that_overlaps_without_a_surface_is_told(client, publisher):
    heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    places = [(0.5, 0, 0.0), (0.5, 0, 0), (0.57, 0, 0.0)]
    message = next_of(client, publisher, heard, places, 11)
    check(message, places)
    # The ball is deep within the pad; the bare one overlaps the table, the ball and the pad.
    assert sorted(message.point_pair_reason) == [*[NO_PROPERTIES] * 3, TOO_DEEP]


def test_polygons_come_with_the_parameter(client, publisher):
    heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    value = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
    entry = Parameter(name='contact_polygons', value=value)
    assert client.call(SetParameters, 'set_parameters', parameters=[entry]).results[0].successful
    message = next_of(client, publisher, heard, PLACES, 21)
    surfaces = check(message, PLACES)
    points, pressures, ends = surfaces[0].polygon_arrays()
    assert message.has_polygons
    assert np.array_equal(np.reshape(message.p_wv, (-1, 3)), points)
    assert np.array_equal(message.pressure, pressures)
    assert np.array_equal(message.polygon_ends, ends)


def test_a_listener_is_what_it_takes(client, publisher):
    reports = client.listen(msg.CycleReport, 'cycle_report')
    heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    next_of(client, publisher, heard, PLACES, 31)

    # A cycle of the same poses may have run before anybody was known to listen.
    def ran():
        return [
            dict(zip(report.effects, report.effect_counts, strict=True))
            for report in reports
            if report.header.stamp.sec == 31
            and report.effect_ran[report.effects.index('contact surfaces')]
        ]

    counts = client.wait_for(ran, 'a report of surfaces')[-1]
    assert counts['contact surfaces'] == counts['publish ~/contact_surfaces'] == 1


def test_the_service_answers_what_if_and_refuses_pairs_without(client, publisher):
    ask = ('compute_contact_surfaces',)
    there = poses(['ball'], [(0.5, 0, 0.09)])
    answer = accepted(client.call(srv.ComputeContactSurfaces, *ask, poses=there, polygons=True))
    moved = [(0.5, 0, 0.09), PLACES[1], PLACES[2]]
    surfaces = check(answer.result, moved)
    assert len(answer.result.pressure) == len(surfaces[0].polygon_arrays()[0])
    deep = poses(['bare'], [(0.0, 0, 0.09)])
    told = refused(
        client.call(srv.ComputeContactSurfaces, *ask, poses=deep), 'no hydroelastic properties'
    )
    assert 'ComputeContactSurfacesWithFallback' in told
    answer = client.call(srv.ComputeContactSurfaces, *ask, poses=deep, with_fallback=True)
    check(accepted(answer).result, [PLACES[0], PLACES[1], (0.0, 0, 0.09)])
    # The live scene has not changed.
    check(accepted(client.call(srv.ComputeContactSurfaces, *ask)).result, PLACES)


def test_what_never_had_a_pose_is_told(client):
    text = 'sources: [late]\nframes: [{name: f, source: late}]\ngeometries: [{name: g, source: '
    text += 'late, frame: f, shape: {type: sphere, radius: 1}}]'
    accepted(client.call(srv.LoadScene, 'load_scene', text=text))
    try:
        answer = client.call(srv.ComputeContactSurfaces, 'compute_contact_surfaces')
        assert 'late::f' in accepted(answer).message
        assert list(answer.result.waiting_frames) == ['late::f']
        assert answer.result.waiting_pairs == 4
    finally:
        accepted(client.call(srv.RemoveSource, 'remove_source', source='late'))


def test_half_spaces_that_overlap_are_told_though_they_have_no_depth(client, publisher):
    text = 'sources: [p]\nframes: [{name: f, source: p, pose: {position: [0, 0, -50]}}]\n'
    text += 'geometries: [{name: g, source: p, frame: f, shape: {type: half_space}}]\n'
    accepted(client.call(srv.LoadScene, 'load_scene', text=text))
    try:
        ask = ('compute_contact_surfaces',)
        refused(client.call(srv.ComputeContactSurfaces, *ask), 'both are half spaces')
        answer = client.call(srv.ComputeContactSurfaces, *ask, with_fallback=True)
        heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
        message = next_of(client, publisher, heard, PLACES, 35)
        for found in (accepted(answer).result, message):
            assert list(found.point_pair_reason) == [msg.ContactSurfaces.REASON_HALF_SPACES]
            assert list(found.point_pair_depth) == [np.inf]
            assert np.isnan(found.point_pair_p_wca).all()
        with SceneGraphClient(patience=PATIENCE) as scene:
            (pair,) = scene.contact_surfaces(with_fallback=True).without_surface
            assert pair.reason == 'both are half spaces'
    finally:
        accepted(client.call(srv.RemoveSource, 'remove_source', source='p'))


def test_markers_are_coloured_by_pressure_and_vanish(client, publisher):
    heard = client.listen(MarkerArray, 'markers')

    def shown(action, places, stamp):
        publisher.publish(poses(FRAMES, places, 's', stamp=stamp))
        found = [m for each in heard for m in each.markers if m.ns == 'contact_surfaces']
        return [m for m in found[-1:] if m.action == action]

    (marker,) = client.wait_for(lambda: shown(Marker.ADD, PLACES, 41), 'a patch')
    assert marker.type == Marker.TRIANGLE_LIST
    assert len(marker.points) == len(marker.colors) == 3 * (len(marker.points) // 3) > 0
    assert {round(p.z, 6) for p in marker.points} == {0.0}
    reddest = max(range(len(marker.points)), key=lambda k: marker.colors[k].r)
    p = marker.points[reddest]
    assert np.hypot(p.x, p.y) < 0.003  # the pressure is largest in the middle
    away = [(0, 0, 1), *PLACES[1:]]
    client.wait_for(lambda: shown(Marker.DELETE, away, 42), 'the patch to vanish')


def test_the_client_gives_names_and_no_free_space(client, publisher):
    # A service does not wait for poses that were sent before: another topic, another order.
    next_of(client, publisher, client.listen(msg.ContactSurfaces, 'contact_surfaces'), PLACES, 51)
    with SceneGraphClient(patience=PATIENCE) as scene:
        found = scene.contact_surfaces({'s::ball': [0.5, 0, 0.09, 0, 0, 0, 1]}, polygons=True)
        (surface,) = found
        assert {surface.name_a, surface.name_b} == {'ball/g', 'pad/g'}
        _, surfaces, _ = expected(ON_THE_PAD)
        assert surface.area == surfaces.areas[0]
        assert surface.force_on_A_W.tolist() == surfaces.forces_on_M_W[0].tolist()
        polygons = found.polygons(0)
        assert len(polygons) == surfaces[0].num_faces()
        assert sum(len(p) for p, _ in polygons) == len(surfaces[0].polygon_arrays()[0])
        assert len(found.between('ball', 'pad')) == 1
        assert not found.between('ball', 'bare')
        over = {'s::bare': [0.0, 0, 0.09, 0, 0, 0, 1]}
        with pytest.raises(RefusedError, match='no hydroelastic properties'):
            scene.contact_surfaces(over)
        found = scene.contact_surfaces(over, with_fallback=True)
        (other,) = found.without_surface
        assert (other.reason, {other.name_a, other.name_b}) == (
            'one has no hydroelastic properties',
            {'ball/g', 'bare/g'},
        )
        with pytest.raises(IncompleteError, match='no surface, and yet pairs overlap'):
            bool(found.between('ball', 'bare'))
        with pytest.raises(RuntimeError, match='ask with polygons=True'):
            found.polygons(0)
        heard = []
        scene.listener.on_contact_surfaces(heard.append)

        def came():
            publisher.publish(poses(FRAMES, PLACES, 's', stamp=52))
            return heard

        (table,) = scene.wait_for(came, 'a message')[0].between('ball')
        assert table.name_b == 'ball/g'


def test_diagnostics_and_empty_scenes(client, publisher):
    """The last test of this node: its scene goes."""
    heard = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    accepted(client.call(srv.RemoveSource, 'remove_source', source='s'))
    text = (
        'sources: [s]\nframes: [{name: f, source: s, pose: {}}]\ngeometries: [{name: g, source: '
    )
    text += 's, frame: f, shape: {type: sphere, radius: 1}}]'
    accepted(client.call(srv.LoadScene, 'load_scene', text=text))

    def answered():
        publisher.publish(poses(['f'], [(0, 0, 0)], 's', stamp=61))
        return [m for m in heard if m.header.stamp.sec == 61]

    message = client.wait_for(answered, 'a message')[-1]
    assert (message.participants, list(message.id_a)) == (0, [])
    answer = client.call(srv.ComputeContactSurfaces, 'compute_contact_surfaces')
    refused(answer, 'no geometry has hydroelastic properties')
    with (
        SceneGraphClient(patience=PATIENCE) as scene,
        pytest.raises(RefusedError, match='no geometry has'),
    ):
        scene.contact_surfaces()
