"""A cycle computes what somebody listens to, and reports the rest with reasons; without ROS."""

from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import Topic, live_scene

from drake_geom_ros.geometry import CollisionFilterDeclaration, FramePoseVector, GeometrySet
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.live.outputs.contact_topic import NOBODY, ContactTopic
from drake_geom_ros.live.outputs.cycle import Cycle
from drake_geom_ros.live.outputs.effects import NO_SUBSCRIBER, Beside
from drake_geom_ros.live.outputs.level_costs import LevelCosts
from drake_geom_ros.live.outputs.replays import Replays
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene

TEXT = """
frames:
  - {name: a, pose: {}}
  - {name: b, pose: {position: [0.25, 0, 0]}}
geometries:
  - {name: ball, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, frame: b, shape: {type: sphere, radius: 0.1}}
"""
MORE = """
sources: [more]
frames: [{name: c, source: more, pose: {}}, {name: d, source: more, pose: {}}]
geometries:
  - {name: ball, source: more, frame: c, shape: {type: sphere, radius: 0.2}}
  - {name: ball, source: more, frame: d, shape: {type: sphere, radius: 0.2}}
"""
COMPUTED = ('update', 'broadphase', 'filter', 'compile', 'cache', 'narrowphase')


class Message:
    """Any message: a header, and whatever is filled in."""

    def __init__(self):
        self.header = Plain(frame_id='', stamp=None)


class PlainTopic(Topic):
    """Keeps what was in the messages, which are filled in again."""

    make_message = Message

    def publish(self, message):
        super().publish(dict(vars(message)))


class Asked:
    """A scene that counts how often it is asked for its query object."""

    def __init__(self, scene):
        self._scene = scene
        self.times = 0

    def moment(self):
        return self._scene.moment()

    def waiting(self):
        return self._scene.waiting()

    @property
    def model(self):
        return self._scene.model

    @property
    def poses(self):
        return self._scene.poses

    @property
    def rules(self):
        return self._scene.rules

    @property
    def maps(self):
        return self._scene.maps

    @property
    def query(self):
        self.times += 1
        return self._scene.query


@pytest.fixture
def live():
    return live_scene(TEXT)


@pytest.fixture
def asked(scene):
    return Asked(scene)


@pytest.fixture
def topics():
    return {name: PlainTopic(0) for name in ('penetrations', 'signed_distances', 'cycle_report')}


@pytest.fixture
def pressed():
    """Return the topic of contact surfaces."""
    return PlainTopic(0)


def no_rules():
    """Return what decides about proximity rules, of which there is none."""
    topics = RuleTopics(*(Topic() for _ in range(5)))
    return RuleEvents(topics, Plain(), lambda: RuleSettings(1.0), lambda count, seconds: None)


@pytest.fixture
def cycle(live, topics, pressed):
    costs = LevelCosts(live, topics['cycle_report'])
    return Cycle(topics, costs, Replays(lambda: ('', 0)), no_rules(), contacts(pressed))


def contacts(topic):
    """Return what publishes contact surfaces on a topic."""
    return ContactTopic(topic, Message, lambda: False, lambda: False, pytest.fail)


def run(asked, cycle, topics, *names):
    """Run a cycle with listeners to these topics; return the report."""
    for name, topic in topics.items():
        topic.listeners = int(name in names)
    cycle.run(asked, 2, 1e-4, 0.1, 0.0)
    return topics['cycle_report'].published[-1] if 'cycle_report' in names else None


def effects(report):
    ran = zip(report['effects'], report['effect_ran'], strict=True)
    return [name for name, yes in ran if yes]


PRESSING = """
frames:
  - {name: a, pose: {}}
  - {name: b, pose: {position: [0.15, 0, 0]}}
  - {name: c, pose: {position: [0, 0.15, 0]}}
geometries:
  - {name: ball, frame: a, shape: {type: sphere, radius: 0.1}, roles: {proximity: {hydroelastic: {
     compliance_type: compliant, hydroelastic_modulus: 1e5, resolution_hint: 0.05}}}}
  - {name: ball, frame: b, shape: {type: sphere, radius: 0.1}, roles: {proximity: {hydroelastic: {
     compliance_type: rigid, resolution_hint: 0.05}}}}
  - {name: ball, frame: c, shape: {type: sphere, radius: 0.1}}
"""


