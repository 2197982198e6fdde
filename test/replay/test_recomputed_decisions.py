"""Recorded proximity events: each is computed again, and what is not founded is told."""

import dataclasses
import math

import numpy as np
import pytest
from live.plain_messages import echoed
from live.scene.test_scene_rules import Ruled
from ros.scene_calls import poses

from drake_geom_ros.command_line.program import main
from drake_geom_ros.math import RollPitchYaw
from drake_geom_ros.proximity_rules import Why
from drake_geom_ros.replay import Finding, Judge, read_events
from drake_geom_ros.scene_files import SceneFileError, to_yaml

AXES = np.array([1.0, 1, 1, 0, 0, 0, 0])
SCENE = """
name: cell
sources: [arm]
frames:
- {name: hand, source: arm, static: false}
- {name: tray, source: arm, static: false}
geometries:
- {name: ball, source: arm, frame: hand, pose: {position: [0.1, 0, 0], rpy: [0.3, 0.2, 0.1]},
   shape: {type: ellipsoid, semi_axes: [0.1, 0.15, 0.2]}}
- {name: box, source: arm, frame: tray, shape: {type: box, size: [0.2, 0.3, 0.2]}}
- {name: post, shape: {type: cylinder, radius: 0.1, length: 1}}
- {name: floor, pose: {position: [0, 0, -0.6]}, shape: {type: half_space}}
proximity_rules:
- {name: near, set_a: hand, set_b: cell, level: warn, enter: 0.1, leave: 0.2}
- {name: stop, set_a: arm, level: stop, enter: 0.15, leave: 0.25}
- {name: soon, set_a: tray, set_b: post, level: slow, enter: 0.01, leave: 0.02,
   min_time_to_contact: 1.0}
"""


@pytest.fixture(scope='module', params=['exact', 'bound'])
def recording(request, tmp_path_factory):
    """Return the files of the events of a storm, and of the scene."""
    folder, rng = tmp_path_factory.mktemp('recorded'), np.random.default_rng(3)
    ruled = Ruled(SCENE)
    with ruled.live.editing() as scene:
        scene.poses.watch_motion(1.0)
        scene.set_accuracy(request.param)
    for cycle in range(200):
        ruled.wait(0.1 if cycle % 20 else 2.0)
        with ruled.live.editing() as scene:
            places = rng.uniform((-0.6, -0.6, -0.3), (0.6, 0.6, 0.9), (2, 3))
            turns = [RollPitchYaw(*rng.uniform(-3, 3, 3)).ToQuaternion() for _ in range(2)]
            wxyz = [q.wxyz() for q in turns]
            rows = np.hstack([places, np.roll(wxyz, -1, axis=1)])
            message = poses(['hand', 'tray'], rows, source='arm', stamp=int(ruled.clock.now))
            message.header.stamp.nanosec = int(1e9 * (ruled.clock.now % 1.0))
            scene.poses.take(message)
            ruled.events.look_at(scene, None, 0.0)
    with ruled.live.reading() as scene:
        (folder / 'scene.yaml').write_text(to_yaml(scene.description()))
    (folder / 'events.yaml').write_text(echoed(ruled.topics.events.published))
    return folder


def judged(folder, **changed):
    judge = Judge(folder / 'scene.yaml')
    events = [dataclasses.replace(e, **changed) for e in read_events(folder / 'events.yaml')]
    return [(event, judge.verdict(event)) for event in events]


def test_what_was_decided_is_founded(recording):
    all_judged = judged(recording)
    seen = {(e.why, e.entered) for e, v in all_judged if v.finding == Finding.FOUNDED}
    assert {(Why.NEAR, True), (Why.NEAR, False), (Why.SOON, True), (Why.STALE, True)} <= seen
    assert not [(e, v) for e, v in all_judged if v.finding == Finding.UNFOUNDED]
    untold = [e for e, v in all_judged if v.finding == Finding.NOT_TO_BE_TOLD]
    assert all(e.why == Why.NO_POSE or not (e.entered or e.has_pair) for e in untold)


