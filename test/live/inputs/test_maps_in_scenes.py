"""Sensed maps keep to themselves: beside users' sources, other scenes, TF and joint values."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.sensing_node import SCENE, Node, cloud, header, stamp_of
from live.inputs.tf_messages import at, message, transform
from live.live_scenes import live_scene

from drake_geom_ros.geometry import CollisionFilterDeclaration, GeometrySet, Role
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene import map_placing
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes import map_update
from drake_geom_ros.live.scene.changes.addition import addition, exchange
from drake_geom_ros.live.scene.prepared_scene import prepared
from drake_geom_ros.live.scene.scene_rules import Blind
from drake_geom_ros.live.services import files, obstacles, scene, shapes
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import ProximityRule, RuleMonitor
from drake_geom_ros.scene_files import ObstacleSource, read_scene
from drake_geom_ros.sensed_maps import Cells

WALLS = """
sources: [obstacles]
geometries:
- {name: wall, source: obstacles, shape: {type: box, size: [1, 1, 1]}}
"""
ROBOT = """<robot name="r"><link name="base"/>
<link name="l"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="base"/><child link="l"/><axis xyz="1 0 0"/>
<limit lower="-5" upper="5" effort="1" velocity="1"/></joint></robot>"""
PROXIMITY, ILLUSTRATION = 1, 2  # of Role.msg
MOVED = SCENE.replace('position: [0, 0, 2]', 'position: [5, 0, 2]')


def test_walls_of_a_source_called_as_that_of_maps_are_no_map():
    live = live_scene(WALLS)
    with pytest.raises(RuntimeError, match='maps: none'):
        obstacles.clear_obstacles(live, Plain(map='wall'), Plain())
    response = Plain(cells=None)
    obstacles.clear_obstacles(live, Plain(map=''), response)
    assert response.cells == 0
    with live.reading() as held:
        assert held.model.names.geometry('obstacles::world/wall') is not None
        assert 'obstacles' in held.description().sources


def test_no_map_is_put_into_a_source_of_that_name():
    with pytest.raises(RuntimeError, match=r"has a source 'obstacles'.*another name"):
        Node(scene=WALLS)
    node = Node()
    for change in (
        lambda held: held.replace(prepared(read_scene(WALLS))),
        lambda held: held.make(addition(read_scene(WALLS))),
        lambda held: held.make(exchange(held, [held.model.names.source('s')], read_scene(WALLS))),
    ):
        with node.live.editing() as held, pytest.raises(RuntimeError, match='obstacles'):
            change(held)
    with node.live.reading() as held:
        assert set(held.maps.by_name) == {'points'}
        assert held.model.names.frame('s::arm') is not None


def test_only_messages_change_what_is_the_maps():
    node = Node()
    shape = Plain(type=1, dimensions=[0.1])
    asked = [
        (scene.detach, Plain(frame='obstacles::points', pose_given=False)),
        (
            scene.attach,
            Plain(frame='obstacles::points', parent='s::mast', touch_links=[], pose_given=False),
        ),
        (
            scene.attach,
            Plain(frame='s::mast', parent='obstacles::points', touch_links=[], pose_given=False),
        ),
    ]
    for serve, request in asked:
        with pytest.raises(RuntimeError, match='sensed maps'):
            serve(node.live, request, Plain(pose=None))
    role = Plain(role=PROXIMITY, properties=[])
    for serve, told in (
        (scene.remove_geometry, {}),
        (scene.register_frame, {'source': 'obstacles', 'name': 'x', 'parent': ''}),
        (scene.remove_role, {'role': PROXIMITY}),
        (scene.remove_source, {'source': 'obstacles'}),
        (shapes.change_shape, {'shape': shape}),
        (shapes.assign_role, {'role': role, 'assign': 1}),
    ):
        request = Plain(geometry='obstacles::points/map', frame_group=0, **told)
        with pytest.raises(RuntimeError, match='sensed maps'):
            serve(node.live, request, Plain())
    with node.live.editing() as held:
        before = set(held.model.names.frame_names.values())
        for sources in (
            [held.model.maps_source],
            [held.model.names.source('s'), held.model.maps_source],
        ):
            with pytest.raises(RuntimeError, match='sensed maps'):
                held.make(exchange(held, sources, read_scene(SCENE)))
        assert set(held.model.names.frame_names.values()) == before


def test_roles_to_be_drawn_by_are_for_anybody_to_give_to_a_map_and_to_take():
    node = Node(self_filter='none')
    node.move(100.0, [0, 0, 0])
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    before = node.pairs()
    geometry, role = 'obstacles::points/map', Plain(role=ILLUSTRATION, properties=[])
    shapes.assign_role(node.live, Plain(geometry=geometry, role=role, assign=0), Plain())
    response = Plain()
    scene.remove_role(node.live, Plain(geometry=geometry, role=ILLUSTRATION), response)
    assert response.count == 1
    assert node.pairs() == before


def test_a_map_of_a_file_that_goes_with_the_scene_is_told_of(tmp_path):
    node = Node(self_filter='none')
    node.live.files = FileAccess([str(tmp_path)])
    (tmp_path / 'seen.xyz').write_text('3 3 3\n4 4 4\n')
    asked = Plain(path=str(tmp_path / 'seen.xyz'), resolution=0.1)
    obstacles.load_obstacles(node.live, asked, Plain())

    def load(**changes):
        told = {'path': '', 'text': SCENE, 'format': 'yaml', 'srdf': '', 'replaced_sources': []}
        response = Plain()
        files.load_scene(node.live, Plain(**{**told, **changes}), response)
        return response.message

    assert load(replace=False, replaced_sources=['s']) == ''
    with node.live.reading() as held:
        assert set(held.maps.by_name) == {'points', 'file'}
    lost = load(replace=True)
    assert 'obstacles::file/map of 2 cells' in lost
    assert 'load_obstacles' in lost
    with node.live.editing() as held:
        assert set(held.maps.by_name) == {'points'}
        assert held.log.warnings == [lost]
    assert load(replace=True) == ''


def test_a_rule_about_a_map_goes_on_in_the_scene_that_takes_its_place():
    node = Node()
    node.move(100.0, [0, 0, 0])
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    rule = ProximityRule('r', ('s::arm',), ('obstacles::points',), enter=0.1, leave=0.2)
    with node.live.editing() as held:
        held.bind_rules()
        held.rules.add([rule])
        held.replace(prepared(read_scene(SCENE)))
        assert held.rules.rules == (rule,)
        assert held.rules.take_events() == []
        # The map of the old scene is none of the new one: it waits, and answers say so.
        assert 'obstacles::points' in held.waiting().frames
    assert node.input.counts.taken == 0


def in_between(node, change):
    """Have something happen while the next cloud is taken."""
    zones = node.taker.filter.zones

    def changed(*asked):
        change()
        return zones(*asked)

    node.taker.filter.zones = changed


def test_a_cloud_of_the_old_scene_is_not_put_into_the_new_one():
    for change in ('replace', 'swap'):
        node = Node(self_filter='none')

        def another_scene(node=node, change=change):
            with node.live.editing() as held:
                if change == 'replace':
                    held.replace(prepared(read_scene(MOVED)))
                else:
                    held.make(exchange(held, [held.model.names.source('s')], read_scene(MOVED)))

        in_between(node, another_scene)
        with pytest.raises(RuntimeError, match='while the message was taken'):
            node.taker.take_cloud(cloud([[1, 0, 0]]))
        assert node.centres() is None


def test_what_was_cleared_while_a_cloud_was_taken_stays_cleared():
    node = Node(self_filter='none', keep=10.0)
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    clear = node.live, Plain(map='points'), Plain()
    in_between(node, lambda: obstacles.clear_obstacles(*clear))
    with pytest.raises(RuntimeError, match='cleared'):
        node.taker.take_cloud(cloud([[0, 2, 0]]))
    assert node.centres() is None
    del node.taker.filter.zones
    node.taker.take_cloud(cloud([[0, 2, 0]]))
    assert len(node.centres()) == 1


def test_a_map_that_is_cleared_leaves_the_others_what_they_are():
    """Their ids, ages, filters and rules."""
    node = Node(self_filter='none')
    node.move(100.0, [0, 0, 0])
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    cells = Cells.of_points([[0.5, 0.5, 0.5]], 0.1)
    shape = map_update.shape_of(cells, 0.0)
    with node.live.editing() as held:
        since = held.clocks.arrival().since(100.0)
        for name in ('file', 'other'):
            seen = map_update.Sighting(
                Cells.of_points([[0.5, 0.5, 0.5]], 0.1),
                shape,
                RigidTransform(),
                since,
                stamp_of(100),
            )
            map_placing.stand(held, name)
            held.make(map_update.showing(held, name, seen))
        held.model.scene_graph.collision_filter_manager().Apply(
            CollisionFilterDeclaration().ExcludeBetween(
                GeometrySet([held.maps.by_name['other'].geometry]),
                GeometrySet([held.model.names.geometry('s::arm/hand')]),
            )
        )
        rule = ProximityRule('r', ('obstacles::file',), ('s::arm',), enter=1.0, leave=1.1)
        held.bind_rules()
        held.rules.add([rule])
        before = dict(held.maps.by_name)
    pairs, _ = node.pairs()
    response = Plain(cells=None)
    obstacles.clear_obstacles(node.live, Plain(map='points'), response)
    assert response.cells == 1
    with node.live.reading() as held:
        assert {n: held.maps.by_name[n] for n in ('file', 'other')} == {
            n: before[n] for n in ('file', 'other')
        }
        assert held.maps.by_name['points'].geometry != before['points'].geometry
        assert held.maps.by_name['points'].cells is None
    left, waiting = node.pairs()
    assert waiting == 1
    assert left == {p: d for p, d in pairs.items() if 'obstacles::points/map' not in p}
    with node.live.editing() as held:
        held.bind_rules()
        assert held.rules.rules == (rule,)
    obstacles.clear_obstacles(node.live, Plain(map='file'), response)
    with node.live.reading() as held:
        assert set(held.maps.by_name) == {'points', 'other'}
    obstacles.clear_obstacles(node.live, Plain(map=''), response)
    with node.live.reading() as held:
        assert set(held.maps.by_name) == {'points'}


def test_what_others_posed_stays_where_it_is_when_a_map_comes(tmp_path):
    """Joint values are older than the poses that came since, in whatever scene."""
    (tmp_path / 'r.urdf').write_text(ROBOT)
    (tmp_path / 's.yaml').write_text(
        'sources: [s]\nframes: [{name: mast, source: s, pose: {}, static: true}]\n'
        'robots: [{name: r, urdf: r.urdf, pose: {}}]'
    )
    node = Node(scene=str(tmp_path / 's.yaml'), self_filter='none')
    inputs = PoseInputs(None, JointInput(node.live.clocks, 1.0, by_default=True))

    def posed(*, pose=None, joint=None):
        """Return where the link stands, and how old that is, once something came."""
        told = Plain(
            header=header('world', node.clock.now), source='', frame_names=['r::l'], frame_ids=[]
        )
        values = Plain(header=told.header, name=['j'], position=[joint], velocity=[])
        with node.live.editing() as held:
            if pose is not None:
                told.poses = [pose, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
                inputs.take_poses(held, told)
            elif joint is not None:
                inputs.take_joint_states(held, values)
            else:
                inputs.follow(held)
            link = held.model.names.frame('r::l')
            return held.query.X_WF(link).translation()[0], held.poses.ages_by_name()['r::l']

    assert posed(joint=0.7)[0] == 0.7
    node.clock.now = 100.1
    assert posed(pose=3.0) == (3.0, 0.0)
    node.taker.take_cloud(cloud([[1, 0, 0]], stamp=100.1))
    assert posed() == (3.0, 0.0)
    with node.live.editing() as held:  # a change of the model itself
        held.make(Change(lambda graph, _: graph.RegisterSource('another')))
    assert posed() == (3.0, 0.0)
    assert posed(joint=0.8)[0] == 0.8  # who comes last counts, as ever


def test_a_map_makes_nobody_pose_anew_what_tf_told_before():
    node = Node(tf=TfInput, self_filter='none')

    def hear():
        with node.live.editing() as held:
            node.tf.hear(message(transform('world', 'arm', at(1.0), 99.0)), static=False)
            return node.tf.pose(held)

    assert hear() == 1
    node.taker.take_cloud(cloud([[0, 1, 0]]))
    with node.live.editing() as held:
        assert node.tf.follow(held) == 0
        assert not node.tf.hangs_on_any(held, {held.model.names.frame('s::mast').get_value()})


def test_the_frame_of_a_map_has_no_name_in_tf_nor_for_poses():
    node = Node(tf=TfInput, self_filter='none')
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    before = node.centres()
    with node.live.editing() as held:
        for name in ('points', 'obstacles/points'):
            told = message(transform('world', name, at(50.0), 100.0))
            node.tf.hear(told, static=False)
            node.tf.pose(held)
        asked = Plain(
            header=header('world', 100.0), source='', frame_names=['obstacles::points'],
            frame_ids=[], poses=[9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        )  # fmt: skip
        with pytest.raises(RuntimeError, match='sensed map'):
            held.poses.take(asked)
        asked.frame_ids, asked.frame_names = [held.maps.by_name['points'].frame.get_value()], []
        with pytest.raises(RuntimeError, match='sensed map'):
            held.poses.take(asked)
    np.testing.assert_array_equal(node.centres(), before)
    with pytest.raises(RuntimeError, match='sensed map'):
        node.taker.take_cloud(cloud([[1, 0, 0]], frame='obstacles::points'))


def test_a_frame_of_the_scene_called_as_a_map_keeps_its_name():
    node = Node(scene=SCENE.replace('name: mast', 'name: points'), self_filter='none')
    node.taker.take_cloud(cloud([[0.01, 0.01, 0.01]], frame='points'))
    assert np.allclose(node.centres(), [[0.05, 0.05, 2.05]])


def test_rules_are_about_the_same_pairs_whatever_a_map_holds(monkeypatch):
    node = Node(self_filter='none')
    node.move(100.0, [0, 0, 0])
    rule = ProximityRule('r', ('s::arm',), ('obstacles::points',), enter=0.1, leave=0.2)
    bound = []
    bind = RuleMonitor.bind

    def counted(*asked):
        bound.append(1)
        return bind(*asked)

    monkeypatch.setattr(RuleMonitor, 'bind', counted)
    blind = Blind(frozenset(), frozenset())
    nearest = []
    with node.live.editing() as held:
        held.bind_rules()
        held.rules.add([rule])
    bound.clear()
    for distance in (0.35, 0.15, 0.55):
        node.taker.take_cloud(cloud([[distance + 0.01, 0.01, -1.99]]))
        with node.live.editing() as held:
            held.bind_rules()
            assert not held.rules.is_measured
            held.rules.decide(node.clock.now, held.query, blind)
            nearest += [(s.why is not None) for s in held.rules.states()]
    assert nearest == [False, True, False]
    assert not bound
    with node.live.editing() as held:  # what is reported changes, and then pairs do
        geometry = held.model.names.geometry('s::arm/hand')
        held.make(
            Change(
                lambda graph, _: graph.RemoveRole(
                    held.model.names.source('s'), geometry, Role.kProximity
                )
            )
        )
        held.bind_rules()
    assert bound


def test_a_map_that_comes_after_answers_is_where_its_cells_are():
    """Its frame, which waited, is posed at the origin, where it stood unposed: that is no move."""
    node = Node()
    node.add(ObstacleSource('depth', 'depth_image', '~/obstacles/depth'))
    for stamp in (101.0, 102.0):
        node.clock.now = stamp
        node.move(stamp, [0.0, 0.0, 1.0])
        _, waiting = node.pairs()
        assert waiting == 2
        node.taker.take_cloud(cloud([[0.55, 0.05, -0.95]], 's::mast', stamp))
        found, waiting = node.pairs()
        assert found[frozenset(('s::arm/hand', 'obstacles::points/map'))] == pytest.approx(0.4)
        assert waiting == 1
        obstacles.clear_obstacles(node.live, Plain(map=''), Plain(cells=None))
        node.pairs()
