"""The live scene without ROS: ages, leases, replacement, what-if, all or nothing."""

import math
import threading
from dataclasses import replace
from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import live_scene

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FrameId,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    QueryObject,
    Sphere,
)
from drake_geom_ros.live.scene import scene_model
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import stand
from drake_geom_ros.live.scene.prepared_scene import prepared
from drake_geom_ros.live.scene.scene_rules import Blind
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import Level, ProximityRule
from drake_geom_ros.scene_files import read_scene, to_yaml

RULE = ProximityRule('near', ('s::a',), level=Level.WARN, enter=0.1, leave=1.0)

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {}}
  - {name: b, source: s, pose: {position: [1, 0, 0]}}
geometries:
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def live(clock):
    return live_scene(TEXT, clock)


def message(**frames):
    return message_of('s', **frames)


def message_of(source, **frames):
    poses = [float(v) for x in frames.values() for v in (x, 0, 0, 0, 0, 0, 1)]
    header = Plain(stamp=Plain(sec=1, nanosec=0), frame_id='')
    return Plain(header=header, source=source, frame_names=list(frames), frame_ids=[], poses=poses)


def distance(scene):
    a, b = (scene.model.names.geometry(f's::{f}/ball') for f in 'ab')
    return scene.query.ComputeSignedDistancePairClosestPoints(a, b).distance


def test_frames_stand_where_the_file_puts_them_until_posed(scene):
    assert distance(scene) == pytest.approx(0.8)
    assert scene.poses.take(message(a=-1)) == 1
    assert distance(scene) == pytest.approx(1.8)


def test_ages_of_poses(scene, clock):
    clock.now += 9.0
    assert scene.moment().oldest_pose_age == 0.0  # all rest where the file put them
    first, second = message(a=0), message(b=1)
    first.header.stamp.sec = int(clock.now)
    scene.poses.take(first)
    clock.now += 2.0
    assert scene.moment().oldest_pose_age == pytest.approx(2.0)
    second.header.stamp.sec = int(clock.now)
    scene.poses.take(second)
    clock.now += 0.5
    assert scene.moment().oldest_pose_age == pytest.approx(2.5)
    assert scene.poses.ages_by_name() == pytest.approx({'s::a': 2.5, 's::b': 0.5})


def test_a_pose_whose_old_stamp_is_repeated_is_not_new_again(scene, clock):
    clock.now = 1.5
    for second in range(90):
        scene.poses.take(message(a=0, b=1))  # stamped 1 s
        assert scene.moment().oldest_pose_age == pytest.approx(0.5 + second)
        clock.now += 1.0
    scene.poses.take(message(b=1))
    assert scene.poses.ages_by_name() == pytest.approx({'s::a': 90.5, 's::b': 90.5})


def test_an_empty_scene_has_no_old_poses(clock):
    assert LiveScene('exact', Clocks(clock)).view().moment.oldest_pose_age == 0.0


def test_a_refused_message_leaves_everything(scene, clock):
    good, bad = message(a=0, b=1), message(a=5, b=math.nan)
    good.header.stamp.sec = int(clock.now)
    scene.poses.take(good)
    clock.now += 1.0
    bad.header.stamp.sec = int(clock.now)
    with pytest.raises(RuntimeError, match='not finite'):
        scene.poses.take(bad)
    assert distance(scene) == pytest.approx(0.8)
    assert scene.moment().oldest_pose_age == pytest.approx(1.0)
    assert scene.moment().newest_stamp.sec == good.header.stamp.sec


@pytest.mark.clock
@pytest.mark.parametrize('door', [LiveScene.reading, LiveScene.editing, LiveScene.view])
def test_no_other_thread_has_the_scene_meanwhile(live, door):
    entered = threading.Event()

    def enter():
        got = door(live)
        if door is not LiveScene.view:
            with got:
                pass
        entered.set()

    thread = threading.Thread(target=enter)
    with live.editing() as scene:
        thread.start()
        assert not entered.wait(0.05)
        scene.poses.take(message(a=0, b=1))
    thread.join(60.0)
    assert entered.is_set()