def test_what_was_decided_without_a_reason_is_told(recording):
    of_pairs = [e for e, _ in judged(recording) if e.has_pair]
    judge = Judge(recording / 'scene.yaml')

    def findings(change):
        return {judge.verdict(change(event)).finding for event in of_pairs}

    def lower(event):
        return event.distance - event.error_bound

    def other_limits(event):
        if event.why == Why.SOON and event.entered:
            return dataclasses.replace(event, limit_time=0.0)
        wrong = lower(event) - 1e-9 if event.entered else lower(event) + 1e-9
        return dataclasses.replace(event, limit_distance=wrong)

    def nearer(event):
        lied = event.distance - 2.1 * event.error_bound - 1e-6
        return dataclasses.replace(event, distance=lied)

    def elsewhere(event):
        wide = 2.1 * event.error_bound + 1e-3
        return dataclasses.replace(event, pose_a=event.pose_a + wide * AXES)

    assert findings(other_limits) == {Finding.UNFOUNDED}
    assert findings(lambda e: dataclasses.replace(e, distance=math.nan)) == {Finding.UNFOUNDED}
    if all(e.accuracy == 'exact' for e in of_pairs):  # wide bounds may hold what is not so, too
        assert findings(nearer) == {Finding.UNFOUNDED}
        assert Finding.UNFOUNDED in findings(elsewhere)
    stale = [e for e, _ in judged(recording) if e.why == Why.STALE and e.entered]
    fresh = [dataclasses.replace(e, oldest_pose_age=e.limit_time) for e in stale]
    assert {judge.verdict(e).finding for e in fresh} == {Finding.UNFOUNDED}


def test_who_was_early_is_told(recording):
    all_judged = judged(recording)
    early = [v for _, v in all_judged if 'early by' in v.because]
    assert bool(early) == any(e.accuracy == 'bound' for e, _ in all_judged)


def test_the_program_prints_each_event_and_the_counts(recording, capsys):
    files = [str(recording / 'events.yaml'), '--scene', str(recording / 'scene.yaml')]
    assert main(['replay', *files]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.endswith('m, enter 0.1 m') and 'near: entered, near' in line for line in lines)
    assert ' 0 UNFOUNDED' in lines[-1]
    text = (recording / 'events.yaml').read_text()
    lied = recording / 'lied.yaml'
    lied.write_text(text.replace('limit_distance:\n- 0.1\n', 'limit_distance:\n- -9.0\n'))
    assert main(['replay', str(lied), *files[1:]]) == 1
    assert 'UNFOUNDED: lower bound' in capsys.readouterr().out


def test_events_that_are_missing_are_told(recording, capsys):
    whole = (recording / 'events.yaml').read_text().split('---\n')
    lost = recording / 'lost.yaml'
    numbers = [e.sequence for e in read_events(recording / 'events.yaml')]
    kept = [text for text in whole if '\n- 3\n' not in text.partition('rule:')[0]]
    assert 0 < len(kept) < len(whole)
    lost.write_text('---\n'.join(kept))
    gone = len(numbers) - len(read_events(lost))
    assert main(['replay', str(lost), '--scene', str(recording / 'scene.yaml')]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith('MISSING: events ') for line in lines)
    assert lines[-1].endswith(f', {gone} MISSING')


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('', 'no event'),
        ('a: [', 'not YAML'),
        ('a: 1', "no ProximityEvents message: KeyError: 'sequence'"),
        ('sequence: 3', 'no ProximityEvents message: TypeError'),
        ('[]', 'no ProximityEvents message'),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, text, told):
    path = tmp_path / 'events.yaml'
    path.write_text(text)
    with pytest.raises(SceneFileError, match=told):
        read_events(path)


def test_what_is_not_text_is_no_recording(tmp_path):
    (tmp_path / 'events.yaml').write_bytes(b'a: 1\n\x89PNG')
    with pytest.raises(SceneFileError, match=r'events\.yaml:2: byte 0x89 is not UTF-8'):
        read_events(tmp_path / 'events.yaml')


def test_a_scene_without_the_pair_is_another_one(recording, tmp_path):
    scene = tmp_path / 'scene.yaml'
    scene.write_text('name: other\n')
    event = next(e for e, _ in judged(recording) if e.has_pair)
    with pytest.raises(SceneFileError, match='scene_version of the event'):
        Judge(scene).verdict(event)
