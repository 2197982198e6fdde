"""Occupancy grids and ranges in the scene, and maps that show that nothing is there. No ROS."""

import array
import math
from functools import partial
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.sensing_node import Node, cloud, cone, grid, stamp_of
from live.inputs.test_obstacles import octomap

from drake_geom_ros.geometry import ArgumentError, FramePoseVector
from drake_geom_ros.live.inputs.lasting_maps import LastingMaps
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.map_placing import clear_maps
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files import ObstacleSource
from drake_geom_ros.sensed_maps import Cells

SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: mast, source: s, pose: {position: [0, 0, 2]}, static: true}
- {name: map, source: s, pose: {position: [1, 0, 0.5], rpy: [0, 0, 1.5707963]}, static: true}
- {name: cart, source: s, pose: {position: [1, 0, 0]}}
- {name: ramp, source: s, pose: {rpy: [0.1, 0, 0]}, static: true}
- {name: late, source: s, static: true}
geometries:
- {name: hand, source: s, frame: arm, shape: {type: sphere, radius: 0.1}}
"""


def node_of(kind, **keys):
    """Return a node with one source, and its arm far below."""
    node = Node(scene=SCENE, source=ObstacleSource('seen', kind, '/seen', **keys))
    node.move(100.0, [0, 0, -5])
    return node


def rounded(rows):
    return sorted(np.round(np.asarray(rows), 6).tolist())


def test_a_grid_is_cells_that_its_plane_cuts_in_the_middle():
    node = node_of('occupancy_grid')
    node.input.take_grid(grid([[0.52, -0.37]]))
    assert rounded(node.centres()) == [[0.55, -0.35, 0.0]]


def test_a_grid_stands_where_its_frame_is():
    node = node_of('occupancy_grid', extrude=(0.4, 0.6))
    node.input.take_grid(grid([[0.52, -0.37]], frame='map'))
    x, y = 1.0 + 0.35, 0.55  # a quarter turn about z, one metre ahead
    assert rounded(node.centres()) == [[x, y, 0.4], [x, y, 0.5], [x, y, 0.6]]


def test_a_tilted_grid_has_no_columns():
    node = node_of('occupancy_grid', extrude=(0.0, 1.0))
    with pytest.raises(ArgumentError, match=r'tilted by 5\.73 degrees'):
        node.input.take_grid(grid([[0.5, 0.0]], frame='ramp'))


def test_the_threshold_says_which_cells_are_occupied():
    for threshold, cells in ((65, 2), (100, 1), (20, 3)):
        node = node_of('occupancy_grid', threshold=threshold)
        message = grid([[0.0, 0.0]])
        message.data[0], message.data[1] = 99, 20
        node.input.take_grid(message)
        assert len(node.centres()) == cells


def test_unknown_cells_are_occupied_unless_they_are_declared_free():
    message = grid([[0.0, 0.0]])
    message.data[7] = -1
    for unknown, cells in ((None, 2), ('occupied', 2), ('free', 1)):
        node = node_of('occupancy_grid', unknown=unknown)
        node.input.take_grid(message)
        assert len(node.centres()) == cells


def _all_unknown():
    message = grid([])
    message.data[:] = array.array('b', [-1] * len(message.data))
    return message


def _with(**changes):
    message = grid([])
    message.info = Plain(**{**vars(message.info), **changes})
    return message


@pytest.mark.parametrize(
    ('message', 'told'),
    [
        (_all_unknown(), 'all cells of the grid are unknown: it shows nothing'),
        (_with(width=61), r'data has 2400 cells, and the grid is 61 by 40'),
        (grid([], data=array.array('b')), 'data has 0 cells'),
        (_with(resolution=0.0), 'resolution'),
        (_with(resolution=math.nan), 'resolution'),
        (grid([[0, 0]], value=101), 'a cell has the value 101; it must be at most 100'),
    ],
)
def test_what_is_no_grid_is_refused_and_the_map_stays(message, told):
    node = node_of('occupancy_grid', unknown='free')
    node.input.take_grid(grid([[0.0, 0.0]]))
    with pytest.raises(ArgumentError, match=told):
        node.input.take_grid(message)
    assert len(node.centres()) == 1


def test_beyond_its_grid_nothing_is_seen():
    """A rule about the map is entered where the body is beside the grid."""
    node = node_of('occupancy_grid')
    node.input.take_grid(grid([]))
    for place, is_entered in (([1.0, 0.0, 1.0], False), ([5.0, 0.0, 1.0], True)):
        node.move(100.0, place)
        assert _entered(node) == is_entered


def test_a_range_is_the_cap_of_its_cone():
    node = node_of('range', resolution=0.1)
    node.taker.take_range(cone(1.0, field_of_view=0.6))
    centres = node.centres()
    assert 9 <= len(centres) <= 64
    assert np.linalg.norm(centres - [0, 0, 2], axis=1) == pytest.approx(1.0, abs=0.1)


EMPTY = {  # scans: see test_laser_scans
    'range': lambda node: node.taker.take_range(cone(math.inf)),
    'octomap': lambda node: node.input.take_octomap(_free_octomap()),
    'occupancy_grid': lambda node: node.input.take_grid(grid([])),
    'point_cloud': lambda node: node.taker.take_cloud(cloud(np.zeros((0, 3)))),
}


def _free_octomap():
    """Return a tree one leaf of which is free, and none occupied."""
    tree = octomap(Cells.of_points([[0.0, 0.0, 0.0]], 0.1), 'world', 100.0)
    words = np.frombuffer(tree.data, dtype='<u2').copy()
    last = words[-1:]  # of the occupied leaf: 2 is turned into 1
    last[0] = sum(1 << (2 * k) for k in range(8) if last[0] >> (2 * k) & 3 == 2)
    tree.data = array.array('b', words.tobytes())
    return tree


def _entered(node, stale_after=1.0):
    """Return whether a stop rule of the hand and the map is entered."""
    with node.live.editing() as scene:
        scene.bind_rules()
        if not scene.rules.rules:
            scene.rules.add([ProximityRule('r', ('s',), ('obstacles',), enter=0.2, leave=0.3)])
        blind = scene.blind_frames(stale_after)
        scene.rules.decide(node.clock.now, scene.query, blind, sights=scene.maps.sights())
        return scene.rules.states()[0].is_entered


@pytest.mark.parametrize('kind', EMPTY)
def test_heard_and_empty_is_fresh_and_clear_until_it_is_stale(kind):
    """Never heard: the rule is entered. Heard and empty: left. Silent: entered again."""
    keys = {'may_be_empty': True} if kind == 'point_cloud' else {}
    node = node_of(kind, **keys)
    node.move(100.0, [0.5, 0.0, 1.5])
    assert _entered(node)
    assert node.pairs()[1] == 1
    EMPTY[kind](node)
    assert node.centres().tolist() == []
    assert (node.age(), node.pairs()) == (0.0, ({}, 0))
    assert not _entered(node)
    node.clock.now = 101.5
    node.move(101.5, [0.5, 0.0, 1.5])
    assert _entered(node)


def test_a_cloud_without_points_is_refused_unless_it_may_be_empty():
    node = node_of('point_cloud')
    for points in (np.zeros((0, 3)), [[math.nan] * 3]):
        with pytest.raises(ArgumentError, match='shows nothing'):
            node.taker.take_cloud(cloud(points))
    assert node.centres() is None


def test_an_octomap_without_leaves_is_refused():
    node = node_of('octomap')
    tree = octomap(Cells.of_points([[0.0, 0.0, 0.0]], 0.1), 'world', 100.0)
    tree.data = array.array('b')
    with pytest.raises(ArgumentError, match='the tree has no leaves: it shows nothing'):
        node.input.take_octomap(tree)


@pytest.mark.parametrize('frame', ['world', 'map'])
def test_a_static_grid_is_taken_however_old_and_never_grows_old(frame):
    node = node_of('occupancy_grid', static=True)
    node.input.take_grid(grid([[0.52, -0.37]], stamp=1.0, frame=frame))
    assert len(node.centres()) == 1
    node.clock.now += 1e6
    assert node.age() == 0.0
    node.input.take_grid(grid([], stamp=0.5, frame=frame))
    assert len(node.centres()) == 0, 'another message takes its place, whatever its stamp'


def test_a_costmap_that_is_old_is_refused_and_the_one_before_grows_old():
    node = node_of('occupancy_grid')
    node.input.take_grid(grid([[0.52, -0.37]]))
    node.clock.now += 11.0
    with pytest.raises(ArgumentError, match='at most 10 s are taken'):
        node.input.take_grid(grid([]))
    assert len(node.centres()) == 1
    assert node.age() == 11.0


def test_a_static_grid_rests_in_the_world():
    node = node_of('occupancy_grid', static=True)
    with pytest.raises(ArgumentError, match="its frame 'arm' hangs on s::arm, which moves"):
        node.input.take_grid(grid([[0.5, 0.0]], frame='arm'))
    assert node.centres() is None


def pose(node, name, X):
    """Pose a frame, by a message."""
    with node.live.editing() as scene:
        frame = scene.model.names.frame(name)
        posed = {frozenset([frame.get_value()]): scene.clocks.arrival().since(100.5)}
        poses, rows = FramePoseVector({frame: X}), X.ToArray()[np.newaxis]
        scene.poses.pose(poses, posed, stamp_of(100.5), MESSAGES, rows)


def hear(maps, node, frame, publisher='', cell=(0.52, -0.37)):
    """Have a static map hear a grid of one cell."""
    message = grid([cell], frame=frame)
    taken = partial(node.input.take_grid, message, publisher=publisher)
    maps.take('seen', publisher, message.header, taken)


def lasting(node, frame):
    """Return what has the static map of a node follow, with a grid of one cell taken."""
    maps = LastingMaps(node.live, node.frames)
    hear(maps, node, frame)
    return maps


def test_a_static_grid_follows_its_frame_once_that_is_posed_elsewhere():
    node = node_of('occupancy_grid', static=True)
    maps = lasting(node, 'map')
    before, changes = node.centres(), node.changes
    maps.look()
    assert node.changes == changes, 'nothing was posed'
    pose(node, 'map', RigidTransform(RollPitchYaw(0.0, 0.0, 0.5 * np.pi), [3.0, 0.0, 0.5]))
    maps.look()
    np.testing.assert_allclose(
        node.centres(), before + np.array([2.0, 0.0, 0.0]), rtol=0.0, atol=1e-6
    )
    assert node.age() == 0.0


def test_a_static_grid_waits_once_its_frame_moves():
    node = node_of('occupancy_grid', static=True)
    maps = lasting(node, 'cart')  # which the scene file poses, and does not call static
    pose(node, 'cart', RigidTransform([2.0, 0.0, 0.0]))
    with pytest.raises(ArgumentError, match="'cart' hangs on s::cart, which moves"):
        maps.look()
    assert node.age() == np.inf
    assert node.pairs()[1] > 0
    maps.look()
    assert node.centres() is None, 'it waits for another message'


def test_a_static_map_follows_the_frames_of_all_its_publishers():
    moved = RigidTransform([3.0, 0.0, 0.5])
    nodes = [node_of('occupancy_grid', static=True) for _ in range(2)]
    for node, is_posed_first in zip(nodes, (True, False), strict=True):
        maps = LastingMaps(node.live, node.frames)
        if is_posed_first:
            pose(node, 'map', moved)
        hear(maps, node, 'map', publisher='one')
        hear(maps, node, 'mast', publisher='two', cell=(-0.5, 0.5))
        if not is_posed_first:
            pose(node, 'map', moved)
        maps.look()
    assert rounded(nodes[0].centres()) == rounded(nodes[1].centres())
    x = nodes[0].centres()[:, 0]
    assert (x.min(), x.max()) == pytest.approx((-0.5, 3.5), abs=0.1), 'both are there'


def test_a_static_map_that_comes_before_the_pose_of_its_frame_waits_for_it():
    node = node_of('occupancy_grid', static=True)
    maps = LastingMaps(node.live, node.frames)
    with pytest.raises(ArgumentError, match='late'):
        hear(maps, node, 'late')
    maps.look()
    assert node.centres() is None
    pose(node, 'late', RigidTransform([1.0, 0.0, 0.0]))
    maps.look()
    assert rounded(node.centres()) == [[1.55, -0.35, 0.0]]


def test_a_refused_map_clears_nothing_that_is_held():
    node = node_of('occupancy_grid', static=True)
    maps = lasting(node, 'map')
    held = node.centres()
    for frame in ('arm', 'late'):
        with pytest.raises(ArgumentError):
            hear(maps, node, frame)
        maps.look()
        np.testing.assert_array_equal(node.centres(), held)


def test_a_static_grid_that_was_cleared_does_not_come_back():
    node = node_of('occupancy_grid', static=True)
    maps = lasting(node, 'map')
    clear_maps(node.live, ['seen'])
    pose(node, 'map', RigidTransform([3.0, 0.0, 0.5]))
    maps.look()
    assert node.centres() is None


def test_answers_bear_the_stamp_of_what_moves_and_not_of_a_static_grid():
    node = node_of('occupancy_grid', static=True)
    node.input.take_grid(grid([[0.52, -0.37]], stamp=1.0))
    with node.live.reading() as scene:
        assert scene.moment().newest_stamp.sec == 100
