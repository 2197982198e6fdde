"""Declared bodies that come and go: stale first, gone by declaration, and back again."""

from types import SimpleNamespace as Plain

import pytest
from live.inputs.tf_messages import at, message, take, transform
from live.scene.test_changes import call
from live.scene.test_scene_rules import Ruled
from ros.scene_calls import poses

from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.live.services.queries import get_pose_ages
from drake_geom_ros.proximity_rules import Why
from drake_geom_ros.scene_files import SceneFileError, read_scene, to_yaml

TEXT = """
sources: [arm, anna]
frames:
- {name: hand, source: arm, pose: {}}
- {name: torso, source: anna, gone_after: 3.0}
- {name: head, source: anna, gone_after: 3.0}
geometries:
- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: torso, source: anna, frame: torso, shape: {type: capsule, radius: 0.2, length: 0.6}}
- {name: head, source: anna, frame: head, shape: {type: sphere, radius: 0.15}}
filters:
- exclude_within: [torso, head]
proximity_rules:
- {name: person, set_a: arm, set_b: anna, level: stop, enter: 0.5, leave: 0.6}
"""
STALE_AFTER = 1.0


class Watched(Ruled):
    """A cell with a person, looked at again and again as a node does."""

    def __init__(self, text=TEXT):
        super().__init__(text, STALE_AFTER)

    def show(self, **places):
        """Pose frames of the person."""
        with self.live.editing() as scene:
            scene.poses.take(poses(list(places), list(places.values()), source='anna'))
            self.events.look_at(scene, None, 0.0)

    def after(self, seconds):
        """Return the events of some time, as names with why they were entered; None: left."""
        events = []
        for _ in range(round(seconds / 0.1)):
            with self.live.editing() as scene:
                scene.poses.take_out_silent(STALE_AFTER)
            before = len(self.topics.events.published)
            self.wait(0.1)
            for each in self.topics.events.published[before:]:
                rows = zip(each.entered, each.why, strict=True)
                events += [Why(why) if entered else None for entered, why in rows]
        return events

    def pairs(self):
        with self.live.reading() as scene:
            return len(scene.query.ComputeSignedDistancePairwiseClosestPoints())

    def state(self):
        with self.live.reading() as scene:
            (state,) = scene.rules.states()
        return state.why

    def waiting(self):
        return self.live.view().waiting().frames


@pytest.fixture
def cell():
    return Watched()


def test_who_never_came_is_waited_for_and_then_absent(cell):
    assert cell.after(2.5) == [Why.NO_POSE]
    assert cell.waiting() == ['anna::torso', 'anna::head']
    assert cell.after(1.0) == [None]
    assert cell.waiting() == []
    assert cell.pairs() == 0


