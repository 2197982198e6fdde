"""A recording is played in the browser by the poses that it tells at each time."""

import argparse

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import balls, poses, random_rows  # noqa: F401

from drake_geom_ros.command_line import view
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings.recorded_poses import recorded_poses


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
    np.testing.assert_allclose(timeline.times, 0.1 * np.arange(11), atol=1e-9)
    told = timeline.poses(0.55)
    places = {tuple(told.value(frame).translation()) for frame in told.ids()}
    assert places == {tuple(row[:3]) for row in rows[5]}
    with pytest.raises(ArgumentError, match='rate'):
        view.open_page(parser.parse_args([*options, '--rate', '0']))
