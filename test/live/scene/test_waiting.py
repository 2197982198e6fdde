"""Names and flags of what waits are made once, and are never those of another question."""

from types import SimpleNamespace as Plain

from live.live_scenes import live_scene

from drake_geom_ros.geometry import FrameId, FramePoseVector
from drake_geom_ros.live.scene.bound_rules import FlagsOnFrames
from drake_geom_ros.live.scene.waiting import Waiting, WaitingNames
from drake_geom_ros.math import RigidTransform

A, B = FrameId.get_new_id(), FrameId.get_new_id()
TABLE = Plain(frame_names={A: 's::a', B: 's::b'})
OTHER = Plain(frame_names={A: 's::a', B: 's::other'})
TEXT = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}]
geometries:
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
"""


def test_names_hang_on_frames_names_and_absent_frames_alone():
    names = WaitingNames()
    assert names.of([], TABLE) == []
    first = names.of([A, B], TABLE)
    assert first == ['s::a', 's::b']
    assert names.of([A, B], TABLE) is first
    assert names.of([A, B], OTHER) == ['s::a', 's::other']
    assert names.of([B], OTHER) == ['s::other']
    assert names.of([B], OTHER, frozenset([B.get_value()])) == []
    assert names.of([A, B], OTHER, frozenset([B.get_value()])) == ['s::a']
    assert names.of([A, B], TABLE) == first == ['s::a', 's::b']


def test_messages_have_the_names_of_the_last_one():
    message = Plain()
    names = ['s::a']
    Waiting(names, 1, 1).tell_pairs(message)
    assert (message.waiting_frames, message.waiting_pairs) == (['s::a'], 1)
    assert message.waiting_frames is names
    Waiting(['s::b'], 2, 1).tell_pairs(message)
    assert (message.waiting_frames, message.waiting_pairs) == (['s::b'], 2)
    Waiting([], 0, 0).tell_pairs(message)
    assert (message.waiting_frames, message.waiting_pairs) == ([], 0)


def test_flags_hang_on_frames_and_rows_alone():
    flags, rows = FlagsOnFrames(), {7: [0, 2], 8: [1]}
    assert flags.of((), rows, 3).tolist() == [False, False, False]
    first = flags.of({7}, rows, 3)
    assert first.tolist() == [True, False, True]
    assert flags.of({7}, rows, 3) is first
    assert flags.of({7, 9}, rows, 3).tolist() == [True, False, True]
    assert flags.of({8}, rows, 3).tolist() == [False, True, False]
    assert flags.of({8}, {8: [0]}, 1).tolist() == [True]
    assert flags.of({}, {8: [0]}, 1).tolist() == [False]
    assert first.tolist() == [True, False, True]
    assert not first.flags.writeable
    growing = {8}
    flags.of(growing, rows, 3)
    growing.add(7)  # a set that its owner changes is another one
    assert flags.of(growing, rows, 3).all()


def test_a_scene_names_who_waits_now():
    live = live_scene(TEXT)
    with live.editing() as scene:
        a, b = scene.model.names.frame('a'), scene.model.names.frame('b')
        values = {a.get_value(), b.get_value()}
        assert scene.waiting().frames == ['s::a', 's::b']
        blind = scene.blind_frames(1.0)
        assert (blind.stale, blind.absent) == (values, values)
        assert scene.blind_frames(1.0).absent is blind.absent
        scene.model.context.UpdateFramePoses(FramePoseVector({a: RigidTransform()}))
        assert scene.waiting().frames == ['s::b']
        assert scene.blind_frames(1.0).absent == {b.get_value()}
        scene.model.context.UnposeFrames([a])
        assert scene.waiting().frames == ['s::a', 's::b']
        assert scene.blind_frames(1.0).absent == values