def reasons_of(report):
    told = zip(report['effects'], report['effect_reasons'], strict=True)
    return {name: reason for name, reason in told if reason}


def test_where_nothing_can_press_nothing_is_computed_and_that_is_told(
    asked, cycle, topics, pressed
):
    pressed.listeners = 1
    report = run(asked, cycle, topics, 'cycle_report')
    assert effects(report) == ['poses', 'publish ~/contact_surfaces']
    assert reasons_of(report)['contact surfaces'] == cycle.contacts.told == NOBODY
    (message,) = pressed.published
    assert (message['participants'], list(message['id_a']), message['scene_version']) == (
        *(0, []),
        topics['cycle_report'].published[-1]['scene_version'],
    )


@pytest.mark.parametrize('live', [live_scene(PRESSING)])
def test_surfaces_are_computed_while_somebody_listens(live, asked, cycle, topics, pressed):
    report = run(asked, cycle, topics, 'cycle_report')
    assert reasons_of(report)['contact surfaces'] == NO_SUBSCRIBER
    assert cycle.contacts.told == 'not asked for'
    pressed.listeners = 1
    for others in ((), ('penetrations',), ('penetrations', 'signed_distances')):
        report = run(asked, cycle, topics, 'cycle_report', *others)
        assert {'contact surfaces', 'publish ~/contact_surfaces'} <= set(effects(report))
        message = pressed.published[-1]
        assert (message['participants'], len(message['id_a'])) == (2, 1)
        assert len(message['point_pair_id_a']) == 1  # of the one without properties
        assert cycle.contacts.told == '1, and 1 pair that overlaps without'
    assert len({bytes(m['area']) for m in pressed.published}) == 1


def test_without_subscribers_nothing_is_asked_or_published(asked, cycle, topics):
    for _ in range(3):
        run(asked, cycle, topics)
    assert cycle.count == 3
    assert asked.times == 0
    assert [topic.published for topic in topics.values()] == [[], [], []]


def test_a_report_alone_asks_for_nothing(asked, cycle, topics):
    report = run(asked, cycle, topics, 'cycle_report')
    assert asked.times == 0
    assert effects(report) == ['poses']
    reasons = dict(zip(report['effects'], report['effect_reasons'], strict=True))
    assert [reasons[name] for name in COMPUTED] == [NO_SUBSCRIBER] * len(COMPUTED)
    assert report['unpublished_messages'] == 3
    assert report['broadphase_pairs'] == report['geometries_updated'] == 0


def test_only_what_somebody_listens_to_is_published(asked, cycle, topics):
    report = run(asked, cycle, topics, 'cycle_report', 'penetrations')
    assert asked.times == 1
    assert 'publish ~/penetrations' in effects(report)
    assert topics['signed_distances'].published == []
    assert report['unpublished_messages'] == 2
    # 0.05 m apart: penetrations alone do not look that far, distances do.
    assert (report['broadphase_pairs'], sum(report['method_pairs'])) == (0, 0)
    report = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    assert (report['broadphase_pairs'], sum(report['method_pairs'])) == (1, 1)


def test_both_results_are_one_narrow_phase(asked, cycle, topics):
    report = run(asked, cycle, topics, 'cycle_report', 'penetrations', 'signed_distances')
    assert asked.times == 1
    assert sum(report['method_pairs']) == 1
    assert [len(topics[name].published) for name in topics] == [1, 1, 1]


def test_what_rests_is_published_again_and_not_computed(asked, cycle, topics):
    run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    report = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    assert (report['cached_pairs'], report['method_pairs']) == (1, [])
    assert 'narrowphase' not in effects(report)
    first, second = (list(m['distance']) for m in topics['signed_distances'].published)
    assert first == second == [pytest.approx(0.05)]


