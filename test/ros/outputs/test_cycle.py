"""A cycle computes what somebody listens to, and reports the rest with reasons; without ROS."""

from types import SimpleNamespace as Plain

import pytest
from ros.live_scenes import live_scene

from drake_geom_ros.ros.outputs.cycle import NO_SUBSCRIBER, Cycle
from drake_geom_ros.ros.outputs.level_costs import LevelCosts
from drake_geom_ros.ros.outputs.replays import Replays

TEXT = """
frames:
  - {name: a}
  - {name: b, pose: {position: [0.25, 0, 0]}}
geometries:
  - {name: ball, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, frame: b, shape: {type: sphere, radius: 0.1}}
"""
COMPUTED = ('update', 'broadphase', 'filter', 'compile', 'cache', 'narrowphase')


class Message:
    """Any message: a header, and whatever is filled in."""

    def __init__(self):
        self.header = Plain(frame_id='', stamp=None)


class Topic:
    """A publisher with some subscribers that keeps what it was given last."""

    def __init__(self):
        self.listeners = 0
        self.published = []

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        self.published.append(dict(vars(message)))


class Asked:
    """A scene that counts how often it is asked for its query object."""

    def __init__(self, scene):
        self._scene = scene
        self.times = 0

    def moment(self):
        return self._scene.moment()

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
    return {name: Topic() for name in ('penetrations', 'signed_distances', 'cycle_report')}


@pytest.fixture
def cycle(live, topics):
    kinds = dict.fromkeys(('PenetrationPairs', 'SignedDistancePairs', 'CycleReport'), Message)
    costs = LevelCosts(live, topics['cycle_report'])
    return Cycle(Plain(**kinds), topics, costs, Replays(lambda: ('', 0)))


def run(asked, cycle, topics, *names):
    """Run a cycle with listeners to these topics; return the report."""
    for name, topic in topics.items():
        topic.listeners = int(name in names)
    cycle.run(asked, 2, 1e-4, 0.1, 0.0)
    return topics['cycle_report'].published[-1] if 'cycle_report' in names else None


def effects(report):
    ran = zip(report['effects'], report['effect_ran'], strict=True)
    return [name for name, yes in ran if yes]


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
    assert report['unpublished_messages'] == 2
    assert report['broadphase_pairs'] == report['geometries_updated'] == 0


def test_only_what_somebody_listens_to_is_published(asked, cycle, topics):
    report = run(asked, cycle, topics, 'cycle_report', 'penetrations')
    assert asked.times == 1
    assert 'publish ~/penetrations' in effects(report)
    assert topics['signed_distances'].published == []
    assert report['unpublished_messages'] == 1
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
