"""Clouds, depth images and OctoMaps become maps of a live scene, or are refused whole."""

import array
import threading
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.sensing_node import Node, cloud, header

from drake_geom_ros.geometry import (
    ArgumentError,
    ProximityProperties,
    RoleAssign,
    Sphere,
)
from drake_geom_ros.live.conversions.octomap import MOST_NODES, cells_from_octomap
from drake_geom_ros.live.inputs import obstacles
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene import moments
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.sensed_maps.cells import Cells
from drake_geom_ros.sensed_maps.octree import binary_of_cells


def near(found, expected):
    return sorted(map(tuple, np.round(found, 6))) == sorted(map(tuple, np.round(expected, 6)))


def test_a_map_that_never_came_is_waited_for_and_is_not_empty():
    node = Node()
    node.move(100.0, [0, 0, 0])
    told, waiting = node.pairs()
    assert waiting == 1  # with the hand; what is anchored is at rest as the map is
    assert all('obstacles' not in name for pair in told for name in pair)
    assert node.age() == np.inf
    node.taker.take_cloud(cloud([[0.5, 0.0, -2.0]]))
    told, waiting = node.pairs()
    assert waiting == 0
    (distance,) = (d for pair, d in told.items() if any('obstacles' in name for name in pair))
    assert distance == pytest.approx(0.5 - 0.1, abs=1e-6)
    assert node.changes == 1


def test_a_cloud_holds_at_the_poses_of_its_stamp_and_not_of_now():
    node = Node(self_filter='none')
    node.move(99.8, [0, 0, 0])
    node.move(99.9, [1, 0, 0])
    node.move(100.0, [7, 7, 7])
    node.taker.take_cloud(cloud([[0.01, 2.01, 0.01]], 'eye', 99.85))
    assert near(node.centres(), [[0.55, 2.05, 1.05]])
    assert node.age() == pytest.approx(0.15, abs=1e-6)
    node.clock.now = 101.0
    assert node.age() == pytest.approx(1.15, abs=1e-6)


def test_points_are_left_out_on_bodies_as_they_are_by_now():
    node = Node(self_filter='scene', padding=0.05)
    points = [[0.25, 0.0, 0.0], [1.0, 0.0, 0.0]]  # beside the hand
    node.move(99.9, [0, 0, 0])
    node.move(100.0, [0, 0, 0])
    counts = []

    def take():
        node.taker.take_cloud(cloud(points, 'world', 100.0))
        counts.append((node.input.counts.on_bodies, node.input.counts.in_shell))

    def become(radius):
        with node.live.editing() as scene:
            scene.make(Change(lambda graph, _: graph.ChangeShape(source, hand, Sphere(radius))))
        take()

    take()
    take()
    with node.live.editing() as scene:
        hand = scene.model.names.geometry('arm/hand')
        source = scene.model.inspector.GetOwningSourceId(hand)
    become(0.22)
    become(0.245)
    with node.live.editing() as scene:
        padded = ProximityProperties()
        padded.AddProperty('proximity', 'padding', 0.75)
        scene.make(
            Change(lambda graph, _: graph.AssignRole(source, hand, padded, RoleAssign.kReplace))
        )
    take()  # a sensor sees a body without its padding
    with node.live.editing() as scene:
        scene.make(Change(lambda graph, _: graph.RemoveGeometry(source, hand)))
    take()
    node.settings = node.settings._replace(self_filter='none')
    take()
    assert counts == [(0, 0), (0, 0), (0, 1), (1, 0), (1, 0), (0, 0), (0, 0)]


def test_bodies_are_told_once_and_known_though_the_message_was_refused():
    node, told = Node(self_filter='scene'), []
    node.move(100.0, [0, 0, 0])
    begin = node.input.begin

    def listening(*asked):
        place = begin(*asked)
        told.append(place.bodies.bodies is not None)
        return place

    node.input.begin = listening
    nothing = cloud([[np.nan] * 3] * 5, 'world')
    good = cloud([[0.105, 0.0, 0.0], [1.0, 0.0, 0.0]], 'world')  # one on the hand
    for _ in range(2):
        with pytest.raises(ArgumentError, match='none of its 5 points is finite'):
            node.taker.take_cloud(nothing)
    node.taker.take_cloud(good)
    node.taker = PointTaker(node.input)  # in a process that was started again
    with pytest.raises(ArgumentError, match='none of its 5 points is finite'):
        node.taker.take_cloud(nothing)
    node.taker.take_cloud(good)
    assert told == [True, False, False, True, False]
    assert node.input.counts.on_bodies == 1


