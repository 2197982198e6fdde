"""What arrives at a large scene is made ready beside the cycles: these find it done.

Where others have the scene is looked at from another thread, in the middle of the making: no
clock is read. How long cycles wait for what, ``bench.ros.arrivals`` measures.
"""

import threading
import weakref
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.live_scenes import Clock, live_scene

from drake_geom_ros.geometry import CandidatePairs, QueryObject
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.scene_content import content_of
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.scene import scene_model
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.live.scene.changes.map_update import Sighting, has_many, shape_of, showing
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.map_placing import stand
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.services import (
    files,
    filters,
    obstacles,
    proximity_rules,
    scene,
    shapes,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.sensed_maps import Cells

pytestmark = pytest.mark.clock

REACH = 0.5  # [m] of the distances that cycles ask for
PATIENCE = 60.0  # [s]
SCENE = """
sources: [s, rest]
frames: [{name: a, source: s, pose: {}}]
geometries:
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: post, source: rest, shape: {type: box, size: [1, 1, 1]}, pose: {position: [1, 0, 0]}}
proximity_rules:
- {name: near, set_a: a, level: stop, enter: 0.05, leave: 2}
"""
PART = """
frames: [{name: part, source: parts, pose: {position: [0, 5, 0]}}]
"""
OTHER_BALL = """
geometries: [{name: ball, source: others, frame: other, shape: {type: sphere, radius: 0.1}}]
"""
MORE = SCENE.replace('s, rest', 't').replace('source: s', 'source: t')
MORE = MORE.replace('source: rest', 'source: t').replace('name: post', 'name: other')
NO_RULE = MORE.partition('proximity_rules')[0]
REST = NO_RULE.replace('[t]', '[rest]').replace('source: t', 'source: rest')
ROBOT = """<robot name="robot">
<link name="l0"><collision><geometry><sphere radius="0.1"/></geometry>
</collision></link><link name="l1"><collision><geometry><sphere radius="0.1"/></geometry>
</collision></link><joint name="j" type="revolute"><parent link="l0"/><child link="l1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture
def live(monkeypatch):
    monkeypatch.setattr(scene_model, '_MANY', 0)  # any scene is large
    live = live_scene(SCENE, Clock(100.0))
    monkeypatch.setattr(filters, '_MANY', 0)  # and any declaration is long
    with live.editing() as held:
        stand(held, 'points')
        held.make(addition(read_scene(PART)))
    return live


def cycle(held, x):
    """Pose the ball, and return what a cycle asks, and whether it had to list the near pairs."""
    stamp = Plain(sec=1, nanosec=int(1000 * x) + 1)
    header = Plain(stamp=stamp, frame_id='')
    row = [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    held.poses.take(Plain(header=header, source='', frame_names=['s::a'], frame_ids=[], poses=row))
    found = held.query.ComputeSignedDistancePairwiseClosestPoints(REACH)
    return sorted(np.round(found.distance, 6).tolist()), held.query.effects().near_list_made


def register(live):
    place = Plain(position=Plain(x=0.0, y=0.3, z=0.0), orientation=Plain(x=0, y=0, z=0, w=1))
    shape = Plain(type=1, dimensions=[0.1], vertices=[], triangles=[], mesh_uri='')
    role = Plain(role=1, properties=[])
    ball = Plain(
        frame='world', parent_geometry='', name='g', pose=place, shape=shape, roles=[role]
    )
    shapes.register_geometries(live, Plain(source='rest', geometries=[ball]), Plain())


NEAR = Cells.of_points([[0.05, 0.35, 0.05]], 0.1)


def load(live, text=NO_RULE, **fields):
    asked = {'path': '', 'text': text, 'format': '', 'srdf': '', 'replace': False}
    files.load_scene(live, Plain(**{**asked, 'replaced_sources': [], **fields}), Plain())


def attach(live):
    place = {'pose_given': False, 'part_of_robot': True, 'touch_links': []}
    request = Plain(frame='parts::part', parent='s::a', **place)
    scene.attach(live, request, Plain(pose=Plain(position=Plain(), orientation=Plain())))


def apply(live):
    names = Plain(frames=['s::a'], geometries=[], frame_ids=[], geometry_ids=[])
    statement = Plain(operation=1, set_a=names, set_b=Plain(**{**vars(names), 'frames': []}))
    declaration, response = Plain(statements=[statement]), Plain()
    filters.apply_transient_filter(
        live, Plain(declaration=declaration, lease=0.0, owner=''), response
    )
    return response.filter_id


def add_rule(live):
    rule = Plain(
        name='more', set_a=['s::a'], set_b=['rest'], level=3, enter=0.01, leave=0.02, hold=0.0,
        enter_after=0.0, min_time_to_contact=0.0, when_stale='', scale=[], acknowledge=False,
        min_points=0,
        joint_names=[], decelerations=[], stopping_times=[], reaction_time=0.0, margin=0.0,
        max_speed=0.0, stop_category=0,
    )  # fmt: skip
    proximity_rules.add_proximity_rule(live, Plain(rule=rule), Plain())


def see(live, cells=NEAR):
    sighting = Sighting(
        cells, shape_of(cells, 0.0), RigidTransform(), ALWAYS, Plain(sec=1, nanosec=0)
    )
    with live.editing() as held:
        change = showing(held, 'points', sighting)
    live.change(change, calls_for_more=has_many(cells))


def another_robot(live):
    robot = RobotInput(live)
    live.rehearse, rehearse = (lambda query: None), live.rehearse
    robot.take(ROBOT)
    live.rehearse = rehearse
    robot.take(ROBOT.replace('"l1"', '"l2"'))


def detach(live):
    with live.editing() as held:
        part, carrier = (held.model.names.frame(name) for name in ('parts::part', 's::a'))
        held.make(attachment(held, part, carrier))
    request = Plain(frame='parts::part', pose_given=False)
    scene.detach(live, request, Plain(pose=Plain(position=Plain(), orientation=Plain())))


def remove_filter(live):
    live.rehearse, rehearse = (lambda query: None), live.rehearse
    filter_id = apply(live)
    live.rehearse = rehearse
    response = Plain()
    filters.remove_filter(live, Plain(filter_id=filter_id, owner=''), response)
    assert response.removed


ARRIVALS = {
    'robot_description': lambda live: RobotInput(live).take(ROBOT),
    'robot_description of another one': another_robot,
    'load_scene': load,
    'load_scene with a rule': lambda live: load(live, MORE.replace('name: near', 'name: other')),
    'load_scene with replaced_sources': lambda live: load(live, REST, replaced_sources=['rest']),
    'register_geometries': register,
    'register_frame': lambda live: scene.register_frame(
        live, Plain(source='s', name='b', parent='', frame_group=0), Plain()
    ),
    'remove_geometry': lambda live: scene.remove_geometry(
        live, Plain(geometry='rest::world/post'), Plain()
    ),
    'remove_source': lambda live: scene.remove_source(live, Plain(source='rest'), Plain()),
    'attach': attach,
    'detach': detach,
    'apply_transient_filter': apply,
    'remove_filter': remove_filter,
    'add_proximity_rule': add_rule,
    'clear_obstacles': lambda live: obstacles.clear_obstacles(live, Plain(map=''), Plain()),
    'a map': see,
}  # fmt: skip


@pytest.mark.parametrize('arrival', ARRIVALS)
def test_cycles_go_on_while_it_is_made_ready_and_find_all_done(live, arrival):
    with live.editing() as held:
        before, _ = cycle(held, 0.0)
        held.bind_rules()
    seen, asked = [], []

    def in_between():
        with live.editing() as held:
            seen.append(cycle(held, 0.01 * (1 + len(seen))))

    def rehearse(query):
        asked.append(query.ComputeSignedDistancePairwiseClosestPoints(REACH))
        other = threading.Thread(target=in_between)
        other.start()
        other.join(PATIENCE)
        assert not other.is_alive()  # nobody has the scene

    live.rehearse = rehearse
    ARRIVALS[arrival](live)
    assert len(asked) == len(seen) == 2  # once more of what the rule is about
    assert [len(found) for found, _ in seen] == [len(before)] * 2  # about the scene of before
    with live.editing() as held:
        places = held.query.X_WF(held.model.names.frame('s::a')).translation()
        assert places[0] == 0.02  # what came in between holds
        if arrival != 'a map':  # which is placed and welded now
            assert not cycle(held, 0.0)[1]
        held.bind_rules()
        assert not any(state.is_entered for state in held.rules.states())
        distances, _ = cycle(held, 0.0)
        fresh = QueryObject(held.model.context.copy()).ComputeSignedDistancePairwiseClosestPoints(
            REACH
        )
        assert distances == sorted(np.round(fresh.distance, 6).tolist())


def test_the_model_is_copied_while_others_have_the_scene(live, monkeypatch):
    register(live)  # it leaves a copy for snapshots
    copying, copies = Model.copy, []

    def have_the_scene():
        with live.editing():
            pass

    def copied(model):
        other = threading.Thread(target=have_the_scene)
        other.start()
        other.join(PATIENCE)
        assert not other.is_alive()  # nobody has the scene
        copies.append(model)
        return copying(model)

    monkeypatch.setattr(Model, 'copy', copied)
    scene.remove_source(live, Plain(source='parts'), Plain())
    assert copies
    with live.reading() as held:
        assert held.model.names.geometry('rest::world/g')
        inspector = held.model.inspector
        assert 'parts' not in map(inspector.GetName, inspector.GetAllSourceIds())


def test_what_a_draft_replaced_ends_with_the_draft(live):
    with live.reading() as held:
        source = held.model.names.source('parts')
        (frame,) = held.model.inspector.FramesForSource(source)
        record = weakref.ref(content_of(held.model.scene_graph).model.frames[frame])
        change = removal(held, source)
    draft, _ = live.make_ready(change)
    with live.editing() as held:
        assert held.take_over(draft)
        assert frame not in content_of(held.model.scene_graph).model.frames
    assert record() is not None  # it was not freed while the scene was held
    del draft, held
    assert record() is None


def test_a_map_that_comes_while_a_robot_is_replaced_waits_again(live):
    """Its cells are not in the scene that takes the place of this one."""
    live.map_sources = MapSources({'points': Plain(forget=lambda: None)})
    robot = RobotInput(live)
    robot.take(ROBOT)
    seen = []

    def rehearse(query):
        if not seen:
            seen.append(query)
            see(live)

    live.rehearse = rehearse
    assert 'replaces' in robot.take(ROBOT.replace('"l1"', '"l2"'))
    with live.reading() as held:
        assert 'obstacles::points' in held.waiting().frames
        assert held.maps.by_name['points'].cells is None


@pytest.mark.parametrize('count', [1, 20_001])
def test_a_map_of_few_cells_in_a_small_scene_needs_no_draft(live, monkeypatch, count):
    monkeypatch.setattr(scene_model, '_MANY', 1000)
    drafts, make_ready = [], live.make_ready
    monkeypatch.setattr(
        live, 'make_ready', lambda change: drafts.append(change) or make_ready(change)
    )
    cells = Cells.of_points(np.arange(count)[:, np.newaxis] * [0.2, 0.0, 0.0], 0.1)
    see(live, cells)
    assert len(drafts) == (count > 20_000)
    with live.reading() as held:
        assert held.maps.by_name['points'].cells is cells


def test_rules_are_made_ready_for_the_copy_though_the_live_scene_changes_meanwhile(
    live, monkeypatch
):
    with live.editing() as held:
        cycle(held, 0.0)
        held.bind_rules()
    matches, changed = CandidatePairs.matches, []

    def meanwhile(pairs, others):
        answer = matches(pairs, others)
        if not changed:
            changed.append(True)
            with live.editing() as held:
                held.make(addition(read_scene(PART.replace('part', 'other') + OTHER_BALL)))
                held.bind_rules()
        return answer

    with live.reading() as held:
        draft = SceneDraft(held.model, held.rules)
    monkeypatch.setattr(CandidatePairs, 'matches', meanwhile)
    draft.get_ready()
    assert changed
    assert np.array_equal(draft.rules.watched.ids, draft.rules.pairs.ids)