def test_what_if_is_not_what_is(live, scene):
    before = distance(scene)
    query = live.view(message(b=3)).query
    a, b = (scene.model.names.geometry(f's::{f}/ball') for f in 'ab')
    assert query.ComputeSignedDistancePairClosestPoints(a, b).distance == pytest.approx(2.8)
    assert distance(scene) == before


def test_a_lease_ends_and_renewal_prolongs_it(scene, clock):
    manager = scene.model.scene_graph.collision_filter_manager()
    balls = GeometrySet([scene.model.names.geometry(f's::{f}/ball') for f in 'ab'])
    declaration = CollisionFilterDeclaration().ExcludeWithin(balls)
    kept, lost, free = (manager.ApplyTransient(declaration) for _ in range(3))
    scene.filters.lease(kept, 1.0)
    scene.filters.lease(lost, 1.0)
    scene.filters.lease(free, 0.0)
    clock.now += 0.9
    assert scene.filters.expire() == []
    scene.filters.lease(kept, 1.0)
    clock.now += 0.2
    assert scene.filters.expire() == [lost]
    assert [manager.IsActive(f) for f in (kept, lost, free)] == [True, False, True]
    scene.filters.lease(kept, 0.0)
    clock.now += 1e6
    assert scene.filters.expire() == []


def test_a_scene_that_cannot_be_loaded_changes_nothing(scene):
    text, version = to_yaml(scene.description()), scene.model.version
    other = TEXT.replace('[s]', '[t]').replace('source: s', 'source: t')
    other = read_scene(other.replace('frame: b', 'frame: nowhere'))
    for change in (lambda other: scene.make(addition(other)), prepared):
        with pytest.raises(RuntimeError, match='nowhere'):
            change(other)
        assert (to_yaml(scene.description()), scene.model.version) == (text, version)
    with pytest.raises(RuntimeError, match='taken'):
        scene.make(addition(read_scene(TEXT)))
    assert (to_yaml(scene.description()), scene.model.version) == (text, version)


def test_replacing_grows_the_version_and_keeps_the_text(scene):
    text, version = to_yaml(scene.description()), scene.model.version
    assert scene.replace(prepared(read_scene(text))) == (2, 2)
    assert scene.model.version > version
    assert to_yaml(scene.description()) == text
    assert isinstance(scene.model.names.frame('world'), FrameId)


def test_who_waits_for_a_pose_goes_on_waiting_in_a_scene_that_was_saved(scene):
    scene.make(addition(read_scene('sources: [t]\nframes: [{name: c, source: t}]')))
    for _ in range(2):
        assert scene.waiting().frames == ['t::c']
        text = to_yaml(scene.description())
        assert scene.replace(prepared(read_scene(text))) == (3, 2)
    scene.poses.take(message_of('t', c=2))
    assert scene.waiting()[:3] == ([], 0, 0)
    assert scene.waiting().in_words() == ''


def test_an_empty_scene_has_the_world_alone_and_goes_on_counting(clock):
    with LiveScene('exact', Clocks(clock), version=7).reading() as scene:
        assert scene.model.version == 7
    assert scene.model.names.frame('world') == scene.model.inspector.world_frame_id()
    with pytest.raises(RuntimeError, match='no frame'):
        scene.model.names.frame('s::a')


def test_the_accuracy_of_queries_that_name_none(scene):
    scene.set_accuracy('bound')
    scene.poses.take(message(a=0, b=0.15))
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert results.method.tolist() == [4]
    scene.set_accuracy('exact')
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert results.method.tolist() == [1]


def test_a_scene_with_cameras_has_what_takes_images_compiled_at_once(monkeypatch):
    """The first image of a node does not wait for it."""
    sizes = []

    def render_images(query, camera, *rest):
        sizes.append((camera.width, camera.height, camera.renderer_name))

    monkeypatch.setattr(QueryObject, 'render_images', render_images)
    live_scene(TEXT).compile_kernels()
    assert sizes == []
    live_scene(TEXT + 'cameras: [{name: eye, size: [64, 48], shows: proximity}]').compile_kernels()
    assert sizes == [(1, 1, 'exact_proximity')]


