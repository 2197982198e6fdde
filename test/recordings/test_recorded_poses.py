"""A recording is played in the browser by the poses that it tells at each time."""

import argparse

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import CELL, balls, poses, random_rows  # noqa: F401

from drake_geom_ros.command_line import view
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings.recorded_poses import recorded_poses
from drake_geom_ros.viewing.timeline import least_distances


@pytest.fixture
def run(tmp_path):
    rows = random_rows(11, 2, seed=4)
    return recorder.record(tmp_path / 'run', poses(0.1 * np.arange(11), 'ab', rows)), rows


def test_poses_are_those_of_the_time(run, balls):  # noqa: F811
    place, rows = run
    found = recorded_poses(place, balls, 20.0)
    assert len(found) == 21
    for each in found:
        k = int(each.time / 0.1 + 1e-6)
        assert each.frames == (('s', 'a'), ('s', 'b'))
        np.testing.assert_array_equal(each.rows, rows[k])


def test_view_plays_a_recording(run, balls, monkeypatch):  # noqa: F811
    monkeypatch.setattr(view, 'Page', lambda *_, **given: given)
    monkeypatch.setattr(view, 'open_server', lambda *_: None)
    place, rows = run
    parser = argparse.ArgumentParser()
    view.add_to(parser.add_subparsers())
    options = ['view', str(place), '--scene', str(balls), '--rate', '10']
    timeline = view.open_page(parser.parse_args(options))['timeline']
    np.testing.assert_allclose(timeline.times, 0.1 * np.arange(11), rtol=0, atol=1e-9)
    told = timeline.poses(0.55)
    places = {tuple(told.value(frame).translation()) for frame in told.ids()}
    assert places == {tuple(row[:3]) for row in rows[5]}
    with pytest.raises(SystemExit):  # argparse refuses it
        view.open_page(parser.parse_args([*options, '--rate', '0']))


def opened(monkeypatch, *options):
    """Return what a page would be given."""
    monkeypatch.setattr(view, 'Page', lambda _, scene, **given: {'scene': scene, **given})
    monkeypatch.setattr(view, 'open_server', lambda *_: None)
    parser = argparse.ArgumentParser()
    view.add_to(parser.add_subparsers())
    return view.open_page(parser.parse_args(['view', *map(str, options)]))


def shown(page, time):
    """Return the names of frames that are shown at a time, and of those that wait."""
    page['scene'].pose_only(page['timeline'].poses(time))
    moment = page['scene'].moment(1.0, 'exact')
    return {name for _, name in page['scene'].poses()}, set(moment.geometries.waiting)


def test_what_the_recording_does_not_pose_is_not_shown(tmp_path, monkeypatch, capsys):
    """A robot stands nowhere, not even at rest, until its joint values come."""
    joints, tray = ('turn', 'bend', 'roll', 'slide'), (0.6, 0.1, 0.4, 0, 0, 0, 1)
    messages = poses(0.1 * np.arange(10), ['things::tray'], [tray] * 10)
    run = recorder.record(tmp_path / 'without', messages)
    page = opened(monkeypatch, run, '--scene', CELL)
    frames, waiting = shown(page, 0.0)
    assert 'tray' in frames
    assert {'upper', 'lower', 'hand'}.isdisjoint(frames)
    assert {'upper', 'lower', 'hand'} <= waiting
    assert page['joints'] is None
    assert 'turn' in capsys.readouterr().err
    snapshot = page['scene'].snapshot()
    assert np.isnan(list(least_distances(page['timeline'], snapshot))).all()

    for k in range(5, 10):
        t = 0.1 * k + 0.01
        messages.append((t, '/joint_states', recorder.joint_state(t, joints, [0.1] * 4)))
    messages.sort(key=lambda each: each[0])
    run = recorder.record(tmp_path / 'late', messages)
    page = opened(monkeypatch, run, '--scene', CELL)
    snapshot = page['scene'].snapshot()
    least = np.array(list(least_distances(page['timeline'], snapshot)))
    times = page['timeline'].times
    assert np.isnan(least[times < 0.5]).all()
    assert np.isfinite(least[times > 0.55]).all()
    for time, is_known in ((0.9, True), (0.2, False), (0.8, True)):
        frames, waiting = shown(page, time)
        assert ('hand' in frames) == is_known
        assert bool(waiting) != is_known
    with pytest.raises(ArgumentError, match='--joints'):
        opened(monkeypatch, run, '--scene', CELL, '--joints', 'turn=0.1')
