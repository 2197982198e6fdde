"""Zones: seen by the rules that name them, by closed forms, and by nobody else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.sensing_node import Node, cloud
from live.live_scenes import Topic
from live.scene.test_scene_rules import TYPES, Ruled
from ros.scene_calls import poses

from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import Level, ProximityRule, RuleError, Why
from drake_geom_ros.scene_files import load_scene

FRAMES = """
sources: [base]
frames:
- {name: base_link, source: base, static: false, pose: {}}
- {name: crate, static: false, pose: {position: [9, 0, 0]}}
"""
BODIES = """
geometries:
- {name: hull, source: base, frame: base_link, shape: {type: box, size: [0.7, 0.5, 0.4]}}
- {name: lid, frame: crate, shape: {type: box, size: [0.2, 0.2, 0.2]}}
- {name: pillar, pose: {position: [0, 8, 0]}, shape: {type: cylinder, radius: 0.2, length: 2}}
"""
# An L of two boxes, in which a convex hull would be wrong.
ZONES = """
- {name: ahead, source: base, frame: base_link, sensor: true,
   shape: {type: polygon, points: [[0.4, -0.3], [1, -0.3], [1, 0.3], [0.4, 0.3]], height: [0, 1]}}
- {name: corner, source: base, frame: base_link, sensor: true,
   shape: {type: polygon, points: [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], height: 1}}
"""
RULES = """
proximity_rules:
- {name: ahead, set_a: ahead, set_b: crate, level: stop, enter: 0.0, leave: 0.02}
- {name: corner, set_a: base_link/corner, set_b: [crate, world], level: slow, enter: 0.0,
   leave: 0.1, scale: [[0, 0.3], [0.1, 1]]}
"""
SCENE = FRAMES + BODIES + ZONES + RULES
AHEAD = [((0.4, -0.3, 0.0), (1.0, 0.3, 1.0))]
CORNER = [((0, 0, 0), (2, 1, 1)), ((0, 0, 0), (1, 2, 1))]
few = settings(max_examples=25, deadline=None)
places = st.tuples(st.floats(-1.0, 3.0), st.floats(-1.0, 3.0), st.floats(-0.5, 1.5))


def gap(boxes, centre, half=0.1):
    """Return the distance [m] of a cube from boxes along the same axes; 0: they overlap."""
    gaps = [
        np.maximum(np.subtract(low, np.add(centre, half)), np.subtract(centre, half) - high)
        for low, high in boxes
    ]
    return min(float(np.linalg.norm(np.maximum(each, 0.0))) for each in gaps)


class Cell(Ruled):
    """A live scene with zones, and a crate that moves."""

    def __init__(self, text=SCENE, **options):
        super().__init__(text, **options)

    def put(self, place, base=(0, 0, 0)):
        """Pose the crate and the base; return by rule whether it is entered."""
        with self.live.editing() as scene:
            scene.poses.take(poses(['crate'], [place], source='scene'))
            scene.poses.take(poses(['base_link'], [base], source='base'))
            self.events.look_at(scene, None, 0.0)
            return {state.rule.name: state.is_entered for state in scene.rules.states()}


@pytest.fixture(scope='module')
def cell():
    return Cell()


@few
@given(place=places, base=st.tuples(*[st.floats(-2.0, 2.0)] * 3))
def test_a_zone_is_entered_as_its_boxes_are(cell, place, base):
    cell.put((50, 0, 0))
    entered = cell.put(np.add(place, base), base)
    for name, boxes in (('ahead', AHEAD), ('corner', CORNER)):
        distance = gap(boxes, place)
        if distance > 1e-9:
            assert not entered[name]
        elif all(abs(gap(boxes, place, 0.1 - inset)) < 1e-9 for inset in (1e-6,)):
            assert entered[name]


def test_speed_follows_the_zones(cell):
    scales = []
    for place in ((50, 0, 0), (0.5, 1.5, 0.5), (0.5, 2.15, 0.5), (0.7, 0, 0.5)):
        cell.put((50, 0, 0))
        cell.put(place)
        with cell.live.editing() as scene:
            scales.append((scene.rules.speed_scale(), scene.rules.scale_about('base').scale))
    expected = np.array([1.0, 0.3, 0.65, 0.0])  # and the same for the base, which bears the zones
    np.testing.assert_allclose(scales, np.stack([expected, expected], axis=1), rtol=0, atol=1e-9)


def test_what_rules_say_of_a_zone(cell):
    cell.put((50, 0, 0))
    told = len(cell.topics.events.published)
    cell.put((0.7, 0, 0.5))
    events = cell.topics.events.published[told:]
    pairs = {(message.geometry_a[0], message.geometry_b[0]) for message in events}
    assert ('scene::crate/lid', 'base::base_link/ahead') in {*pairs, *{p[::-1] for p in pairs}}
    assert np.isfinite(events[0].pose_a).all()
    assert np.isfinite(events[0].pose_b).all()


def test_no_rule_sees_a_zone_that_it_does_not_name():
    rules = """
