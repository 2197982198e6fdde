"""The page of a running node: on the real middleware, before the node, with it, after its end."""

import threading

import numpy as np
import pytest
from drake_geom_msgs.msg import FramePoses, GeometryPoses, Stopping
from live.scene.test_scene_stopping import ROD
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.harness import SENSOR, start_node
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import Header
from viewing.scenes import PRESSING, local_scene

from drake_geom_ros.geometry import GeometryError, Role
from drake_geom_ros.proximity_rules import Level
from drake_geom_ros.ros.viewer.node_scene import NodeScene
from drake_geom_ros.ros.viewer.node_tables import stopping_table
from drake_geom_ros.viewing.looks import PALETTE
from drake_geom_ros.viewing.rules import rows_of_level
from drake_geom_ros.viewing.tables import TextTable

pytestmark = pytest.mark.topics

NO_TABLE = TextTable('', (), ())

SCENE = """
sources: [s]
frames: [{name: a, source: s, pose: {position: [1, 0, 0], rpy: [0.1, 0.2, 0.3]}}]
geometries:
- {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
- {name: post, source: s, shape: {type: sphere, radius: 0.2}}
- {name: ball, source: s, frame: a, shape: {type: capsule, radius: 0.1, length: 0.3},
   roles: {proximity: {}, illustration: {phong: {diffuse: {rgba: [1, 0, 0, 1]}}}}}
"""


@pytest.fixture(scope='module')
def scene_file(tmp_path_factory):
    path = tmp_path_factory.mktemp('scene') / 'scene.yaml'
    path.write_text(SCENE)
    return path


@pytest.fixture
def shown(lone_client):
    return NodeScene(lone_client.node)


def wait_for_pairs(client, shown, count, reach=2.0, accuracy='exact'):
    def found():
        moment = shown.moment(reach, accuracy)
        return moment if len(moment.pairs) == count else None

    return client.wait_for(found, f'{count} pairs')


def ask_in_a_thread(client, question):
    """Return what a call gives that waits while the test's thread spins."""
    answers = []

    def ask():
        try:
            answers.append(question())
        except GeometryError as error:
            answers.append(error)

    threading.Thread(target=ask).start()
    return client.wait_for(lambda: answers, 'an answer')[0]


def test_a_node_is_waited_for_shown_and_met_again(lone_client, shown, scene_file, tmp_path):
    moment = shown.moment(1.0, 'exact')
    assert list(moment.remarks) == ['waiting for /scene_graph/scene']
    assert len(moment.pairs) == len(moment.geometries.ids) == 0

    for attempt in range(2):  # the second is a node that starts anew
        node = start_node(tmp_path / f'log{attempt}', scene_file=scene_file, max_distance=0.5)
        try:
            # Farther than the node's topic goes: by its service.
            moment = wait_for_pairs(lone_client, shown, 2)
            names = moment.geometries.names
            assert sorted(names.values()) == ['s::a/ball', 's::world/floor', 's::world/post']
            gaps = moment.pairs.p_WCas - moment.pairs.p_WCbs
            np.testing.assert_allclose(
                gaps, moment.pairs.distance[:, None] * moment.pairs.nhat_BA_Ws, rtol=0, atol=1e-9
            )
            assert moment.remarks[0].startswith('poses of /scene_graph ')
            looks = {(look.name, look.role): look for look in moment.geometries.looks}
            assert looks['s::a/ball', Role.kIllustration].colour == (1.0, 0.0, 0.0, 1.0)
            assert looks['s::world/post', Role.kProximity].colour[:3] == PALETTE[0]
        finally:
            node.end()

    assert isinstance(ask_in_a_thread(lone_client, lambda: shown.explain((1, 2))), GeometryError)
    lone_client.wait_for(
        lambda: any('nothing comes' in each for each in shown.moment(0.1, 'exact').remarks),
        'the remark that nothing comes',
    )