def seconds_of(report):
    return dict(zip(report['effects'], report['effect_seconds'], strict=True))


def test_filters_and_the_cache_have_seconds_of_their_own(live, asked, cycle, topics):
    with live.editing() as scene:
        scene.make(addition(read_scene(MORE)))
        names = scene.model.names
        pair = GeometrySet([names.geometry('a/ball'), names.geometry('b/ball')])
        filters = scene.model.scene_graph.collision_filter_manager()
        filters.Apply(CollisionFilterDeclaration().ExcludeWithin(pair))
    first = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    assert (first['broadphase_pairs'], first['filtered_pairs']) == (6, 1)
    assert seconds_of(first)['filter'] > 0.0
    assert seconds_of(first)['cache'] == 0.0
    # One of the four moves: of its three pairs kernels answer, of the other two the memory.
    with live.editing() as scene:
        frame = scene.model.names.frame('c')
        scene.model.context.UpdateFramePoses(
            FramePoseVector({frame: RigidTransform([0, 0.01, 0])})
        )
    report = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    seconds = seconds_of(report)
    assert (report['cached_pairs'], report['method_pairs']) == (2, [3])
    assert seconds['cache'] > 0.0
    assert seconds['narrowphase'] > 0.0
    assert sum(seconds.values()) <= report['seconds']
    # Nothing moves: all that is left is to look it up.
    seconds = seconds_of(run(asked, cycle, topics, 'cycle_report', 'signed_distances'))
    assert seconds['cache'] > 0.0
    assert seconds['narrowphase'] == seconds['filter'] == 0.0


def test_who_does_not_read_the_report_does_not_pay_for_its_seconds(live, asked, cycle, topics):
    for names, detailed in ((('cycle_report',), True), (('penetrations',), False)):
        run(asked, cycle, topics, *names)
        with live.reading() as scene:
            assert state_of(scene.model.context).engine.detailed == detailed


def test_what_waits_for_a_pose_is_counted_and_named(live, asked, cycle, topics):
    with live.editing() as scene:
        scene.make(addition(read_scene(MORE.replace(', pose: {}', ''))))
    report = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    assert report['waiting_frames'] == ['more::c', 'more::d']
    assert report['waiting_pairs'] == 5
    assert len(topics['signed_distances'].published[-1]['id_a']) == 1
    with live.editing() as scene:
        frames = map(scene.model.names.frame, 'cd')
        scene.model.context.UpdateFramePoses(
            FramePoseVector(dict.fromkeys(frames, RigidTransform()))
        )
    report = run(asked, cycle, topics, 'cycle_report', 'signed_distances')
    assert (report['waiting_frames'], report['waiting_pairs']) == ([], 0)
    assert len(topics['signed_distances'].published[-1]['id_a']) == 6


def test_what_is_done_beside_the_cycles_is_told_once(live, asked, topics):
    beside = [
        Beside.publishing('point_distances', lambda: NO_SUBSCRIBER),
        Beside.publishing('scene', lambda: 'not yet'),
    ]
    costs = LevelCosts(live, topics['cycle_report'])
    cycle = Cycle(
        *(topics, costs, Replays(lambda: ('', 0)), no_rules()),
        *(contacts(PlainTopic(0)), beside),
    )

    def told():
        report = run(asked, cycle, topics, 'cycle_report')
        names = ('effects', 'effect_ran', 'effect_counts', 'effect_seconds', 'effect_reasons')
        rows = list(zip(*(report[name] for name in names), strict=True))
        assert report['unpublished_messages'] == 3  # of the cycle's own
        return rows[-2:]

    points, scene = 'publish ~/point_distances', 'publish ~/scene'
    nothing = [(points, False, 0, 0.0, NO_SUBSCRIBER), (scene, False, 0, 0.0, 'not yet')]
    assert told() == nothing
    for count in (3, 4):
        beside[0].did(count, 0.25)
    assert told() == [(points, True, 7, 0.5, ''), nothing[1]]
    beside[1].did(0, 0.125)
    assert told() == [nothing[0], (scene, True, 0, 0.125, '')]