def test_who_falls_silent_is_stale_first_then_gone_and_comes_again(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    assert cell.after(0.9) == []
    assert cell.after(1.0) == [Why.STALE]
    assert cell.pairs() == 2, 'a body that is late is where it was'
    assert cell.after(0.9) == []
    assert cell.after(1.0) == [None]
    assert cell.pairs() == 0
    assert cell.after(10.0) == []
    cell.show(torso=(0.4, 0, 0), head=(0.4, 0, 1))
    assert cell.pairs() == 2
    assert cell.state() == Why.NEAR


def test_a_part_that_is_hidden_while_another_is_seen_stays_and_is_stale(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    for _ in range(20):
        cell.show(torso=(5, 0, 0))
        cell.after(0.4)
    with cell.live.reading() as scene:
        assert scene.poses.visitors.absent == frozenset()
    assert cell.state() == Why.STALE
    assert cell.pairs() == 2


def test_of_who_comes_back_by_one_part_the_others_are_waited_for(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    cell.after(4.0)
    cell.show(torso=(5, 0, 0))
    assert cell.waiting() == ['anna::head']
    assert cell.state() == Why.NO_POSE
    cell.show(head=(5, 0, 1))
    assert cell.waiting() == []
    assert cell.state() is None


def test_who_leaves_and_comes_is_logged(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    cell.after(4.0)
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    with cell.live.editing() as scene:
        notes, _ = scene.log.take()
    assert notes == [
        'anna::head, anna::torso left: no message named it for 3 s (gone_after)',
        'anna::head, anna::torso came back',
    ]


def test_nobody_leaves_while_time_rests_or_because_it_jumps(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    cell.after(2.0)
    with cell.live.editing() as scene:
        scene.clocks.begin_anew()
        cell.clock.now += 100.0
        assert scene.poses.take_out_silent(STALE_AFTER) == []
        for _ in range(5):
            assert scene.poses.take_out_silent(STALE_AFTER) == []
    assert cell.after(2.9)[:1] in ([], [Why.STALE])
    assert cell.pairs() == 2
    cell.after(0.3)
    assert cell.pairs() == 0


def test_nobody_leaves_before_being_stale(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    cell.clock.now += 4.0
    with cell.live.editing() as scene:
        assert scene.poses.take_out_silent(5.0) == []
        assert len(scene.poses.take_out_silent(3.5)) == 2


def test_the_age_of_who_is_absent_is_unknown(cell):
    cell.after(4.0)
    answer = Plain(names=[], ids=[], ages=[], waiting=[], attached_to=[])
    call(cell.live, get_pose_ages, answer, frames=['anna::head'])
    assert (answer.ages, answer.waiting) == ([float('inf')], [True])
    with cell.live.reading() as scene:
        assert scene.moment().oldest.age == 0.0, 'nobody waits for an absent frame'


@pytest.mark.parametrize('seconds', [0.0, 4.0])
def test_a_saved_scene_declares_the_same(cell, seconds):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    cell.after(seconds)
    with cell.live.reading() as scene:
        described = scene.description()
    expected, saved = read_scene(TEXT), read_scene(to_yaml(described))
    assert saved.filters == expected.filters
    for before, after in zip(expected.frames, saved.frames, strict=True):
        assert (after.gone_after, after.name) == (before.gone_after, before.name)


def test_a_saved_scene_with_somebody_in_it_is_read_again(cell):
    cell.show(torso=(5, 0, 0), head=(5, 0, 1))
    with cell.live.reading() as scene:
        saved = to_yaml(scene.description())
    again = Watched(saved)
    assert again.waiting() == ['anna::torso', 'anna::head'], 'a visitor is not where one was'


def test_a_source_that_is_removed_is_no_visitor_any_more(cell):
    cell.after(4.0)
    with cell.live.editing() as scene:
        scene.make(removal(scene, scene.model.names.source('anna')))
        assert scene.poses.visitors.absent == frozenset()
        assert scene.poses.take_out_silent(STALE_AFTER) == []


@pytest.mark.parametrize('key', ['pose: {}', 'static: true', 'welded: true', 'attached_to: hand'])
def test_a_frame_that_is_placed_by_the_file_does_not_leave(key):
    text = TEXT.replace('gone_after: 3.0', f'gone_after: 3.0, {key}')
    with pytest.raises(SceneFileError, match='gone_after is of frames that messages or TF pose'):
        read_scene(text)


class Tf:
    """The same cell, posed by TF through a camera that moves."""

    def __init__(self):
        self.cell = Watched()
        self.tf = TfInput(self.cell.live.clocks)

    def send(self, *transforms, static=False):
        with self.cell.live.editing() as scene:
            take(self.tf, scene, message(*transforms), static=static)

    def camera(self, x):
        self.send(transform('world', 'camera', at(x), self.cell.clock.now))

    def person(self):
        now = self.cell.clock.now
        parts = [transform('camera', f'anna/{part}', at(5), now) for part in ('torso', 'head')]
        self.send(*parts)

    def is_absent(self):
        with self.cell.live.reading() as scene:
            return len(scene.poses.visitors.absent) == 2


def test_a_camera_that_moves_brings_nobody_back():
    tf = Tf()
    tf.camera(0)
    tf.person()
    for k in range(40):
        tf.cell.after(0.1)
        tf.camera(k)
    assert tf.is_absent()
    assert tf.cell.pairs() == 0
    tf.person()
    assert not tf.is_absent()
    assert tf.cell.pairs() == 2


def test_who_is_named_stays_though_the_camera_is_silent():
    tf = Tf()
    tf.camera(0)
    for _ in range(50):
        tf.person()
        tf.cell.after(0.1)
    assert not tf.is_absent()
    assert tf.cell.state() == Why.STALE


def test_who_is_named_stays_though_nobody_knows_where_the_camera_is():
    tf = Tf()
    for _ in range(50):
        tf.person()
        tf.cell.after(0.1)
    assert not tf.is_absent()
    assert tf.cell.waiting() == ['anna::torso', 'anna::head']


def test_a_static_transform_holds_for_good():
    tf = Tf()
    parts = [transform('world', f'anna/{part}', at(5)) for part in ('torso', 'head')]
    tf.send(*parts, static=True)
    tf.cell.after(10.0)
    assert not tf.is_absent()
    assert tf.cell.pairs() == 2