def test_a_scene_with_maps_has_what_measures_points_compiled_at_once(monkeypatch):
    """The first cycle with points beside a body does not wait for it."""
    asked = []
    method = QueryObject.ComputeSignedDistanceToPoint
    monkeypatch.setattr(
        QueryObject,
        'ComputeSignedDistanceToPoint',
        lambda query, *what: asked.append(query) or method(query, *what),
    )
    live = live_scene(TEXT)
    live.compile_kernels()
    assert asked == []
    with live.editing() as scene:
        stand(scene, 'points')
    live.compile_kernels()
    assert len(asked) == 1


MORE = """
sources: [t]
frames:
  - {name: c, source: t, pose: {position: [3, 0, 0]}}
  - {name: d, source: t, parent: c, pose: {position: [0, 2, 0]}}
  - {name: e, source: t}
geometries:
  - {name: ball, source: t, frame: c, shape: {type: sphere, radius: 0.1}}
  - {name: ball, source: t, frame: d, shape: {type: sphere, radius: 0.2}}
filters: [{exclude_within: [{source: t, frame: c}, {source: t, frame: d}]}]
"""


def told(live):
    with live.reading() as scene:
        results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
        return (
            to_yaml(scene.description()),
            [
                *zip(
                    *map(scene.model.inspector.full_names, (results.id_A, results.id_B)),
                    strict=True,
                )
            ],
            results.distance.tolist(),
            scene.model.names.labels.values(),
            scene.poses.ages_by_name(),
        )


def test_what_was_registered_on_a_copy_is_what_would_be_registered(clock, monkeypatch):
    """And nothing is registered again while the scene is held."""
    plain, live = live_scene(TEXT, clock), live_scene(TEXT, clock)
    description = read_scene(MORE)
    with plain.editing() as scene:
        assert scene.make(addition(description)) == (3, 2)
    monkeypatch.setattr(HeldScene, 'make', None)
    assert live.change(addition(description), calls_for_more=True) == (3, 2)
    one, other = told(plain), told(live)
    assert [*one[3]] == [*other[3]]
    assert one[:3] + one[4:] == other[:3] + other[4:]


@pytest.mark.parametrize('change', ['a frame', 'a filter', 'a shape', 'nothing but a pose'])
def test_what_changed_since_the_copy_was_made_stays(live, change):
    more = addition(read_scene(MORE))
    before, made = {}, []

    def meanwhile(graph, context):
        loaded = more.on(graph, context)
        made.append(loaded)
        if len(made) == 1:
            with live.editing() as scene:
                _change(scene, change)
                before.update(pairs_of(scene))
        return loaded

    assert live.change(replace(more, on=meanwhile), calls_for_more=True) == (3, 2)
    # A change of the scene has it registered anew, by other ids.
    assert len(made) == (1 if change == 'nothing but a pose' else 2)
    with live.editing() as scene:
        assert before.items() <= pairs_of(scene).items()
        assert (change == 'a frame') == (('s', 'late') in scene.model.names.labels.values())
        assert {*made[-1].frames.values()} <= {*scene.model.names.labels}
        # The scene goes on changing as ever.
        scene.make(
            Change(
                lambda graph, _: graph.RegisterFrame(
                    scene.model.names.source('t'), GeometryFrame('later')
                )
            )
        )
        assert ('t', 'later') in scene.model.names.labels.values()


def _change(scene, change):
    """Make a change of the scene of two balls, by its name."""
    source = scene.model.names.source('s')
    a, b = (scene.model.names.frame(f's::{f}') for f in 'ab')
    if change == 'a frame':
        scene.make(Change(lambda graph, _: graph.RegisterFrame(source, GeometryFrame('late'))))
    elif change == 'a filter':
        pair = GeometrySet(frame_ids=[a, b])
        manager = scene.model.scene_graph.collision_filter_manager()
        manager.Apply(CollisionFilterDeclaration().ExcludeWithin(pair))
    elif change == 'a shape':
        scene.make(
            Change(
                lambda graph, _: graph.ChangeShape(
                    source, scene.model.names.geometry('s::a/ball'), Sphere(0.3)
                )
            )
        )
    else:
        assert scene.poses.take(message(a=-1)) == 1


