"""The live scene without ROS: ages, leases, replacement, what-if, all or nothing."""

import math
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FrameId,
    GeometrySet,
)
from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.scene_files import read_scene, to_yaml

TEXT = """
sources: [s]
frames:
  - {name: a, source: s}
  - {name: b, source: s, pose: {position: [1, 0, 0]}}
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


class Clock:
    """A clock that the test sets."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def live(clock):
    live = LiveScene('exact', clock)
    live.add(read_scene(TEXT))
    return live


def message(**frames):
    poses = [float(v) for x in frames.values() for v in (x, 0, 0, 0, 0, 0, 1)]
    header = Plain(stamp=Plain(sec=1, nanosec=0), frame_id='')
    return Plain(header=header, source='s', frame_names=list(frames), frame_ids=[], poses=poses)


def distance(live):
    a, b = (live.names.geometry(f's::{f}/ball') for f in 'ab')
    return live.query.ComputeSignedDistancePairClosestPoints(a, b).distance


def test_frames_stand_where_the_file_puts_them_until_posed(live):
    assert distance(live) == pytest.approx(0.8)
    assert live.take_poses(message(a=-1)) == 1
    assert distance(live) == pytest.approx(1.8)


def test_ages_of_poses(live, clock):
    assert math.isinf(live.oldest_pose_age())
    live.take_poses(message(a=0))
    clock.now += 2.0
    assert math.isinf(live.oldest_pose_age())
    live.take_poses(message(b=1))
    clock.now += 0.5
    assert live.oldest_pose_age() == pytest.approx(2.5)
    assert live.pose_ages() == pytest.approx({'s::a': 2.5, 's::b': 0.5})


def test_an_empty_scene_has_no_old_poses(clock):
    assert LiveScene('exact', clock).oldest_pose_age() == 0.0


def test_a_refused_message_leaves_everything(live, clock):
    live.take_poses(message(a=0, b=1))
    clock.now += 1.0
    bad = message(a=5, b=math.nan)
    bad.header.stamp.sec = 9
    with pytest.raises(RuntimeError, match='not finite'):
        live.take_poses(bad)
    assert distance(live) == pytest.approx(0.8)
    assert live.oldest_pose_age() == pytest.approx(1.0)
    assert live.newest_stamp.sec == 1


def test_what_if_is_not_what_is(live):
    before = distance(live)
    query = live.view(message(b=3)).query
    a, b = (live.names.geometry(f's::{f}/ball') for f in 'ab')
    assert query.ComputeSignedDistancePairClosestPoints(a, b).distance == pytest.approx(2.8)
    assert distance(live) == before


def test_a_lease_ends_and_renewal_prolongs_it(live, clock):
    manager = live.scene_graph.collision_filter_manager()
    balls = GeometrySet([live.names.geometry(f's::{f}/ball') for f in 'ab'])
    declaration = CollisionFilterDeclaration().ExcludeWithin(balls)
    kept, lost, free = (manager.ApplyTransient(declaration) for _ in range(3))
    live.lease(kept, 1.0)
    live.lease(lost, 1.0)
    live.lease(free, 0.0)
    clock.now += 0.9
    assert live.expire_filters() == []
    live.lease(kept, 1.0)
    clock.now += 0.2
    assert live.expire_filters() == [lost]
    assert [manager.IsActive(f) for f in (kept, lost, free)] == [True, False, True]
    live.lease(kept, 0.0)
    clock.now += 1e6
    assert live.expire_filters() == []


def test_a_scene_that_cannot_be_loaded_changes_nothing(live):
    text, version = to_yaml(live.description()), live.version
    other = TEXT.replace('[s]', '[t]').replace('source: s', 'source: t')
    other = read_scene(other.replace('frame: b', 'frame: nowhere'))
    for change in (live.add, live.replace):
        with pytest.raises(RuntimeError, match='nowhere'):
            change(other)
        assert (to_yaml(live.description()), live.version) == (text, version)
    with pytest.raises(RuntimeError, match='taken'):
        live.add(read_scene(TEXT))
    assert (to_yaml(live.description()), live.version) == (text, version)


def test_replacing_grows_the_version_and_keeps_the_text(live):
    text, version = to_yaml(live.description()), live.version
    assert live.replace(read_scene(text)) == (2, 2)
    assert live.version > version
    assert to_yaml(live.description()) == text
    live.clear()
    assert live.names.frame('world') == live.inspector.world_frame_id()
    with pytest.raises(RuntimeError, match='no frame'):
        live.names.frame('s::a')
    assert isinstance(live.names.frame('world'), FrameId)


def test_the_accuracy_of_queries_that_name_none(live):
    live.set_accuracy('bound')
    live.take_poses(message(a=0, b=0.15))
    results = live.query.ComputeSignedDistancePairwiseClosestPoints()
    assert results.method.tolist() == [4]
    live.set_accuracy('exact')
    results = live.query.ComputeSignedDistancePairwiseClosestPoints()
    assert results.method.tolist() == [1]
