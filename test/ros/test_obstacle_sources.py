"""Several sensors in a real node: each has a map, an age and a timeout of its own."""

import array
import math
import time

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED, start_node
from ros.scene_calls import accepted, refused
from sensor_msgs.msg import LaserScan, Range
from std_msgs.msg import Header

pytestmark = pytest.mark.topics

SCENE = """
sources: [base]
frames: [{name: body, source: base, pose: {position: [0, 0, 0.2]}}]
geometries:
- {name: hull, source: base, frame: body, shape: {type: box, size: [0.4, 0.4, 0.2]}}
obstacle_sources:
  front: {type: laser_scan, topic: /scanned/front, frame: body, extrude: [0, 1], timeout: 2}
  rear: {type: laser_scan, topic: /scanned/rear, frame: body, timeout: 2}
  spare: {type: laser_scan, topic: /scanned/spare, frame: body, required: false}
proximity_rules:
- {name: near, set_a: base, set_b: obstacles, level: stop, enter: 0.1, leave: 0.2}
"""
RAYS = 9
FAR = [4.0] * RAYS


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('sources')
    (folder / 'scene.yaml').write_text(SCENE)
    settings = {'max_distance': 6.0, 'obstacle_reach': 6.0, 'obstacle_self_filter': 'scene'}
    process = start_node(folder / 'log', scene_file=folder / 'scene.yaml', **settings)
    yield process
    process.end()


class Base:
    """Sends the pose of a base and its scans, and listens."""

    def __init__(self, client):
        self.client = client
        self.poses = client.publisher(msg.FramePoses, 'frame_poses')
        self.scans = {
            name: client.node.create_publisher(LaserScan, f'/scanned/{name}', 10)
            for name in ('front', 'rear', 'spare')
        }
        self.results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        self.reports = client.listen(msg.CycleReport, 'cycle_report')
        self.states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)

    def header(self):
        return Header(stamp=self.client.node.get_clock().now().to_msg(), frame_id='nobody')

    def scan(self, name, ranges, turned):
        self.scans[name].publish(
            LaserScan(
                header=self.header(), range_min=0.05, range_max=10.0,
                angle_min=turned - 0.4, angle_increment=0.1, ranges=array.array('f', ranges),
            )
        )  # fmt: skip

    def until(self, fact, what, front=FAR, rear=FAR):
        """Send poses and scans again and again until a fact holds; None: a sensor is silent."""

        def holds():
            row = [0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0]
            self.poses.publish(
                msg.FramePoses(header=self.header(), frame_names=['base::body'], poses=row)
            )
            for name, ranges, turned in (('front', front, 0.0), ('rear', rear, math.pi)):
                if ranges is not None:
                    self.scan(name, ranges, turned)
            self.client.spin_until(time.monotonic() + 0.05)
            return fact()

        self.client.wait_for(holds, what)

    def cells(self):
        last = self.reports[-1] if self.reports else msg.CycleReport()
        return dict(zip(last.maps, last.map_cells, strict=True))

    def near(self):
        """Return whether the rule is entered, and why; None: nobody said."""
        if not self.states:
            return None
        state = self.states[-1]
        return bool(state.entered[0]), state.why[0]


@pytest.fixture
def base(node, client):
    return Base(client)


def test_each_sensor_has_a_map_and_a_rule_about_obstacles_needs_those_that_are_required(base):
    base.until(lambda: base.near() == (False, 0), 'both far')
    cells = base.cells()
    assert cells['rear'] <= RAYS < cells['front']  # which are columns
    assert cells['spare'] == 0
    base.until(lambda: base.near() and base.near()[0], 'near behind', rear=[0.25] * RAYS)
    base.until(lambda: base.near() == (False, 0), 'far again')
    stale = True, msg.ProximityEvents.STALE
    base.until(lambda: base.near() == stale, 'a silent sensor', front=None)
    base.until(lambda: base.near() == (False, 0), 'it speaks again')


def test_a_scene_of_other_sensors_is_refused_and_the_own_ones_are_saved(base):
    base.until(lambda: base.near() is not None, 'the node')
    text = accepted(base.client.call(srv.SaveScene, 'save_scene')).text
    assert 'front: {type: laser_scan, topic: /scanned/front, frame: body' in text
    other = 'obstacle_sources:\n  left: {type: laser_scan, topic: /left}\n'
    why = refused(base.client.call(srv.LoadScene, 'load_scene', text=other))
    assert "'left'" in why
    assert 'scene_file' in why


