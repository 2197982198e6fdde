"""The whole run: its files, its verdict, its time."""

import csv
import math

import numpy as np
import pytest

from bench.accuracy import cases, run
from bench.accuracy.measuring import Measurement, Plan
from bench.accuracy.run import VIOLATED, Request
from drake_geom_ros.geometry import SignedDistanceResults
from truth.judging.asking import LEVELS


def tiny(folder, *patterns, peers=()):
    return Request(folder, peers, patterns or ('Sphere-Box',), quick=True, samples=1)


@pytest.fixture
def said():
    return []


def test_a_run_writes_all_its_files(tmp_path, said):
    assert run.run(tiny(tmp_path / 'new', 'Sphere-Box', 'Point-Box'), said.append) == 0
    assert {path.name for path in (tmp_path / 'new').iterdir()} == {
        'README.md', 'measurements.csv', 'levels.png', 'signed_distance.png',
        'points.png', 'penetration.png',
    }  # fmt: skip
    assert said[-1].startswith('all ')
    with (tmp_path / 'new/measurements.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert {row['library'] for row in rows} == {'drake_geom_ros'}
    assert {row['setting'] for row in rows} == set(LEVELS)
    exact = [row for row in rows if row['setting'] == 'exact']
    assert all(0.0 < float(row['seconds_per_pair']) < 0.01 for row in exact)
    assert all(float(row['error_worst']) < 1e-14 for row in exact)


def test_peers_are_measured_where_asked_for(tmp_path, said):
    assert run.run(tiny(tmp_path, 'Box-Box', peers=('python-fcl',)), said.append) == 0
    text = (tmp_path / 'README.md').read_text()
    assert '| python-fcl | own settings |' in text
    assert 'Smallest cost of a call [us]: python-fcl' in text


def test_a_bound_below_the_error_is_caught_and_named(tmp_path, said, monkeypatch):
    def lying(*arguments):
        return [
            answer and answer._replace(distance=answer.distance + 2 * answer.error_bound)
            for answer in ours(*arguments)
        ]

    ours = cases.certified
    monkeypatch.setattr(cases, 'certified', lying)
    assert run.run(tiny(tmp_path), said.append) == VIOLATED
    assert any(line.startswith('WRONG: Sphere-Box, signed_distance, exact') for line in said)
    assert (tmp_path / 'README.md').exists()


def test_a_bound_wider_than_the_promise_is_caught(tmp_path, said, monkeypatch):
    """What a query's own ``breaks_promise`` says, and no other measure of it."""
    broken = np.ones(1, dtype=bool)
    monkeypatch.setattr(SignedDistanceResults, 'breaks_promise', lambda found: broken)
    assert run.run(tiny(tmp_path), said.append) == VIOLATED
    (told, *_) = [line for line in said if line.startswith('WRONG')]
    assert told.endswith('m, wider than promised')


def test_what_was_measured_before_an_interrupt_is_written(tmp_path, said, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, 'measure', interrupted)
    assert run.run(tiny(tmp_path), said.append) == 0
    assert 'interrupted' in said[1]
    assert (tmp_path / 'measurements.csv').exists()


def test_what_there_is_no_time_for_is_named(said):
    measurement = Measurement(Plan(least_batches=1, turns=1), ())
    names = ('Sphere-HalfSpace', 'Sphere-Box', 'Box-Box')
    cases = [run.chosen(run.all_cases(), [name])[0] for name in names]
    run.measure(measurement, cases, -math.inf, said.append)
    assert {record.case for record in measurement.records} == {'Sphere-HalfSpace'}
    assert said[-1] == 'no time was left for Sphere-Box, Box-Box: give more with --minutes'
