"""Rules of level STOPPABLE in a live scene: joints and poses in, events, scales and limits out."""

import math
from itertools import pairwise
from types import SimpleNamespace as Plain

import pytest
from drake_geom_msgs import msg
from live.live_scenes import Clock, Topic, live_scene
from ros.scene_calls import poses
from std_msgs.msg import Float64

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.live.services.proximity_rules import add_proximity_rule
from drake_geom_ros.proximity_rules import RuleError, Why

ROD = """<robot name="rod"><link name="base"/>
<link name="rod"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.02 0.02"/></geometry>
</collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/>
</joint></robot>"""
# A rod that turns in the plane, a person who walks, and a post that stands.
SCENE = """
sources: [rod, person, things]
robots: [{{name: rod, urdf: {urdf}, pose: {{}}}}]
frames: [{{name: body, source: person, pose: {{position: [0, 5, 0]}}}}]
geometries:
- {{name: body, source: person, frame: body, shape: {{type: sphere, radius: 0.1}}}}
- {{name: post, source: things, pose: {{position: [0, -0.8, 0]}},
   shape: {{type: cylinder, radius: 0.05, length: 1}}}}
proximity_rules:
- {{name: stop, set_a: rod, level: stoppable, decelerations: 2.0, reaction_time: 0.05,
   margin: 0.02, max_speed: 1.0{more}}}
"""
TYPES = Plain(
    ProximityEvents=msg.ProximityEvents,
    ProximityRules=msg.ProximityRules,
    ProximityStates=msg.ProximityStates,
    SpeedLimits=msg.SpeedLimits,
    Stopping=msg.Stopping,
    Float64=Float64,
)
CYCLE = 0.01  # [s]


class Cell:
    """A live scene with a turning rod, and cycles that decide as a node does."""

    def __init__(self, folder, more=''):
        (folder / 'rod.urdf').write_text(ROD)
        self.clock = Clock(1000.0)
        text = SCENE.format(urdf=folder / 'rod.urdf', more=more)
        self.live = live_scene(text, self.clock)
        self.joints = JointInput(self.live.clocks, 1.0, by_default=True)
        self.topics = RuleTopics(*(Topic() for _ in range(5)))
        settings = RuleSettings(1.0)
        self.events = RuleEvents(self.topics, TYPES, lambda: settings, lambda pairs, _: None)

    def cycle(self, angle, speed=math.nan, person=None):
        """Let a cycle pass; return what ~/stopping says."""
        self.clock.now += CYCLE
        with self.live.editing() as scene:
            self.joints.take(scene, joint_state(angle, self.clock.now, speed), 0.0)
            if person is not None:
                scene.poses.take(poses(['body'], [person], source='person'))
            self.events.look_at(scene, None, 0.0)
        return self.topics.stopping.published[-1]

    @property
    def scale(self):
        return self.topics.speed_scale.published[-1].data

    def last_event(self):
        message = self.topics.events.published[-1]
        return message.entered[-1], Why(message.why[-1]), message

    def troubles(self):
        with self.live.reading() as scene:
            return scene.rules.troubles(watches_motion=True)


def joint_state(angle, now, speed):
    seconds = math.floor(now)
    stamp = Plain(sec=seconds, nanosec=round((now - seconds) * 1e9))
    velocity = [] if math.isnan(speed) else [speed]
    header = Plain(stamp=stamp, frame_id='')
    return Plain(header=header, name=['turn'], position=[angle], velocity=velocity, effort=[])


@pytest.fixture
def cell(tmp_path):
    return Cell(tmp_path)


def test_a_rod_that_cannot_stop_before_a_post_is_slowed_and_one_that_can_is_not(cell):
    far = cell.cycle(math.pi / 2, 1.0)
    assert (list(far.rules), list(far.clear), list(far.scale)) == (['stop'], [True], [1.0])
    assert cell.scale == 1.0
    assert far.stopping_time[0] >= 0.05 + 0.5
    # The post is at -90 degrees, 0.31 rad away: from 1 rad/s it takes 0.3 rad to stop.
    near = cell.cycle(-math.pi / 2 + 0.35, -1.0)
    assert list(near.clear) == [False]
    assert 0.0 < near.scale[0] < 1.0
    assert cell.scale == near.scale[0]
    entered, why, event = cell.last_event()
    assert (entered, why) == (True, Why.CANNOT_STOP)
    assert {event.geometry_a[-1], event.geometry_b[-1]} == {
        'rod::rod/collision_0',
        'things::world/post',
    }
    assert event.limit_distance[-1] == 0.02
    limit = cell.topics.speed_limit.published[-1]
    assert limit.angular[0] == pytest.approx(near.scale[0])
    assert limit.linear[0] >= near.scale[0] * 1.0
    away = cell.cycle(-math.pi / 2 + 0.35, 1.0)
    assert list(away.clear) == [True]
    assert cell.last_event()[:2] == (False, Why.CANNOT_STOP)