def listed(client):
    answer = accepted(client.call(srv.ListObstacleSources, 'list_obstacle_sources'))
    return {
        name: (origin, settings, age)
        for name, origin, settings, age in zip(
            answer.names, answer.origins, answer.settings, answer.ages, strict=True
        )
    }


def test_a_source_is_added_listed_saved_and_removed_while_the_node_runs(base):
    base.until(lambda: base.near() == (False, 0), 'both far')
    added = '{type: laser_scan, topic: /scanned/side, frame: body, qos: {depth: 3}}'
    base.scans['side'] = base.client.node.create_publisher(LaserScan, '/scanned/side', 10)
    call = base.client.call
    accepted(call(srv.AddObstacleSource, 'add_obstacle_source', name='side', settings=added))
    waits = True, msg.ProximityEvents.NO_POSE
    base.until(lambda: base.near() == waits, 'a required source that waits')
    origin, settings, age = listed(base.client)['side']
    assert (origin, settings, age) == (srv.ListObstacleSources.Request.SERVICE, added, math.inf)
    assert listed(base.client)['front'][0] == srv.ListObstacleSources.Request.SCENE_FILE
    assert f'side: {added}' in accepted(call(srv.SaveScene, 'save_scene')).text

    def seen():
        base.scan('side', FAR, 1.5)
        return base.near() == (False, 0) and base.cells().get('side')

    base.until(seen, 'its scans')
    refused(
        call(srv.AddObstacleSource, 'add_obstacle_source', name='side', settings=added), 'already'
    )
    assert accepted(call(srv.RemoveObstacleSource, 'remove_obstacle_source', name='side')).cells
    base.until(lambda: 'side' not in base.cells() and base.near() == (False, 0), 'its end')
    assert 'side' not in listed(base.client)


@pytest.mark.parametrize(
    ('name', 'settings', 'why'),
    [
        ('front', '{type: laser_scan, topic: /a}', 'by the scene file'),
        ('new', '{type: laser_scan, topic: /a//b}', '/a//b'),
        ('new', '{type: sonar, topic: /a}', 'sonar'),
        ('new', '{', 'not YAML'),
    ],
)
def test_a_source_that_cannot_be_added_changes_nothing(base, name, settings, why):
    before = listed(base.client)
    call = base.client.call
    text = accepted(call(srv.SaveScene, 'save_scene')).text
    refused(call(srv.AddObstacleSource, 'add_obstacle_source', name=name, settings=settings), why)
    assert listed(base.client).keys() == before.keys()
    assert accepted(call(srv.SaveScene, 'save_scene')).text == text


def test_a_source_of_the_scene_file_is_not_removed_by_a_service(base):
    why = refused(
        base.client.call(srv.RemoveObstacleSource, 'remove_obstacle_source', name='rear')
    )
    assert 'scene file' in why
    assert 'rear' in listed(base.client)


@pytest.fixture
def lost(base):
    """Return what sends a scan of one more sensor, whose poses never come."""
    added = '{type: laser_scan, topic: /scanned/lost, required: false}'
    call = base.client.call
    accepted(call(srv.AddObstacleSource, 'add_obstacle_source', name='lost', settings=added))
    publisher = base.client.node.create_publisher(LaserScan, '/scanned/lost', 10)

    def send():
        header = base.header()
        header.stamp.sec += 5  # from the future: it is waited for
        publisher.publish(LaserScan(header=header, range_max=10.0, ranges=array.array('f', FAR)))

    yield send
    base.client.node.destroy_publisher(publisher)
    accepted(call(srv.RemoveObstacleSource, 'remove_obstacle_source', name='lost'))


def test_a_sensor_whose_poses_never_come_delays_no_other(base, lost):
    """Its messages wait 0.5 s each, others do not: as many are taken beside them, or nearly."""

    def count():
        answer = accepted(base.client.call(srv.ListObstacleSources, 'list_obstacle_sources'))
        return dict(zip(answer.names, answer.messages, strict=True))

    base.until(lambda: base.near() == (False, 0), 'far scans')
    taken = []
    for with_lost in (False, True):  # those of before wait on, so they come last
        before = count()['front']
        for _ in range(40):
            if with_lost:
                lost()
            base.until(lambda: True, '')
        taken.append(count()['front'] - before)
    assert count()['lost'] == 0
    # A process that waited for each lost scan would take two of others a second, not twenty.
    assert taken[1] > taken[0] // 2