proximity_rules:
- {name: all of base, set_a: base, level: warn, enter: 0.0, leave: 0.1}
- {name: by star, set_a: 'base_link/*', level: warn, enter: 0.0, leave: 0.1}
- {name: others, set_a: crate, level: warn, enter: 0.0, leave: 0.1}
"""
    cell = Cell(FRAMES + BODIES + ZONES + rules)
    assert not any(cell.put((0.7, 0, 0.5)).values())
    with cell.live.editing() as scene:
        assert [state.pairs for state in scene.rules.states()] == [2, 2, 2]
        assert scene.rules.with_zones(scene.query) is scene.query


def test_a_zone_of_which_poses_are_old_is_entered(cell):
    cell.put((50, 0, 0))
    assert ('ahead', True) in cell.wait(2.0)
    with cell.live.editing() as scene:  # now only the base, and so the zone, is old
        scene.poses.take(poses(['crate'], [(50, 0, 0)], source='scene'))
    cell.wait()
    with cell.live.editing() as scene:
        ahead = scene.rules.states()[0]
    assert (ahead.is_entered, ahead.why) == (True, Why.STALE)


def test_rules_follow_zones_that_change():
    cell = Cell()
    assert not cell.put((1.3, 0, 0.5))['ahead']
    with cell.live.editing() as scene:
        inspector, graph = scene.model.inspector, scene.model.scene_graph
        zone = next(g for g in inspector.GetAllGeometryIds() if inspector.GetName(g) == 'ahead')
        source = inspector.GetOwningSourceId(inspector.GetFrameId(zone))
        for on in ({}, {'context': scene.model.context}):
            X_FG = RigidTransform([0.5, 0, 0])
            graph.ChangeShape(
                **on, source_id=source, geometry_id=zone, shape=inspector.GetShape(zone), X_FG=X_FG
            )
        scene.model.refresh()
    assert cell.put((1.3, 0, 0.5))['ahead']
    with cell.live.editing() as scene:
        scene.set_accuracy('bound')
    assert cell.put((1.3, 0, 0.5))['ahead']
    with cell.live.editing() as scene:
        scene.make(removal(scene, scene.model.names.source('base')))
    cell.wait()
    assert {'ahead', 'corner'} <= {
        rule
        for message in cell.topics.events.published
        for rule, why in zip(message.rule, message.why, strict=True)
        if why == Why.GONE
    }


def test_no_rule_about_stopping_is_about_a_zone(cell):
    with cell.live.editing() as scene:
        rule = ProximityRule('x', ('base',), ('ahead',), Level.STOPPABLE, decelerations=(1.0,))
        with pytest.raises(RuleError, match='but for a zone, which no stoppable rule is about'):
            scene.rules.add([rule])


# Every other answer.


def loaded(text):
    graph = SceneGraph()
    names = load_scene(text, graph)
    context = graph.CreateDefaultContext()
    return graph, names, context, graph.get_query_output_port().Eval(context)


@pytest.fixture(scope='module')
def with_and_without():
    bodies = BODIES + '- {name: ball, frame: crate, shape: {type: sphere, radius: 0.3}}\n'
    return [loaded(FRAMES + bodies + zones) for zones in ('', ZONES)]


def answers(scene, place, points, end):
    """Return arrays of what may be asked of a scene without rules."""
    _, names, context, query = scene
    crate = names.frames['scene', 'crate']
    context.UpdateFramePoses(FramePoseVector({crate: RigidTransform(place)}))
    pairs = query.ComputeSignedDistancePairwiseClosestPoints()
    depths = query.ComputePointPairPenetration()
    near = query.ComputeSignedDistanceToPoint(points)
    motion = query.CheckMotion(FramePoseVector({crate: RigidTransform(end)}))
    inspector = query.inspector()
    listed = [names.name_of(int(value)) for value in inspector.candidate_matrix()[0]]
    return [
        *(pairs.distance, pairs.p_WCa, pairs.p_WCb, pairs.error_bound, pairs.nhat_BA_W),
        *(depths.depth, depths.p_WCa, near.distance, near.p_GN, near.grad_W, near.point_index),
        *(np.array(motion.times), motion.evaluations, motion.lower_bound),
        *([names.name_of(int(v)) for v in ids] for ids in (pairs.id_A, depths.id_A, near.id_G)),
        *(listed, inspector.candidate_matrix()[1], query.HasCollisions()),
        *(len(query.FindCollisionCandidates()), query.num_waiting_pairs()),
    ]


@few
@given(place=places, end=places, points=st.lists(places, min_size=1, max_size=4))
def test_a_zone_changes_no_other_answer(with_and_without, place, end, points):
    without, with_zones = (
        answers(scene, place, np.array(points), end) for scene in with_and_without
    )
    for one, other in zip(without, with_zones, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_zone_changes_no_planner(tmp_path):
    (tmp_path / 'arm.urdf').write_text("""<robot name="arm"><link name="a"/><link name="b">
