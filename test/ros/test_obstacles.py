"""Sensed maps in a real node: what cameras see keeps robots away, and is never free by default."""

import array
import math
import os
import re
import signal
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.harness import LATCHED, start_node
from ros.scene_calls import accepted, refused
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

from drake_geom_ros.sensed_maps import read_map

pytestmark = pytest.mark.topics

SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: mast, source: s, pose: {position: [0, 0, 2]}, static: true}
geometries:
- {name: hand, source: s, frame: arm, shape: {type: sphere, radius: 0.1}}
- {name: post, source: s, shape: {type: box, size: [0.1, 0.1, 1]}, pose: {position: [3, 0, 0]}}
"""
SETTINGS = {
    'obstacles': '[points,depth]', 'max_distance': 2.0, 'obstacle_resolution': 0.1,
    'obstacle_self_filter': 'scene', 'stale_after': 1.0,
}  # fmt: skip


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('obstacles')
    (folder / 'scene.yaml').write_text(SCENE)
    log, scene = folder / 'log', folder / 'scene.yaml'
    process = start_node(log, scene_file=scene, mesh_roots=f'[{folder}]', **SETTINGS)
    process.folder = folder
    yield process
    process.end()


class Cell:
    """Sends poses of the arm and clouds, and listens."""

    def __init__(self, client):
        self.client = client
        self.clouds = client.publisher(PointCloud2, 'obstacles/points')
        self.poses = client.publisher(msg.FramePoses, 'frame_poses')
        self.results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        self.reports = client.listen(msg.CycleReport, 'cycle_report')
        self.diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        self.names = client.listen(msg.Scene, 'scene', LATCHED)
        self.client.wait_for(lambda: self.names, 'the scene')

    def now(self):
        return self.client.node.get_clock().now().to_msg()

    def pose(self, x, y, z):
        row = [float(x), float(y), float(z), 0.0, 0.0, 0.0, 1.0]
        header = Header(stamp=self.now())
        self.poses.publish(msg.FramePoses(header=header, frame_names=['s::arm'], poses=row))

    def cloud(self, points, frame='s::mast', stamp=None, **changes):
        rows = np.asarray(points, dtype='<f4').reshape(-1, 3)
        told = {
            'header': Header(frame_id=frame, stamp=stamp or self.now()),
            'width': len(rows), 'height': 1, 'point_step': 12, 'row_step': 12 * len(rows),
            'fields': [PointField(name=n, offset=4 * k, datatype=7, count=1)
                       for k, n in enumerate('xyz')],
            'data': array.array('B', rows.tobytes()),
        }  # fmt: skip
        self.clouds.publish(PointCloud2(**{**told, **changes}))

    def distance(self):
        """Return the distance of the newest result that is to a map; None: there is none."""
        maps = {g.id for g in self.names[-1].geometries if g.shape.type == 10}
        if not self.results:
            return None
        last = self.results[-1]
        found = [
            d
            for a, b, d in zip(last.id_a, last.id_b, last.distance, strict=True)
            if a in maps or b in maps
        ]
        return min(found) if found else None

    def waits(self):
        """Clear the maps, for what was sent before may still be taken; return whether all wait."""
        accepted(self.client.call(srv.ClearObstacles, 'clear_obstacles'))
        return self.results and self.results[-1].waiting_pairs == 2

    def map_ages(self):
        last = self.reports[-1]
        return dict(zip(last.maps, last.map_ages, strict=True))

    def told(self):
        """Return what diagnostics say now, as one text."""
        if not self.diagnostics:
            return ''
        status = self.diagnostics[-1].status[0]
        return status.message + ' '.join(f'{v.key}={v.value}' for v in status.values)

    def until(self, fact, what, *, points=None, position=(0.0, 0.0, 1.0)):
        """Send poses, and a cloud, again and again until a fact holds."""

        def holds():
            self.pose(*position)
            if points is not None:
                self.cloud(points)
            self.client.spin_until(time.monotonic() + 0.05)
            return fact()

        return self.client.wait_for(holds, what)


@pytest.fixture
def cell(client):
    cell = Cell(client)
    cell.until(cell.waits, 'maps that wait, as at first')
    return cell


def test_what_never_came_waits_then_counts_then_grows_old(cell):
    cell.until(lambda: cell.results and cell.results[-1].waiting_pairs == 2, 'two maps that wait')
    assert set(cell.results[-1].waiting_frames) == {'obstacles::points', 'obstacles::depth'}
    assert cell.distance() is None
    cell.until(lambda: 'no message of ~/obstacles/points' in cell.told(), 'diagnostics')
    assert cell.map_ages() == {'points': math.inf, 'depth': math.inf}
    points = [[0.55, 0.05, -0.95], [math.nan, 0.0, 0.0], [0.0, 0.0, -1.0]]
    cell.until(lambda: cell.distance() is not None, 'a distance to what was seen', points=points)
    # The cell from 0.5 to 0.6, the hand at (0, 0, 1) of radius 0.1; a point on it left out.
    assert cell.distance() == pytest.approx(0.4, abs=1e-6)
    assert cell.results[-1].waiting_pairs == 1
    cell.until(lambda: '1 not finite' in cell.told() and '1 on bodies' in cell.told(), 'counts')
    # Poses come, and clouds no more: the map is the oldest, and named.
    cell.until(lambda: cell.map_ages()['points'] > 1.2, 'an old map')
    waiting = set(cell.results[-1].waiting_frames)
    assert waiting == {'obstacles::depth'}
    cell.until(lambda: 'obstacles::points' in cell.told(), 'diagnostics that name the stale map')
    assert cell.distance() == pytest.approx(0.4, abs=1e-6)  # and it still stands there


def test_two_publishers_of_one_topic_have_a_map_each_and_the_older_one_counts(cell):
    near, far = cell.clouds, cell.client.publisher(PointCloud2, 'obstacles/points')

    def send(clouds, x):
        cell.clouds = clouds
        cell.cloud([[x, 0.05, -0.95]])
        cell.client.spin_until(time.monotonic() + 0.05)

    def both_feed():
        send(near, 0.55)
        send(far, 0.75)
        return '2 sensors feed ~/obstacles/points' in cell.told()

    def one_is_old():
        send(far, 0.75)
        return cell.map_ages()['points'] > 1.2

    cell.until(both_feed, 'a trouble about two sensors')
    cell.until(one_is_old, 'a map as old as what the first one showed')
    assert cell.distance() == pytest.approx(0.4, abs=1e-6)  # of what the first one showed
    sensors, ages = cell.reports[-1].map_sensors, cell.reports[-1].map_sensor_ages
    assert len(sensors) == len(ages) == 2
    assert all(name.startswith("points: frame 's::mast', publisher ") for name in sensors)
    assert min(ages) < max(ages)
    assert max(ages) >= cell.map_ages()['points'] > 1.2  # which was looked up before


def test_a_stop_rule_is_entered_by_what_is_seen_and_by_a_map_that_is_old(cell):
    events = cell.client.listen(msg.ProximityEvents, 'proximity_events')
    rule = msg.ProximityRule(
        name='keep away', set_a=['s::arm'], set_b=['obstacles::points'], level=3, enter=0.3,
        leave=0.35,
    )  # fmt: skip
    accepted(cell.client.call(srv.AddProximityRule, 'add_proximity_rule', rule=rule))
    try:

        def whys():
            return [(w, e) for each in events for w, e in zip(each.why, each.entered, strict=True)]

        no_pose, near, stale = 4, 1, 3
        cell.until(lambda: (no_pose, True) in whys(), 'an event for a map that never came')
        far, close = [[1.5, 0.0, -1.0]], [[0.25, 0.0, -1.0]]

        def entered_by_what_is_near():  # or, on a busy machine, by the age of the map before
            cell.until(lambda: whys()[-1][1] is False, 'that it is left', points=far)
            cell.until(lambda: whys()[-1][1], 'that it is entered', points=close)
            return whys()[-1] == (near, True)

        cell.client.wait_for(entered_by_what_is_near, 'that what is near enters it')
        cell.until(lambda: whys()[-1][1] is False, 'that it is left again', points=far)
        cell.until(lambda: whys()[-1] == (stale, True), 'that an old map enters it')
    finally:
        cell.client.call(srv.RemoveProximityRule, 'remove_proximity_rule', name='keep away')


def test_hostile_clouds_are_refused_whole_and_the_map_stays(cell):
    good = [[0.55, 0.05, -0.95]]
    cell.until(lambda: cell.distance() is not None, 'a map', points=good)
    stamp = cell.now()
    stamp.sec += 100
    hostile = [
        ({'width': 10**9, 'row_step': 2**31}, 'at most'),
        ({'width': 10**6, 'row_step': 12 * 10**6}, 'do not fit'),
        ({'fields': []}, 'lacks x, y, z'),
        ({'frame': 'moon'}, 'moon'),
        ({'stamp': stamp}, 'from the future'),
        ({'points': [[math.nan] * 3] * 5}, 'none of its 5 points is finite'),
        ({'point_step': 0}, 'point_step'),
    ]
    for changes, reason in hostile:
        told = {'points': good, **changes}

        def refuses(told=told, reason=reason):
            cell.cloud(**told)
            return reason in cell.told()

        cell.until(refuses, f'a refusal: {reason}')
    cell.until(lambda: cell.distance() == pytest.approx(0.4, abs=1e-6), 'the old map')
    refusals = [v for v in cell.diagnostics[-1].status[0].values if 'obstacles/points' in v.key]
    assert refusals


def test_a_depth_image_shows_the_same_as_its_points(cell):
    infos = cell.client.publisher(CameraInfo, 'obstacles/depth/camera_info')
    images = cell.client.publisher(Image, 'obstacles/depth/image_rect_raw')
    depth = np.zeros((3, 3), dtype='<u2')
    depth[1, 1] = 950  # mm, straight ahead of the mast, which looks up
    info = CameraInfo(width=3, height=3, k=[50.0, 0.0, 1.0, 0.0, 50.0, 1.0, 0.0, 0.0, 1.0])

    def sent():
        header = Header(frame_id='s::mast', stamp=cell.now())
        info.header = header
        infos.publish(info)
        images.publish(
            Image(header=header, width=3, height=3, encoding='16UC1', step=6,
                  data=array.array('B', depth.tobytes()))
        )  # fmt: skip
        return cell.distance() is not None

    cell.until(sent, 'a map of the image')
    # From z 2.9 to 3.0 above the hand, whose top is at 1.1.
    assert cell.distance() == pytest.approx(2.9 - 1.1, abs=1e-6)


def test_maps_are_saved_loaded_and_cleared(cell, node):
    call = cell.client.call
    folder = node.folder
    points = [[0.55, 0.05, -0.95], [0.55, 0.25, -0.95]]
    near = pytest.approx(0.4, abs=1e-6)
    cell.until(lambda: cell.distance() == near, 'a map', points=points)
    accepted(call(srv.ClearObstacles, 'clear_obstacles', map='depth'))
    saved = accepted(call(srv.SaveObstacles, 'save_obstacles', path=str(folder / 'seen.bt')))
    assert saved.cells == 2
    centres = np.round(read_map(folder / 'seen.bt').points, 6).tolist()
    assert sorted(centres) == [[0.55, 0.05, 1.05], [0.55, 0.25, 1.05]]
    again = {'path': str(folder / 'seen.bt'), 'map': 'points'}
    accepted(call(srv.SaveObstacles, 'save_obstacles', **again))
    refused(call(srv.SaveObstacles, 'save_obstacles', path='/etc/seen.bt'), 'mesh_roots')
    refused(call(srv.SaveObstacles, 'save_obstacles', path=str(folder / 'a.pcd')), '.bt')
    refused(call(srv.SaveObstacles, 'save_obstacles', **{**again, 'map': 'depth'}), 'wait')
    (folder / 'other.bt').write_bytes(b'# Octomap OcTree binary file\n')
    other = str(folder / 'other.bt')
    refused(call(srv.SaveObstacles, 'save_obstacles', path=other), 'not written by save_obstacles')

    assert accepted(call(srv.ClearObstacles, 'clear_obstacles')).cells == 2
    cell.until(cell.waits, 'that both wait again')
    loaded = accepted(call(srv.LoadObstacles, 'load_obstacles', path=str(folder / 'seen.bt')))
    assert loaded.cells == 2
    cell.until(lambda: cell.distance() == near, 'the loaded map')
    cell.until(lambda: cell.map_ages()['points'] < 1.0, 'a map of now', points=points)
    cell.until(lambda: cell.map_ages()['points'] > 1.2, 'that it is old')
    assert cell.map_ages()['file'] == 0.0, 'a map of a file does not age'
    refused(call(srv.LoadObstacles, 'load_obstacles', path=str(folder / 'none.bt')), 'no file')
    refused(call(srv.LoadObstacles, 'load_obstacles', path=str(folder / 'scene.yaml')), '.bt')
    refused(call(srv.ClearObstacles, 'clear_obstacles', map='moon'), 'points')
    assert accepted(call(srv.ClearObstacles, 'clear_obstacles', map='file')).cells == 2
    # What was seen is no model: it is in no scene file.
    text = accepted(call(srv.SaveScene, 'save_scene')).text
    assert 'obstacles' not in text


@pytest.fixture
def keeping(client):
    def keep(seconds):
        value = ParameterValue(type=3, double_value=seconds)
        entry = Parameter(name='obstacle_keep', value=value)
        call = client.call(SetParameters, 'set_parameters', parameters=[entry])
        assert call.results[0].successful

    keep(1000.0)
    yield
    keep(0.0)


STARTS = re.compile(r'process (\d+), \d+ MB of its own, (\d+) were started')


def test_cells_are_held_though_the_process_of_sensors_ends(cell, keeping):
    near = pytest.approx(0.4, abs=1e-6)
    cell.until(lambda: cell.distance() == near, 'a map', points=[[0.55, 0.05, -0.95]])
    cell.until(lambda: 'process of sensors' in cell.told(), 'diagnostics')
    pid, before = map(int, STARTS.search(cell.told()).groups())
    os.kill(pid, signal.SIGKILL)
    elsewhere = [[0.05, 2.05, -0.95]]  # where the first cell is nobody looks any more

    def is_taken():
        found = STARTS.search(cell.told())
        return found is not None and int(found[2]) > before and '2 cells' in cell.told()

    cell.until(is_taken, 'another process, and what both saw', points=elsewhere)
    cell.until(lambda: cell.map_ages()['points'] < 1.0, 'a new map', points=elsewhere)
    assert cell.distance() == near


def test_a_covered_lens_does_not_blind_an_input_when_bodies_changed(cell):
    call = cell.client.call
    nothing, something = [[math.nan] * 3] * 7, [[0.55, 0.05, -0.95]]
    cell.until(lambda: cell.distance() is not None, 'a map', points=something)
    # Of all that was sent the last one is taken, or refused: the map grows old.
    cell.until(lambda: cell.map_ages()['points'] > 0.5, 'an old map')
    post, ball = 's::world/post', msg.Shape(type=1, dimensions=[1.5])
    accepted(call(srv.ChangeShape, 'change_shape', geometry=post, shape=ball))
    try:
        cell.until(lambda: 'none of its 7' in cell.told(), 'its refusal', points=nothing)
        cell.until(lambda: cell.map_ages()['points'] > 1.2, 'an old map', points=nothing)
        cell.until(lambda: cell.map_ages()['points'] < 1.0, 'a new map', points=something)
    finally:
        box = msg.Shape(type=2, dimensions=[0.1, 0.1, 1.0])
        accepted(call(srv.ChangeShape, 'change_shape', geometry=post, shape=box))


def test_a_process_of_sensors_that_is_killed_is_told_of_and_replaced(cell, node):
    near = pytest.approx(0.4, abs=1e-6)
    points = [[0.55, 0.05, -0.95], [0.0, 0.0, -1.0]]  # the second one on the hand
    cell.until(lambda: cell.distance() == near, 'a map', points=points)
    cell.until(lambda: 'process of sensors' in cell.told(), 'diagnostics')
    pid, before = map(int, STARTS.search(cell.told()).groups())
    os.kill(pid, signal.SIGKILL)
    cell.until(lambda: 'ended by SIGKILL' in node.output(), 'that it is told')
    assert cell.distance() == near  # the map of before stays, and grows old
    cell.until(lambda: cell.map_ages()['points'] > 1.2, 'an old map')

    def is_replaced():
        found = STARTS.search(cell.told())
        return found is not None and int(found[2]) > before

    cell.until(is_replaced, 'another process')
    cell.until(lambda: cell.map_ages()['points'] < 1.0, 'a new map', points=points)
    cell.until(lambda: '1 on bodies' in cell.told(), 'that it knows the bodies')
    assert cell.distance() == near