def test_poses_results_and_reasons_are_those_of_the_node(lone_client, shown, scene_file, tmp_path):
    node = start_node(tmp_path / 'log', scene_file=scene_file, max_distance=5.0)
    try:
        wait_for_pairs(lone_client, shown, 2, reach=4.0, accuracy='bound')
        poses = lone_client.publisher(FramePoses, 'frame_poses', SENSOR)
        before = shown.version()

        def least():
            poses.publish(FramePoses(frame_names=['a'], poses=[0.5, 0, 0, 0, 0, 0, 1]))
            pairs = shown.moment(1.0, 'exact').pairs
            return len(pairs) and abs(pairs.distance.min() - 0.2) < 1e-9

        lone_client.wait_for(least, 'the distance of the moved ball')
        assert shown.version() != before
        names = shown.moment(1.0, 'exact').geometries.names
        ids = {name: value for value, name in names.items()}
        pair = ids['s::world/floor'], ids['s::world/post']
        assert ask_in_a_thread(lone_client, lambda: shown.explain(pair)) == ['anchored']
        pair = ids['s::a/ball'], ids['s::world/post']
        assert ask_in_a_thread(lone_client, lambda: shown.explain(pair)) == []
    finally:
        node.end()


def test_rules_are_listed_with_their_state_and_the_pair_that_they_are_entered_by(
    lone_client, shown, tmp_path
):
    path = tmp_path / 'scene.yaml'
    path.write_text(
        f'{SCENE}proximity_rules:\n'
        '- {name: near, set_a: a, set_b: post, level: slow, enter: 0.3, leave: 0.4}\n'
        '- {name: far, set_a: a, level: stop, enter: 0.1, leave: 0.2, when_stale: keep}\n'
    )
    node = start_node(tmp_path / 'log', scene_file=path, max_distance=5.0)
    try:
        poses = lone_client.publisher(FramePoses, 'frame_poses', SENSOR)

        def entered():
            poses.publish(FramePoses(frame_names=['a'], poses=[0.5, 0, 0, 0, 0, 0, 1]))
            moment = shown.moment(1.0, 'exact')
            rows = rows_of_level(moment.rules, moment.pairs, Level.SLOW)
            # Events may come before the distances that they are founded on.
            there = [row for row in rows if abs(moment.pairs.distance[row] - 0.2) < 1e-9]
            return moment if there else None

        moment = lone_client.wait_for(entered, 'a rule that is entered, and its pair')
        near, far = moment.rules
        assert near.in_words() == 'near: slow, entered, near'
        assert far.in_words() == 'far: stop, not entered'
        names = moment.geometries.names
        assert {names[value] for value in near.pair} == {'s::a/ball', 's::world/post'}
        (row,) = rows_of_level(moment.rules, moment.pairs, Level.SLOW)
        assert moment.pairs.distance[row] == pytest.approx(0.2)
        assert rows_of_level(moment.rules, moment.pairs, Level.STOP) == []
    finally:
        node.end()


def tables_of(shown):
    return {table.title.partition(',')[0]: table for table in shown.moment(1.0, 'exact').tables}


