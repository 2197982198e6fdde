"""An audit recomputes events about zones, which no query about the scene sees."""

import numpy as np
import pytest
from live.scene.test_zones import SCENE, Cell
from rclpy.serialization import serialize_message
from recordings import recorder
from ros.scene_calls import poses

from drake_geom_ros.recordings import Outcome, audit

EVENTS = 'drake_geom_msgs/msg/ProximityEvents'
PLACES = {0.1: (50, 0, 0), 0.3: (0.7, 0, 0.5), 0.6: (0.5, 1.5, 0.5), 0.9: (50, 0, 0)}
WAY = [(seconds, 'crate', place, 'scene') for seconds, place in PLACES.items()]


def posed(seconds, name, place, source):
    """Return a message that poses a frame, as a node takes it and as it is recorded."""
    message = poses([name], [place], source=source)
    time = recorder.stamp(seconds)
    message.header.stamp.sec, message.header.stamp.nanosec = time.sec, time.nanosec
    row = [*map(float, place), 0.0, 0.0, 0.0, 1.0]
    return message, recorder.frame_poses(seconds, [name], row, source)


def as_recorded(message, kind):
    """Return a message of ROS as the recorder takes it."""
    return recorder.store().deserialize_cdr(serialize_message(message), kind)


def run_of_zones():
    """Return what is recorded while a crate goes through zones: (seconds, topic, message)."""
    cell, run = Cell(), []
    with cell.live.editing() as scene:
        table = recorder.scene_of(scene.model.scene_graph)
    for seconds, name, place, source in ((0.05, 'base_link', (0, 0, 0), 'base'), *WAY):
        told = len(cell.topics.events.published)
        cell.clock.now = 1e-9 * recorder.BEGIN + seconds
        message, recorded = posed(seconds, name, place, source)
        run.append((seconds, '/node/frame_poses', recorded))
        with cell.live.editing() as scene:
            scene.poses.take(message)
            if name == 'crate':
                cell.events.look_at(scene, None, 0.0)
        for event in cell.topics.events.published[told:]:
            raw = as_recorded(event, EVENTS)
            table.names_version = raw.names_version
            run.append((seconds + 0.05, '/node/proximity_events', raw))
    return [(0.0, '/node/scene', table), *run]


@pytest.fixture
def file(tmp_path):
    file = tmp_path / 'zones.yaml'
    file.write_text(SCENE)
    return file


def test_events_about_zones_are_confirmed(tmp_path, file):
    run = recorder.record(tmp_path / 'run', run_of_zones())
    audited = audit(run, file)
    entered, left = audited.entries[:2], audited.entries[2:]
    assert [entry.outcome for entry in entered] == [Outcome.SAME] * 2, entered
    assert {entry.because for entry in left} == {'no pair was near enough to be looked at'}
    assert len(left) == 2
    assert audited.reservations() == []


@pytest.mark.parametrize('error', [-0.01, 1e-9])
def test_a_false_event_about_a_zone_is_refuted(tmp_path, file, error):
    messages = run_of_zones()
    event = next(each for _, _, each in messages if each.__msgtype__ == EVENTS and each.entered[0])
    event.distance = np.array(event.distance) + error
    audited = audit(recorder.record(tmp_path / 'run', messages), file)
    refuted = [entry for entry in audited.entries if entry.outcome == Outcome.REFUTED]
    assert len(refuted) == len(event.rule)
