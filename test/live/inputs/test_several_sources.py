"""Several sensors: what one sees free, or out of its sight, another may see occupied."""

import itertools
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.conversions.test_depth_image import camera, image
from live.inputs.sensing_node import Node, cloud, cone, grid, header, scan
from live.inputs.test_obstacles import octomap

from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files import ObstacleSource
from drake_geom_ros.sensed_maps.cells import Cells

# Two sensors at one place, which look along x, and a probe far from all.
SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: one, source: s, pose: {position: [0.02, 0.02, 0.02]}, static: true}
- {name: two, source: s, pose: {position: [0.02, 0.02, 0.02]}, static: true}
- {name: one_optical, source: s, parent: one, pose: {rpy: [-1.5708, 0, -1.5708]}, static: true}
- {name: two_optical, source: s, parent: two, pose: {rpy: [-1.5708, 0, -1.5708]}, static: true}
geometries:
- {name: hand, source: s, frame: arm, shape: {type: sphere, radius: 0.05}}
"""
EYE = np.array([0.02, 0.02, 0.02])
# Ends of rays in the frames of the sensors [m]: a thing, what is behind it, and what is aside.
THING, BEHIND, ASIDE = (1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.0, 1.0, 0.0)
KEEP = 2.0
KINDS = 'laser_scan', 'point_cloud', 'depth_image', 'range', 'octomap', 'occupancy_grid'
MAPS = 'octomap', 'occupancy_grid'
WIDTH = 101  # pixels, 45 degrees to each side


def scan_of(end, frame, stamp):
    rays = np.full(181, np.nan)  # no echo would be a look through all cells
    rays[90 + round(np.degrees(np.arctan2(end[1], end[0])))] = np.hypot(*end[:2])
    return scan(rays, frame, stamp)


def image_of(end, frame, stamp):
    depths = np.zeros((1, WIDTH))
    depths[0, WIDTH // 2 - round(50.0 * end[1] / end[0])] = end[0]
    told = image(depths)
    told.header = header(f'{frame}_optical', stamp)
    return told


def see(kind, sensor, end, frame, stamp, publisher=''):
    """Have a sensor see one point at the end of a ray."""
    its_input, taker = sensor
    if kind == 'laser_scan':
        taker.take_scan(scan_of(end, frame, stamp), 0.0, publisher)
    elif kind == 'point_cloud':
        taker.take_cloud(cloud([end], frame, stamp), 0.0, publisher)
    elif kind == 'depth_image':
        told = camera(WIDTH, 1)
        told.header = header(f'{frame}_optical', stamp)
        taker.take_camera(told)
        taker.take_depth(image_of(end, frame, stamp), 0.0, publisher)
    elif kind == 'range':  # which looks along x
        taker.take_range(cone(np.inf if end[1] else end[0], frame, stamp), 0.0, publisher)
    elif kind == 'occupancy_grid':
        its_input.take_grid(grid([np.array(end) + EYE], stamp), 0.0, publisher)
    else:
        cells = Cells.of_points(np.array([end]) + EYE, 0.1)
        its_input.take_octomap(octomap(cells, 'world', stamp), 0.0, publisher)


def source(name, kind):
    return ObstacleSource(name, kind, f'/{name}')


def is_occupied(node, end):
    """Return whether any map has the cell of a point, by the distances of the hand put there."""
    node.move(node.clock.now, np.array(end) + EYE)
    distances = [
        d for pair, d in node.pairs()[0].items() if any('obstacles' in name for name in pair)
    ]
    node.move(node.clock.now, [0.0, 0.0, 50.0])
    return min(distances, default=np.inf) < 0.0


@pytest.mark.parametrize('free_first', [True, False])
@pytest.mark.parametrize(('kind_a', 'kind_b'), list(itertools.product(KINDS, KINDS)))
def test_a_cell_that_one_sees_free_and_another_occupied_stays_for_keep(kind_a, kind_b, free_first):
    node = Node(scene=SCENE, source=source('a', kind_a), self_filter='none', keep=KEEP, rays=True)
    a, b = (node.input, node.taker), node.add(source('b', kind_b))

    def at(stamp):
        node.clock.now = stamp
        node.move(stamp, [0.0, 0.0, 50.0])

    for k in range(2):
        at(100.0 + 0.1 * k)
        if (k == 0) == free_first:
            see(kind_a, a, BEHIND, 'one', node.clock.now)
        else:
            see(kind_b, b, THING, 'two', node.clock.now)
    assert is_occupied(node, THING)
    # From now on b looks aside, and a through the cell.
    last = 100.1 if free_first else 100.0
    for stamp in (100.5, 101.0, 101.9):
        at(stamp)
        see(kind_a, a, BEHIND, 'one', stamp)
        assert is_occupied(node, THING)
        # The cells of maps are those of their last message, and a range looks ahead alone.
        if kind_b not in (*MAPS, 'range'):
            see(kind_b, b, ASIDE, 'two', stamp)
            assert is_occupied(node, THING)
    at(last + KEEP + 0.1)
    see(kind_a, a, BEHIND, 'one', node.clock.now)
    see(kind_b, b, ASIDE, 'two', node.clock.now)
    assert not is_occupied(node, THING)


@pytest.mark.parametrize('kind', KINDS)
def test_so_it_is_for_two_sensors_that_feed_one_map(kind):
    node = Node(scene=SCENE, source=source('a', kind), self_filter='none', keep=KEEP, rays=True)
    sensor = node.input, node.taker
    node.move(100.0, [0.0, 0.0, 50.0])
    see(kind, sensor, THING, 'two', 100.0, 'second')
    see(kind, sensor, BEHIND, 'one', 100.0, 'first')
    assert is_occupied(node, THING)
    node.clock.now = 100.5
    node.move(100.5, [0.0, 0.0, 50.0])
    see(kind, sensor, BEHIND, 'one', 100.5, 'first')
    assert is_occupied(node, THING)


class Sides:
    """A hand, and two sensors of which one sees it."""

    FAR = (-20.0, -1.0, -1.0, -10.0, 1.0, 1.0)  # a box without the hand

    def __init__(self, **near):
        far = ObstacleSource('far', 'point_cloud', '/far', box=self.FAR)
        self.node = node = Node(scene=SCENE, source=far, self_filter='none')
        near = node.add(ObstacleSource('near', 'point_cloud', '/near', **near))
        node.move(100.0, [1.0, 0.0, 0.0])
        node.taker.take_cloud(cloud([[3.0, 0.0, 0.0]], 'one'))
        near[1].take_cloud(cloud([[3.0, 0.0, 0.0]], 'two'))

    def entered(self, *patterns):
        """Return which rules are entered, a rule for each pattern of maps, and the trouble."""
        rules = [
            ProximityRule(pattern, ('s',), (pattern,), enter=0.2, leave=0.3)
            for pattern in patterns
        ]
        with self.node.live.editing() as scene:
            scene.bind_rules()
            scene.rules.add(rules)
            sights = scene.maps.sights()
            scene.rules.decide(100.0, scene.query, scene.poses.blind_frames(1.0), sights=sights)
            trouble = scene.rules.unseen(scene.query, sights)
            events = scene.rules.take_events()
            return {s.rule.name for s in scene.rules.states() if s.is_entered}, trouble, events


def test_a_rule_about_one_map_needs_that_map_to_see_the_body():
    every = 'obstacles::far', 'obstacles::near', 'obstacles'
    entered, trouble, events = Sides().entered(*every)
    assert entered == {'obstacles::far'}
    assert trouble.startswith('no sensor sees s::arm/hand: ')
    assert 'proximity rules obstacles::far are about' in trouble
    (event,) = events
    assert np.isnan(event.distance)
    names = Plain(far=event.id_A, hand=event.id_B)
    assert names.far != names.hand != 0


def test_a_map_that_is_not_required_is_no_evidence_that_a_body_is_seen():
    entered, _, _ = Sides(required=False).entered('obstacles::far', 'obstacles')
    assert entered == {'obstacles::far', 'obstacles'}