def test_ages_events_and_sensors_are_tables(lone_client, shown, tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(
        f'{SCENE}proximity_rules:\n'
        '- {name: near, set_a: a, set_b: post, level: stop, enter: 0.3, leave: 0.4}\n'
        'obstacle_sources:\n'
        '  front: {type: laser_scan, topic: /front/scan, frame: world, resolution: 0.1,'
        ' timeout: 0.5}\n'
    )
    node = start_node(tmp_path / 'log', scene_file=path, max_distance=5.0)
    try:
        poses = lone_client.publisher(FramePoses, 'frame_poses', SENSOR)

        def told(x, wanted):
            poses.publish(FramePoses(frame_names=['a'], poses=[x, 0, 0, 0, 0, 0, 1]))
            rows = tables_of(shown).get('Events')
            return rows is not None and any(row.cells[1:3] == wanted for row in rows.rows)

        lone_client.wait_for(lambda: shown.moment(1.0, 'exact').geometries.names, 'the scene')
        lone_client.wait_for(lambda: told(0.5, ('near', 'stop entered')), 'the stop')
        entered = next(r for r in tables_of(shown)['Events'].rows if r.cells[2] == 'stop entered')
        assert entered.warns
        assert entered.cells[3] == 'near'
        assert set(entered.cells[4].split(' | ')) == {'s::a/ball', 's::world/post'}
        names = shown.moment(1.0, 'exact').geometries.names
        assert {names[value] for value in entered.pair} == {'s::a/ball', 's::world/post'}
        lone_client.wait_for(lambda: told(2.0, ('near', 'stop left')), 'that it was left')
        lone_client.wait_for(lambda: 'Sensors' in tables_of(shown), 'the sensors')
        (sensor,) = tables_of(shown)['Sensors'].rows
        assert tuple(sensor.cells) == ('front', '/front/scan', '0', 'never heard of')
        assert sensor.warns
        ages = 'Ages of poses'
        lone_client.wait_for(
            lambda: 's::a' in [r.cells[0] for r in tables_of(shown).get(ages, NO_TABLE).rows],
            'the age of the frame',
        )
        body = shown.body(next(value for value, name in names.items() if name == 's::a/ball'))
        assert dict(body.rows())['shape'] == 'capsule'
        assert set(body.roles) == {Role.kProximity, Role.kIllustration}
    finally:
        node.end()
    lone_client.wait_for(lambda: 'Sensors' not in tables_of(shown), 'that old ages are not shown')


def test_stopping_is_a_table():
    message = Stopping(
        rules=['brake', 'lost'], clear=[True, False], scale=[1.0, 0.0],
        stopping_time=[0.25, 0.5], stopping_distance=[0.125, np.inf],
        least_clearance=[0.0625, -1.0],
        geometry_a=['s::a/ball', ''], geometry_b=['s::world/post', ''], id_a=[7, 0], id_b=[9, 0],
        trouble=['', 'no joint speeds'],
    )  # fmt: skip
    brake, lost = stopping_table(message).rows
    assert tuple(brake.cells) == (
        *('brake', 'yes', '0.250 s', '125.0 mm', '62.5 mm', 's::a/ball | s::world/post'),
    )
    assert (brake.warns, brake.pair) == (False, (7, 9))
    assert lost.cells[1] == 'NOT PROVED: no joint speeds'
    assert lost.cells[3] == 'farther than asked'
    assert (lost.warns, lost.pair) == (True, None)


def test_the_topic_is_silent_without_a_listener_and_flat_with_one(
    lone_client, scene_file, tmp_path
):
    node = start_node(tmp_path / 'log', scene_file=scene_file)
    try:
        heard = lone_client.listen(GeometryPoses, 'geometry_poses')
        message = lone_client.wait_for(lambda: heard, 'poses')[0]
        assert len(message.poses) == 7 * len(message.ids) == 21
    finally:
        node.end()


def test_a_robot_that_brakes_has_ghosts(lone_client, shown, tmp_path):
    (tmp_path / 'rod.urdf').write_text(ROD)
    path = tmp_path / 'scene.yaml'
    path.write_text(f"""
robots: [{{name: rod, urdf: {tmp_path / 'rod.urdf'}, pose: {{}}}}]
geometries: [{{name: post, pose: {{position: [9, 0, 0]}}, shape: {{type: sphere, radius: 0.1}}}}]
proximity_rules: [{{name: stop, set_a: rod, level: stoppable, decelerations: 2.0}}]
""")
    node = start_node(tmp_path / 'log', scene_file=path, use_joint_states=True)
    publisher = lone_client.node.create_publisher(JointState, 'joint_states', 10)

    def ghosts(speed):
        message = JointState(name=['turn'], position=[0.3], velocity=[speed])
        message.header.stamp = lone_client.node.get_clock().now().to_msg()
        publisher.publish(message)
        return shown.moment(1.0, 'exact').ghosts

    try:
        four = lone_client.wait_for(lambda: len(g := ghosts(1.0)) == 4 and g, 'ghosts')
        names = shown.moment(1.0, 'exact').geometries.names
        assert {names[int(value)] for ghost in four for value in ghost.ids} == {
            'rod::rod/collision_0'
        }
        angles = [np.arctan2(ghost.p_WGs[0, 1], ghost.p_WGs[0, 0]) for ghost in four]
        travel = (angles[3] - 0.3) / 4.0
        assert travel > 0.25 / 4.0  # 1 rad/s, at 2 rad/s^2
        np.testing.assert_allclose(np.diff([0.3, *angles]), travel, rtol=1e-9)
        lone_client.wait_for(lambda: not ghosts(0.0), 'no ghosts of a robot that stands')
    finally:
        node.end()


def test_what_the_pairs_leave_out_is_said(lone_client, shown, tmp_path):
    path = tmp_path / 'scene.yaml'
    never_posed = (
        SCENE + '- {name: lost, source: s, frame: b, shape: {type: sphere, radius: 0.1}}\n'
    )
    path.write_text(never_posed.replace('frames: [', 'frames: [{name: b, source: s}, '))
    node = start_node(tmp_path / 'log', scene_file=path, max_distance=5.0)
    try:
        told = 'NOT COMPLETE: 3 pairs left out, as frames never had a pose: s::b'
        lone_client.wait_for(lambda: told in shown.moment(1.0, 'exact').remarks, told)
    finally:
        node.end()


def test_two_nodes_of_one_name_are_a_warning(lone_client, shown, scene_file, tmp_path):
    nodes = [start_node(tmp_path / 'log0', scene_file=scene_file)]
    try:
        lone_client.wait_for(lambda: shown.moment(1.0, 'exact').geometries.names, 'the scene')
        assert not shown.moment(1.0, 'exact').remarks[0].startswith('NOT')
        nodes.append(start_node(tmp_path / 'log1', scene_file=scene_file))
        warning = 'NOT ONE SCENE: 2 publishers send /scene_graph/scene'
        lone_client.wait_for(
            lambda: shown.moment(1.0, 'exact').remarks[0].startswith(warning), warning
        )
        assert '/scene_graph and /scene_graph' in shown.moment(1.0, 'exact').remarks[0]
        nodes.pop().end()
        lone_client.wait_for(
            lambda: not shown.moment(1.0, 'exact').remarks[0].startswith('NOT'), 'one node again'
        )
    finally:
        for node in nodes:
            node.end()


def test_contact_surfaces_are_asked_for_while_they_are_wished_for(tmp_path, lone_client, shown):
    missing = shown.moment(0.1, 'exact', contacts=True)
    assert 'no contact surfaces: nobody serves /scene_graph/compute_contact_surfaces' in (
        missing.remarks
    )
    path = tmp_path / 'pressing.yaml'
    path.write_text(PRESSING)
    node = start_node(tmp_path / 'log', scene_file=path)
    try:

        def found():
            moment = shown.moment(0.1, 'exact', contacts=True)
            return moment if len(moment.patches) else None

        moment = lone_client.wait_for(found, 'contact surfaces')
        expected = local_scene(PRESSING).moment(0.1, 'exact', contacts=True)
        np.testing.assert_array_equal(moment.patches.pressures, expected.patches.pressures)
        np.testing.assert_array_equal(moment.patches.triangles, expected.patches.triangles)
        assert set(expected.remarks) <= set(moment.remarks)
        assert len(shown.moment(0.1, 'exact').patches) == 0
    finally:
        node.end()


def test_layers_of_sensed_maps_are_those_of_the_markers(lone_client, shown, tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(
        f'{SCENE}obstacle_sources:\n'
        '  front: {type: laser_scan, topic: /front/scan, frame: world, resolution: 0.1}\n'
    )
    node = start_node(tmp_path / 'log', scene_file=path)
    try:
        scans = lone_client.node.create_publisher(LaserScan, '/front/scan', 10)

        def layer():
            stamp = lone_client.node.get_clock().now().to_msg()
            scans.publish(
                LaserScan(
                    header=Header(stamp=stamp), range_min=0.1, range_max=10.0,
                    angle_increment=0.5, ranges=[1.02, 2.04],
                )
            )  # fmt: skip
            layers = {layer.key: layer for layer in shown.moment(0.1, 'exact').cells}
            return layers.get(('front', 'obstacles'))

        lone_client.wait_for(
            lambda: any(
                'set publish_markers' in each for each in shown.moment(0.1, 'exact').remarks
            ),
            'the remark that markers are needed',
        )
        true = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
        chosen = [Parameter(name='publish_markers', value=true)]
        lone_client.call(SetParameters, 'set_parameters', parameters=chosen)
        cells = lone_client.wait_for(layer, 'the cells of the scan')
        centres = sorted(np.round(cells.centres, 6).tolist())
        assert centres == [[1.05, 0.05, 0.05], [1.75, 0.95, 0.05]]
        assert cells.edge == pytest.approx(0.1)
        looks = shown.moment(0.1, 'exact').geometries.looks
        assert not any(look.name.startswith('obstacles::') for look in looks)
    finally:
        node.end()