def pairs_of(scene):
    """Return the distances of all pairs by their names."""
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    names = map(scene.model.inspector.full_names, (results.id_A, results.id_B))
    return dict(zip(zip(*names, strict=True), results.distance.tolist(), strict=True))


def drafted(live, change):
    """Make a change on a draft, whatever the size of the scene, while the scene goes on."""
    draft, result = live.make_ready(Change(change))
    with live.editing() as scene:
        scene.poses.take(message(a=-1, b=3))
        assert scene.take_over(draft)
    return result


def one_more(live, name='more', x=4.0):
    with live.reading() as scene:
        source = scene.model.names.source('s')
    ball = GeometryInstance(RigidTransform([x, 0, 0]), Sphere(0.5), name)
    ball.set_proximity_properties(ProximityProperties())
    return drafted(live, lambda graph, on: graph.RegisterAnchoredGeometry(on, source, ball))


def test_a_draft_is_taken_over_at_the_poses_that_came_since(live, clock):
    with live.editing() as scene:
        scene.rules.take([RULE])
        scene.bind_rules()
    asked = []
    live.rehearse = lambda query: asked.append(query.ComputeSignedDistancePairwiseClosestPoints())
    geometry = one_more(live)
    assert [len(found) for found in asked] == [3, 2]  # of the draft, and of what rules ask of it
    with live.editing() as scene:
        assert scene.model.version == scene.moment().version
        assert scene.model.names.geometry('s::world/more') == geometry
        assert distance(scene) == pytest.approx(3.8)
        found = scene.query.ComputeSignedDistancePairwiseClosestPoints()
        assert sorted(found.distance) == pytest.approx([0.4, 3.8, 4.4])
        assert not scene.query.effects().near_list_made  # the draft has made it
        assert scene.poses.unknown_ages().frames == []
        # And goes on as ever.
        scene.poses.take(message(a=0, b=1))
        scene.bind_rules()
        scene.rules.decide(clock(), scene.query, Blind([], []))
        assert scene.rules.states()[0].pairs == 2
        assert scene.rules.states()[0].lowest == pytest.approx(0.8)


def test_a_draft_of_a_scene_that_changed_since_is_not_taken_over(live):
    draft, _ = live.make_ready(Change(lambda graph, on: graph.RegisterSource(on, 't')))
    with live.editing() as scene:
        scene.make(Change(lambda graph, _: graph.RegisterSource('u')))
        assert not scene.take_over(draft)
        assert scene.model.names.source('u') is not None


def test_a_large_scene_changes_by_a_draft_or_where_others_change_it_all_the_time_as_ever(
    live, monkeypatch
):
    monkeypatch.setattr(scene_model, '_MANY', 0)
    made = []

    def change(graph, context):
        made.append(context)
        if len(made) < least:
            with live.editing() as scene:
                scene.make(
                    Change(lambda graph, _: graph.RegisterSource(f'other {len(made)} {least}'))
                )
        return graph.RegisterSource(context=context, name=f'new {least}')

    for least in (1, 2, 9):
        made.clear()
        live.change(Change(change, then=lambda scene, source: scene.log.notes.append(source)))
        assert len(made) == min(least, 4)
        assert (made[-1] is None) == (least == 9)
        with live.editing() as scene:
            assert scene.log.notes == [scene.model.names.source(f'new {least}')]
            scene.log.notes.clear()


def test_frames_that_are_removed_by_a_draft_are_posed_no_more(live):
    with live.editing() as scene:
        source = scene.model.names.source('s')
    frames = drafted(live, lambda graph, on: graph.RemoveSource(on, source))
    with live.editing() as scene:
        scene.forget_source('s', frames)
        assert scene.poses.ages_by_name() == {}
        with pytest.raises(RuntimeError, match='no source'):
            scene.poses.take(message(a=0))
        assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == 0