def test_people_near_the_way_slow_and_those_who_are_stale_grow(cell):
    here, away = (0.1, 1.45, 0.0), (0.0, 5.0, 0.0)
    assert cell.cycle(0.0, 1.0, away).clear[0]
    near = cell.cycle(0.8, 1.0, here)
    assert near.scale[0] < 1.0
    assert near.geometry_b[0] == 'person::body/body' or near.geometry_a[0] == 'person::body/body'
    cell.cycle(0.8, 1.0, (0.0, 2.0, 0.0))
    scales = []
    for _ in range(70):
        scales.append(cell.cycle(0.8, 1.0).scale[0])
    assert scales[0] == 1.0
    assert scales[-1] < 1.0
    assert all(after <= before + 0.02 for before, after in pairwise(scales))


def test_without_a_speed_nothing_is_proved(cell):
    message = cell.cycle(0.5)
    assert list(message.clear) == [False]
    assert 'nobody knows how fast rod::turn moves: ' in message.trouble[0]
    assert cell.scale == 0.0
    assert any('proves no stop' in trouble for trouble in cell.troubles())
    # A second stamped value tells the speed.
    assert cell.cycle(0.501).trouble[0] == ''


def test_a_stale_pose_stops_whoever_does_not_say_otherwise(tmp_path):
    for more, slowest in (('', 0.0), (', when_stale: keep', 1.0)):
        cell = Cell(tmp_path, more)
        cell.cycle(0.0, 0.2, (0.0, 50.0, 0.0))
        for _ in range(int(1.1 / CYCLE)):
            cell.cycle(0.0, 0.2)
        assert cell.scale == slowest


def test_before_joints_are_heard_it_is_entered(cell):
    with cell.live.editing() as scene:
        cell.events.look_at(scene, None, 0.0)
    assert cell.last_event()[0]
    assert cell.scale == 0.0


def test_time_that_goes_on_alone_counts(cell):
    cell.cycle(0.8, 1.0, (0.0, 2.2, 0.0))
    before = len(cell.topics.stopping.published)
    cell.clock.now += 0.5
    with cell.live.reading() as scene:
        cell.events.look_again(scene)
    later = cell.topics.stopping.published[-1]
    assert len(cell.topics.stopping.published) == before + 1
    assert later.reaction_time[0] > 0.5
    assert later.scale[0] < 1.0


def test_a_rule_about_joints_that_are_not_there_is_refused(cell):
    cell.cycle(0.0, 0.0)
    rule = msg.ProximityRule(
        name='other', set_a=['rod'], level=msg.ProximityRule.STOPPABLE, joint_names=['elbow'],
        decelerations=[1.0],
    )  # fmt: skip
    with pytest.raises(RuleError, match="'elbow', which means no joint"):
        add_proximity_rule(cell.live, Plain(rule=rule), Plain())
    rule.joint_names = ['turn']
    add_proximity_rule(cell.live, Plain(rule=rule), Plain())
    assert list(cell.cycle(0.0, 0.0).rules) == ['stop', 'other']


def test_there_are_no_ways_of_a_robot_that_has_left(cell):
    cell.cycle(0.5, 1.0)
    with cell.live.editing() as scene:
        frames, ways = scene.stopping.ways()
        assert (len(frames), len(ways)) == (1, 1)
        assert len(ways[0])
        scene.make(removal(scene, scene.model.names.source('person')))
        assert len(scene.stopping.ways()[1]) == 1
        scene.make(removal(scene, scene.model.names.source('rod')))
        assert len(scene.stopping.ways()[1]) == 0