@pytest.mark.clock
def test_the_pose_of_a_stamp_is_waited_for_a_little():
    node = Node(self_filter='none')
    node.move(99.9, [0, 0, 0])
    taken = threading.Thread(
        target=node.taker.take_cloud, args=(cloud([[0, 2, 0]], 'eye', 99.95),)
    )
    taken.start()
    node.move(100.0, [1, 0, 0])
    taken.join(10.0)
    assert near(node.centres(), [[0.55, 2.05, 1.05]])


@pytest.mark.parametrize(
    ('message', 'reason'),
    [
        (cloud([[1, 0, 0]], 'eye', 99.95), 's::arm was at the stamp of the message is not known'),
        (cloud([[1, 0, 0]], 'eye', 99.0), 'before the poses that are kept'),
        (cloud([[1, 0, 0]], stamp=101.0), 'from the future'),
        (cloud([[1, 0, 0]], stamp=80.0), 'before the time of the node'),
        (cloud([[1, 0, 0]], stamp=0.0), 'stamp is 0'),
        (cloud([[1, 0, 0]], ''), 'frame_id is empty'),
        (cloud([[1, 0, 0]], 'moon'), 'moon'),
        (cloud([[np.nan, 0, 0]] * 4), 'none of its 4 points is finite'),
        (cloud([]), 'none of its 0 points'),
        (cloud([[1, 0, 0]], width=10**9, height=1, row_step=12 * 10**9), 'at most'),
        (cloud([[1, 0, 0]], width=10**6, row_step=12 * 10**6), 'do not fit'),
        (cloud([[1, 0, 0]], fields=[]), 'lacks x, y, z'),
        (cloud([[1e30, 0, 0]]), 'must be finite and within'),
        (cloud([[3.0, 0.0, -2.0]]), 'all of its points lie on bodies'),
        (cloud([[1, 0, 0]], stamp=99.5), 'before that of the map that is there'),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_whole_and_the_map_of_before_stays(monkeypatch, message, reason):
    monkeypatch.setattr(moments, 'PATIENCE', 0.05)
    node = Node()
    node.move(99.45, [0, 0, 0])
    node.move(99.9, [0, 0, 0])
    node.taker.take_cloud(cloud([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]], stamp=99.9))
    if 'eye' not in message.header.frame_id:
        node.move(100.0, [0, 0, 0])
    before, changes = node.centres(), node.changes
    with pytest.raises(RuntimeError, match=reason):
        node.taker.take_cloud(message)
    assert node.centres().tolist() == before.tolist()
    assert node.changes == changes
    assert node.input.counts.taken == 1
    assert node.age() == pytest.approx(0.1, abs=1e-6)  # and grows on


def test_points_are_counted_by_what_became_of_them():
    node = Node()
    node.move(100.0, [0.0, 0.0, 1.0])
    on_hand = [[0.105, 0.0, -1.0], [0.0, 0.0, -0.891], [0.0, 0.0, -1.0]]
    in_shell = [[0.12, 0.0, -1.0], [0.0, 0.0, -0.851]]
    beside = [[0.16, 0.0, -1.0], [0.0, 0.0, -0.849]]
    far = [[9.0, 0.0, 0.0]]
    lost = [[np.nan, 0.0, 0.0], [np.inf, 1.0, 0.0]]
    node.taker.take_cloud(cloud(on_hand + in_shell + beside + far + lost))
    counts = node.input.counts
    told = counts.points, counts.not_finite, counts.out_of_reach, counts.on_bodies, counts.cells
    assert told == (10, 2, 1, 3, 2)
    assert counts.in_shell == 2
    assert near(node.centres(), [[0.15, 0.05, 1.05], [0.05, 0.05, 1.15]])


def test_only_robots_are_left_out_unless_asked():
    node = Node(self_filter='robots')
    node.move(100.0, [0.0, 0.0, 1.0])
    node.taker.take_cloud(cloud([[0.12, 0.0, -1.0]]))
    assert len(node.centres()) == 1  # the hand is on no robot


def test_the_body_is_left_out_where_it_was():
    node = Node()
    node.move(99.9, [0.0, 0.0, 1.0])
    node.move(100.0, [1.0, 0.0, 1.0])
    node.taker.take_cloud(cloud([[0.5, 0.0, -1.0], [1.0, 0.0, -1.0]], stamp=99.95))
    assert near(node.centres(), [[1.05, 0.05, 1.05]])


def test_what_is_beyond_reach_is_left_out_but_the_nearest_of_all():
    node = Node(reach=1.0, self_filter='none')
    node.taker.take_cloud(cloud([[4, 0, 0], [3, 0, 0.01]]))
    assert near(node.centres(), [[3.05, 0.05, 2.05]])


def test_cells_are_held_for_a_while_or_until_seen_free():
    node = Node(self_filter='none', keep=1.0)
    node.taker.take_cloud(cloud([[1, 0, 0]], stamp=100.0))
    node.clock.now = 100.5
    node.taker.take_cloud(cloud([[0, 2, 0]], stamp=100.5))
    assert len(node.centres()) == 2
    node.clock.now = 101.2
    node.taker.take_cloud(cloud([[0, 2, 0]], stamp=101.2))
    assert near(node.centres(), [[0.05, 2.05, 2.05]])
    node.settings = node.settings._replace(keep=np.inf, rays=True)
    node.taker.take_cloud(cloud([[0.01, 1.01, 0.01], [2.01, 0.01, 0.01]], stamp=101.2))
    assert len(node.centres()) == 3
    node.taker.take_cloud(cloud([[0.01, 4.01, 0.01]], stamp=101.2))
    assert near(node.centres(), [[0.05, 4.05, 2.05], [2.05, 0.05, 2.05]])


def test_cells_are_held_neither_for_ever_nor_gone_when_the_clock_jumps():
    node = Node(self_filter='none', keep=1.0)
    node.taker.take_cloud(cloud([[1, 0, 0]], stamp=100.0))
    node.clock.now = 20.0  # simulated time begins anew
    node.live.clocks.begin_anew()
    node.taker.take_cloud(cloud([[0, 2, 0]], stamp=20.0))
    assert len(node.centres()) == 2
    assert node.input.counts.held_cells == 1
    node.clock.now = 20.8
    node.taker.take_cloud(cloud([[0, 2, 0]], stamp=20.8))
    assert len(node.centres()) == 2
    node.clock.now = 21.1
    node.taker.take_cloud(cloud([[0, 2, 0]], stamp=21.1))
    assert near(node.centres(), [[0.05, 2.05, 2.05]])
    node.clock.now = 900.0  # or jumps ahead
    node.live.clocks.begin_anew()
    node.taker.take_cloud(cloud([[1, 0, 0]], stamp=900.0))
    assert len(node.centres()) == 2


def test_points_that_make_no_cell_are_counted():
    node = Node(self_filter='none', least_points=2)
    pair, alone = [[1.01, 0.01, 0.01], [1.02, 0.01, 0.01]], [[0.01, 2.01, 0.01]]
    node.taker.take_cloud(cloud(pair + alone))
    assert (len(node.centres()), node.input.counts.in_sparse_cells) == (1, 1)
    node.taker.take_cloud(cloud(alone))  # a thin cloud is no empty room
    assert (len(node.centres()), node.input.counts.in_sparse_cells) == (1, 0)


@pytest.mark.parametrize('rays', [False, True])
def test_a_cell_is_held_by_any_point_in_it(rays):
    node = Node(self_filter='none', least_points=2, keep=1.0, rays=rays)
    one, wall = [[1.01, 0.01, 0.01]], [[3.01, 0.01, 0.01]] * 2
    node.taker.take_cloud(cloud(2 * one + wall, stamp=100.0))
    for now in (100.7, 101.4, 102.1):
        node.clock.now = now
        node.taker.take_cloud(cloud(one + wall, stamp=now))
        assert near(node.centres(), [[1.05, 0.05, 2.05], [3.05, 0.05, 2.05]])
        counts = node.input.counts
        assert (counts.held_cells, counts.in_sparse_cells) == (1, 0)
    node.clock.now = 103.2
    node.taker.take_cloud(cloud([*wall, [0.01, 1.01, 0.01]], stamp=103.2))
    assert near(node.centres(), [[3.05, 0.05, 2.05]])
    assert node.input.counts.in_sparse_cells == 1


def test_a_message_of_any_size_is_refused_before_it_is_read():
    node = Node('octomap')
    full = Plain(header=header('mast', 100.0), id='ColorOcTree', binary=False, resolution=0.1)
    for told, each in (({'binary': True}, 2), ({'id': 'OcTree'}, 5), ({}, 8)):
        most = each * MOST_NODES
        message = Plain(**{**vars(full), **told}, data=array.array('b', bytes(most + 40)))
        with pytest.raises(RuntimeError, match=f'at most {most} are taken'):
            node.input.take_octomap(message)
    field = Plain(name='x', offset=0, datatype=7, count=1)
    with pytest.raises(RuntimeError, match='5000 fields; at most'):
        node.taker.take_cloud(cloud([[1, 0, 0]], fields=[field] * 5000))


def test_the_order_of_points_does_not_matter():
    points = np.random.default_rng(3).uniform(-2, 2, (500, 3))
    one, other = Node(self_filter='none'), Node(self_filter='none')
    one.taker.take_cloud(cloud(points))
    other.taker.take_cloud(cloud(points[::-1]))
    assert one.centres().tobytes() == other.centres().tobytes()


def test_a_map_that_is_cleared_while_one_is_made_stays_cleared(monkeypatch):
    node = Node(self_filter='none')

    def cleared(*cells):
        node.input.forget()
        return real(*cells)

    real = obstacles.shape_of
    monkeypatch.setattr(obstacles, 'shape_of', cleared)
    with pytest.raises(RuntimeError, match='cleared'):
        node.taker.take_cloud(cloud([[1, 0, 0]]))
    assert node.centres() is None


def octomap(cells, frame='mast', stamp=100.0):
    data = array.array('b', binary_of_cells(cells).data)
    told = {'id': 'OcTree', 'binary': True, 'resolution': cells.resolution, 'data': data}
    return Plain(header=header(frame, stamp), **told)


def test_an_octomap_stands_in_its_frame():
    node = Node('octomap')
    node.move(99.9, [1.0, 0.0, 0.0], yaw=np.pi / 2)
    node.move(100.0, [1.0, 0.0, 0.0], yaw=np.pi / 2)
    cells = Cells.of_points([[0.55, 0.05, 0.05]], 0.1)
    node.input.take_octomap(octomap(cells, 'arm', 99.95))
    assert near(node.centres(), [[1.0 - 0.05, 0.55, 0.05]])
    node.clock.now = 100.1
    node.move(100.1, [2.0, 0.0, 0.0])
    node.input.take_octomap(octomap(cells, 'arm', 100.1))  # posed elsewhere, and at rest again
    assert near(node.centres(), [[2.55, 0.05, 0.05]])
    assert frozenset(['s::world/post', 'obstacles::octomap/map']) not in node.pairs()[0]
    with node.live.reading() as held:
        assert held.log.warnings == []
    with pytest.raises(RuntimeError, match='no leaves'):
        node.input.take_octomap(octomap(Cells.of_points(np.zeros((0, 3)), 0.1)))
    assert len(node.centres()) == 1


def test_an_octomap_that_takes_long_to_read_is_as_old_as_its_stamp(monkeypatch):
    node = Node('octomap')
    node.move(100.0, [0, 0, 0])

    def slowly(message):
        node.clock.now += 60.0
        return cells_from_octomap(message)

    monkeypatch.setattr(obstacles, 'cells_from_octomap', slowly)
    cells = Cells.of_points([[0.05, 0.05, 0.05]], 0.1)
    node.input.take_octomap(octomap(cells, 'arm', 100.0))
    assert len(node.centres()) == 1
    assert node.age() == pytest.approx(60.0, abs=1e-6)


def transform(parent, child, x, stamp):
    p, q = Plain(x=x, y=0.0, z=0.0), Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    return Plain(
        header=header(parent, stamp), child_frame_id=child,
        transform=Plain(translation=p, rotation=q),
    )  # fmt: skip


def test_a_frame_that_only_tf_knows_hangs_on_one_of_the_scene(monkeypatch):
    monkeypatch.setattr(moments, 'PATIENCE', 0.05)
    node = Node(self_filter='none', tf=TfInput)

    def hear(*transforms, static=False):
        with node.live.editing():
            node.tf.hear(Plain(transforms=list(transforms)), static=static)

    hear(transform('/mast', 'optical', 1.0, 0.0), static=True)
    node.taker.take_cloud(cloud([[0, 1, 0]], 'optical'))
    assert near(node.centres(), [[1.05, 1.05, 2.05]])
    node.input.forget()
    # One that moves is kept from when it is asked about.
    hear(transform('optical', 'head', 1.0, 99.9))
    with pytest.raises(RuntimeError, match='head'):
        node.taker.take_cloud(cloud([[0, 1, 0]], 'head', 100.0))
    hear(transform('optical', 'head', 2.0, 100.0))
    hear(transform('optical', 'head', 3.0, 100.1))
    node.taker.take_cloud(cloud([[0, 1, 0]], 'head', 100.05))
    assert near(node.centres(), [[3.55, 1.05, 2.05]])
    with pytest.raises(RuntimeError, match='TF'):
        node.taker.take_cloud(cloud([[0, 1, 0]], 'nowhere'))


BOX = (-1.0, -1.0, 1.0, 1.0, 1.0, 3.0)


@pytest.mark.parametrize(
    ('points', 'kept'),
    [
        ([[0.55, 0.0, 0.0], [1.55, 0, 0], [0, 0, -1.55], [0, -0.55, 0.55]], [0, 3]),
        ([[1.55, 0.0, 0.0], [3.05, 0, 0], [0, 0, 1.95]], [0]),  # none: the nearest
    ],
)
def test_what_lies_beyond_the_box_is_left_out_but_never_all(points, kept):
    node = Node(self_filter='none', box=BOX)
    node.taker.take_cloud(cloud(points))
    cells = Cells.of_points(np.array(points)[kept] + [0, 0, 2], 0.1)
    assert near(node.centres(), cells.centres())
    assert node.input.counts.out_of_box == len(points) - len(kept)


def test_beside_a_box_that_holds_but_the_robot_the_nearest_point_counts():
    node = Node(self_filter='scene', box=(2.5, -1.0, -1.0, 3.5, 1.0, 1.0))
    node.move(99.9, [0, 0, 0])
    node.move(100.1, [0, 0, 0])
    node.taker.take_cloud(cloud([[3.0, 0.0, -2.0], [4.05, 0.05, -1.95], [4.45, 0.05, -1.95]]))
    assert near(node.centres(), [[4.05, 0.05, 0.05]])
    assert (node.input.counts.on_bodies, node.input.counts.out_of_box) == (1, 1)


@pytest.mark.parametrize(
    ('box', 'kept'),
    [
        ((-1.0, -1.0, 1.0, 0.14, 1.0, 3.0), 2),  # the second one reaches in
        ((-1.0, -1.0, 1.0, 0.09, 1.0, 3.0), 1),
        ((-9.0, -1.0, 1.0, -8.0, 1.0, 3.0), 1),
    ],
)
def test_cells_of_an_octomap_are_those_that_reach_into_the_box(box, kept):
    node = Node('octomap', box=box)
    cells = Cells.of_points([[0.05, 0.05, 0.05], [0.15, 0.05, 0.05], [0.35, 0.05, 0.05]], 0.1)
    node.input.take_octomap(octomap(cells))
    assert near(node.centres(), cells.centres()[:kept] + np.array([0.0, 0.0, 2.0]))
    assert node.input.counts.out_of_box == len(cells) - kept