<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>""")
    scene = f"""
robots: [{{name: arm, urdf: {tmp_path / 'arm.urdf'}}}]
geometries:
- {{name: post, pose: {{position: [0.6, 0.6, 0]}}, shape: {{type: sphere, radius: 0.1}}}}
"""
    zone = '- {name: z, sensor: true, shape: {type: box, size: [3, 3, 3]}}\n'
    clearances = []
    for text in (scene, scene + zone):
        graph = SceneGraph()
        names = load_scene(text, graph)
        checker = Checker(graph, Joints.of(names))
        clearances.append([checker.clearance(np.array([q])) for q in np.linspace(-3, 3, 50)])
    assert clearances[0] == clearances[1]


# Sensed maps.

MAPPED = """
sources: [s]
frames: [{name: base, source: s, pose: {}, static: true}, {name: mast, source: s, static: true,
  pose: {position: [0, 0, 2]}}]
geometries:
- {name: hull, source: s, frame: base, shape: {type: sphere, radius: 0.2}}
- {name: zone, source: s, frame: base, sensor: true, shape: {type: box, size: [2, 2, 1]}}
proximity_rules:
- {name: any, set_a: zone, set_b: obstacles, level: stop, enter: 0.0, leave: 0.05}
- {name: four, set_a: zone, set_b: obstacles, level: stop, enter: 0.0, leave: 0.05, min_points: 4}
"""
MAST = np.array([0.0, 0.0, 2.0])
RESOLUTION = 0.1
REACH = 0.5 * np.sqrt(3.0) * RESOLUTION  # [m] of a cell about its centre


class Mapped:
    """A node with a cloud of points, and a zone about its base."""

    def __init__(self, **changes):
        self.node = Node(scene=MAPPED, resolution=RESOLUTION, **changes)
        self.topics = RuleTopics(*(Topic() for _ in range(5)))
        self.events = RuleEvents(self.topics, TYPES, lambda: RuleSettings(1.0), lambda *_: None)

    def see(self, points):
        """Take a cloud; return by rule whether it is entered, and the centres of cells."""
        self.node.clock.now += 0.1
        self.node.taker.take_cloud(cloud(np.array(points) - MAST, 'mast', self.node.clock.now))
        with self.node.live.editing() as scene:
            self.events.look_at(scene, None, 0.0)
            states = {s.rule.name: s.is_entered for s in scene.rules.states()}
            return states, scene.maps.by_name['points'].cells.centres()


@pytest.fixture(scope='module')
def mapped():
    return Mapped()


def outside(centres):
    """Return the distance [m] of points from the zone."""
    beyond = np.maximum(np.abs(centres) - [1.0, 1.0, 0.5], 0.0)
    return np.linalg.norm(beyond, axis=1)


near_zone = st.tuples(*[st.floats(-1.6, 1.6)] * 2, st.floats(-0.4, 0.9))


@few
@given(st.lists(near_zone, min_size=1, max_size=9))
def test_a_rule_counts_cells(mapped, points):
    far = [[0.0, 3.0, 0.0]]
    for _ in range(2):
        mapped.see(far)
    kept = [p for p in points if np.linalg.norm(p) > 0.5]  # beside the robot is another test
    entered, centres = mapped.see(kept + far)
    apart = outside(np.asarray(centres))
    if np.count_nonzero(apart == 0.0) >= 4:
        assert entered['four']
    if np.count_nonzero(apart <= REACH + 1e-9) < 4:
        assert not entered['four']
    if (apart == 0.0).any():
        assert entered['any']


def test_what_is_seen_beside_the_robot_is_not_counted_away():
    mapped = Mapped()
    mapped.see([[0, 3.0, 0]])
    entered, _ = mapped.see([[0, 3.0, 0], [0.23, 0, 0]])
    assert entered == {'any': True, 'four': True}


def test_a_zone_about_a_map_that_is_silent_is_entered(mapped):
    for _ in range(2):
        entered, _ = mapped.see([[0, 3.0, 0]])
    assert entered == {'any': False, 'four': False}
    mapped.node.clock.now += 5.0
    with mapped.node.live.reading() as scene:
        mapped.events.look_again(scene)
        assert [state.why for state in scene.rules.states()] == [Why.STALE] * 2