def test_a_sensor_that_sees_only_the_robot_is_stale_and_not_free(base):
    base.until(lambda: base.near() == (False, 0), 'both far')
    on_hull = [0.2 / math.cos(0.1 * k - 0.4) for k in range(RAYS)]  # [m] its side
    stale = True, msg.ProximityEvents.STALE
    base.until(lambda: base.near() == stale, 'scans of the robot alone', front=on_hull)
    base.until(lambda: base.near() == (False, 0), 'it sees more again')


def test_two_drivers_that_alternate_hide_nothing_from_each_other(base):
    """The front lidar sees far, another driver of its topic near: both count all the time."""
    base.until(lambda: base.near() == (False, 0), 'both far')
    other = base.client.node.create_publisher(LaserScan, '/scanned/front', 10)
    mine, entered = base.scans['front'], []

    def alternate():
        base.scans['front'] = other
        base.scan('front', [0.25] * RAYS, 0.0)
        base.scans['front'] = mine
        entered.append(base.near()[0])
        return entered[-1]

    base.until(alternate, 'near by one of two')
    entered.clear()
    base.until(lambda: alternate() and len(entered) > 20, 'alternation')
    assert all(entered)
    base.client.node.destroy_publisher(other)
    accepted(base.client.call(srv.ClearObstacles, 'clear_obstacles', map='front'))
    base.until(lambda: base.near() == (False, 0), 'one driver')


def test_a_scan_without_an_echo_is_clear_and_fresh(base):
    base.until(lambda: base.near() and base.near()[0], 'near behind', rear=[0.25] * RAYS)
    nothing = [math.inf] * RAYS

    def is_empty():
        cells = base.cells()
        return base.near() == (False, 0) and not (cells['front'] or cells['rear'])

    base.until(is_empty, 'nobody around', nothing, nothing)
    assert base.results[-1].waiting_frames == ['obstacles::spare']
    answer = accepted(base.client.call(srv.HasCollisions, 'has_collisions'))
    assert not answer.has_collisions


def test_ranges_and_occupancy_grids_are_maps(base):
    """A thing ahead at 1 m by sonar, and one aside at 2 m on a costmap."""
    Grid = pytest.importorskip('nav_msgs.msg').OccupancyGrid
    call, node = base.client.call, base.client.node
    added = {
        'sonar': '{type: range, topic: /scanned/sonar, frame: body}',
        'costs': '{type: occupancy_grid, topic: /scanned/costs, extrude: [0, 1], threshold: 100}',
    }
    for name, settings in added.items():
        accepted(call(srv.AddObstacleSource, 'add_obstacle_source', name=name, settings=settings))
    sonar = node.create_publisher(Range, '/scanned/sonar', 10)
    costs = node.create_publisher(Grid, '/scanned/costs', 10)
    data = array.array('b', [0] * 2500)
    data[45 * 50 + 25], data[25 * 50 + 45] = 100, 99  # 0.1 m cells from (-2.5, -2.5) on

    def seen(range_, data):
        header = base.header()
        sonar.publish(
            Range(
                header=header, range=range_, min_range=0.1, max_range=3.0, field_of_view=0.2
            )
        )  # fmt: skip
        grid = Grid(header=Header(stamp=header.stamp, frame_id='world'), data=data)
        grid.info.resolution, grid.info.width, grid.info.height = 0.1, 50, 50
        grid.info.origin.position.x = grid.info.origin.position.y = -2.5
        costs.publish(grid)
        return base.near() == (False, 0)

    def distance(name):
        pair = {'geometry_a': f'obstacles::{name}/map', 'geometry_b': 'base::body/hull'}
        return call(srv.ComputeSignedDistancePair, 'compute_signed_distance_pair', **pair)

    base.until(lambda: seen(1.0, data) and all(map(base.cells().get, added)), 'both maps')
    assert accepted(distance('sonar')).result.distance[0] == pytest.approx(0.8, abs=0.05)
    # The lethal cell alone: from 2.0 m on along y.
    assert accepted(distance('costs')).result.distance[0] == pytest.approx(1.8, abs=1e-5)
    none = array.array('b', [0] * 2500)

    def is_empty():
        seen(math.inf, none)
        cells = base.cells()
        return not (cells['costs'] or cells['sonar'])

    base.until(is_empty, 'nothing there')
    for name in added:
        refused(distance(name), 'is a map without cells, which is at no distance from anything')
        accepted(call(srv.RemoveObstacleSource, 'remove_obstacle_source', name=name))
